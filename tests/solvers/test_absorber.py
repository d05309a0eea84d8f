"""A curve of two degrees of freedom that others published: a Duffing oscillator with a nonlinear
tuned absorber, example 02 of NLvib 1.3 (Krack and Gross, Harmonic Balance for Nonlinear Vibration
Problems, 2019; https://github.com/maltekrack/NLvib), which names its turning points and its
Neimark-Sacker bifurcations. Numbers: what NLvib under Octave and a Python port of it, each with
seven harmonics and points of its own, print at the highest points of their curves,
https://github.com/julianjurai/NLvib-py, examples/comparison/02_two_dof_cubic.ipynb (007c99f).
"""

import numpy as np
import periodic_systems as systems
import pytest

from vibrom.solvers.periodic.continuation import Pace, at
from vibrom.solvers.periodic.equations import from_rest, in_frequency
from vibrom.solvers.periodic.harmonic_balance import HarmonicBalance
from vibrom.solvers.periodic.response import Span, response
from vibrom.solvers.periodic.stability import Kind

FORCE = 0.11
PACE = Pace(0.06, newton=True)
# frequency, printed to 5e-5: root mean square of both displacements, harmonics 1, 3, 5 of the first
OCTAVE = {1.0278: (0.41849, None, 0.59178, 0.00799, 0.00008), 1.0337: (None, 1.71678)}
PYTHON = {1.0283: (0.41846, None, 0.59173, 0.00799, 0.00008), 1.0352: (None, 1.71701)}


@pytest.fixture(scope="module", params=["shooting", "harmonic_balance"])
def flow(request):
    shot = systems.reduced(**systems.ABSORBER).return_map()
    return shot if request.param == "shooting" else HarmonicBalance(shot, 7)


def shown(swing):
    """Root mean squares of both masses, harmonics 1, 3, 5 of the first."""
    first, second = swing.displacement[0], swing.displacement[0] - swing.displacement[1]
    waves = 2.0 * np.abs(np.fft.rfft(first)) / len(first)
    return [np.sqrt(np.mean(first**2)), np.sqrt(np.mean(second**2)), *waves[[1, 3, 5]]]


@pytest.mark.parametrize("printed", [OCTAVE, PYTHON])
def test_motions_are_those_that_were_printed(flow, printed):
    """To the last digit printed, and what half a digit of the frequency changes."""
    curve = in_frequency(flow, FORCE)
    for frequency, expected in printed.items():
        near = frequency + np.array([0.0, -5e-5, 5e-5])
        points = [at(curve, from_rest(flow, one, FORCE), one, PACE) for one in near]
        found = np.array([shown(curve.swings(p.x[None], np.array([p.p]))[0]) for p in points])
        for value, seen in zip(expected, found.T):
            if value is not None:
                assert abs(value - seen[0]) <= 0.51e-5 + np.abs(seen - seen[0]).max()


def test_the_curve_turns_and_loses_stability_as_described(flow):
    """Two turning points, two Neimark-Sacker bifurcations; nothing else between .8 and 1.4."""
    found = response(in_frequency(flow, FORCE), Span(0.8, 1.4, 300, 1e-3), PACE)
    kinds = [item.orbit.kind for item in found]
    assert kinds.count(Kind.FOLD) == 2 and kinds.count(Kind.TORUS) == 2
    assert set(kinds) == {Kind.REGULAR, Kind.FOLD, Kind.TORUS, Kind.END}
    # No printed point is above the first mass's peak, which is near the highest of them.
    top = max(shown(item.swing)[0] for item in found)
    assert 0.41849 - 0.5e-5 < top < 0.41849 + 5e-5
