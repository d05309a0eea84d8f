"""Harmonic balance of a body: derivatives against differences, masses against the balance of an
exact reduced model, and a beam against its own time steps as these get shorter.
"""

from dataclasses import replace

import numpy as np
import periodic_systems as systems
import pytest
from periodic_beam import CASES, beam, periodic

from vibrom.solvers.periodic.balanced_body import BodyBalance, Unbalanced
from vibrom.solvers.periodic.continuation import Pace, at
from vibrom.solvers.periodic.equations import from_rest, in_frequency
from vibrom.solvers.periodic.harmonic_balance import HarmonicBalance

FREQUENCY, FORCE = 1500.0, 2e5  # of the beam: its tip moves by half of its height


def balance(flow, harmonics):
    return BodyBalance(flow.term, flow.rest, flow.symmetry, harmonics)


@pytest.mark.parametrize("name", CASES)
def test_derivatives_are_those_of_the_residual(name):
    """To the differences' own error: forces are cubic, and a stop has edges."""
    extra, settings = CASES[name]
    flow = beam(extra, **{key: value for key, value in settings.items() if key == "mirrored"})
    body, random = balance(flow, 3), np.random.default_rng(0)
    x, along = random.standard_normal((2, body._first[-1]))
    x, along = 1e-3 * x, 1e-8 * along
    rows, columns, values = body._derivative(x, FREQUENCY)
    found = np.bincount(rows, values * along[columns], len(x))
    ahead, behind = (body.residual(x + sign * along, FREQUENCY, FORCE) for sign in (1, -1))
    assert np.linalg.norm(found - 0.5 * (ahead - behind)) < 1e-4 * np.linalg.norm(found)
    nudge = 1e-6 * FREQUENCY
    ahead, behind = (body.residual(x, FREQUENCY + sign * nudge, FORCE) for sign in (1, -1))
    found = 2 * nudge * body._by_frequency(x, FREQUENCY)
    assert np.linalg.norm(found - (ahead - behind)) < 1e-4 * np.linalg.norm(found)


def test_masses_balance_as_their_exact_model_does():
    """Both leave out the same harmonics."""
    flow, body = (made(**systems.TWO) for made in (systems.reduced, systems.full_order))
    flow, body = flow.return_map(), body.return_map()
    pace = Pace(0.04, newton=True)
    start = from_rest(flow, 0.72, 0.06)
    for harmonics in (1, 3, 5):
        other = HarmonicBalance(flow, harmonics)
        guess = other.of_point(start, 0.72, 0.06)
        x = at(in_frequency(other, 0.06), guess, 0.72, pace).x
        swing = other.swings(x[None], np.array([0.72]), np.array([0.06]))[0].displacement
        own = balance(body, harmonics)
        found = own.solve(flow.states(start, 0.72, 0.06)[:, :2], 0.72, 0.06)
        np.testing.assert_allclose(own.path(found.x, swing.shape[1]).T, swing, atol=1e-7)


def test_time_steps_approach_it_with_their_order():
    """The beam, whose second half of a period mirrors the first, or is not known to."""
    paths = []
    for steps in (200, 400):
        flow = beam(steps=steps)
        flow = replace(flow, newmark=replace(flow.newmark, alpha=0.0))
        x = periodic(flow, FREQUENCY, FORCE)
        paths.append(flow.states(x, FREQUENCY, FORCE)[:: steps // 200, : flow.term.size])
    body = balance(flow, 15)
    found = body.solve(paths[1], FREQUENCY, FORCE)
    exact = body.path(found.x, 200)
    assert np.abs(exact).max() > 0.04
    errors = [np.abs(path - exact).max() for path in paths]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)
    whole = balance(replace(flow, symmetry=None), 15)
    again = whole.path(whole.solve(paths[1], FREQUENCY, FORCE).x, 200)
    np.testing.assert_allclose(again, exact, atol=1e-7 * np.abs(exact).max())
    # What is said to be missing is what is.
    rough = balance(flow, 5)
    motion = rough.solve(paths[1], FREQUENCY, FORCE)
    more = balance(flow, 7).change(rough.path(motion.x, 200), FREQUENCY, FORCE)
    off = np.linalg.norm(rough.path(motion.x, 200) - exact) / np.linalg.norm(exact)
    assert 0.3 * off < more < 3.0 * off


def test_a_held_phase_finds_the_frequency():
    """A motion of another frequency, near a fold: its phase belongs to one frequency."""
    flow = systems.full_order(**systems.TWO).return_map()
    body, load = balance(flow, 9), flow.term.load
    x = at(in_frequency(flow, 0.06), from_rest(flow, 0.72, 0.06), 0.72, Pace(0.04)).x
    path = flow.states(x, 0.72, 0.06)[:, :2]
    found = body.solve(path, 0.71, 0.06, hold=True)
    # The steps shift frequencies by their square.
    assert found.frequency == pytest.approx(0.72, rel=1e-4)
    first = np.fft.rfft(body.path(found.x, len(path)) @ load)[1]
    assert np.angle(first / np.fft.rfft(path @ load)[1]) == pytest.approx(0.0, abs=1e-9)


def test_where_nothing_balances_it_says_so():
    flow = beam()
    noise = np.random.default_rng(0).standard_normal((32, flow.term.size))
    with pytest.raises(Unbalanced, match="changes of"):
        balance(flow, 3).solve(noise, FREQUENCY, FORCE)
    far = np.zeros(flow.size)
    assert flow.opinion(far, 1e-3 * FREQUENCY, 1e9, 3) is None
