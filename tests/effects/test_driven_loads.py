"""Loads with factors and signals of their own, through a linear beam."""

import numpy as np
import pytest
from scenes import LINEAR, body
from scipy.linalg import eigh
from scipy.signal import lsim

from vibrom import effects
from vibrom.bodies import space
from vibrom.signals import total
from vibrom.solvers.full.batch import Further
from vibrom.solvers.full.newmark import Newmark

TIP = {"at": [1.0, 0.1], "direction": "y"}
STIRRED = {
    "base_motion": {"direction": "y", "factor": 3.0},
    "point_load": [{**TIP, "factor": -20.0}, {**TIP, "at": [0.5, 0.1], "direction": "x"}],
}


def beam(signals=None):
    """Four elements; with `signals`, one of them for each load."""
    listed = {**LINEAR, "rayleigh_damping": {"damping_ratio": 0.02}}
    for name, entry in STIRRED.items():
        every = entry if isinstance(entry, list) else [entry]
        if signals is not None:
            every = [one | {"signal": signals.pop(0)} for one in every]
        listed[name] = every
    return effects.assemble(space.build(body(cells=[4, 1], height=0.1)), listed)


def test_factors_weigh_the_loads_that_one_signal_drives():
    made = space.build(body(cells=[4, 1], height=0.1))
    single = {
        name: effects.assemble(made, {**LINEAR, name: entry}).load
        for name, entry in (
            ("base_motion", {"direction": "y"}),
            ("point_load", TIP),
        )
    }
    along = effects.assemble(made, {**LINEAR, "point_load": STIRRED["point_load"][1]}).load
    expected = 3.0 * single["base_motion"] - 20.0 * single["point_load"] + along
    np.testing.assert_allclose(beam().load, expected, rtol=1e-14)


def test_loads_with_signals_are_none_that_the_experiments_drive():
    made = beam([{"step": {}}, {"step": {}}, {"step": {"size": 2.0}}])
    assert made.load is None and len(made.driven) == 3
    np.testing.assert_allclose(sum(one.load for one in made.driven), beam().load, rtol=1e-14)
    assert made.driven[2].signal == {"step": {"size": 2.0}}


@pytest.mark.parametrize(("widest", "steps"), [(500, 6000), (0, 1200)])
def test_a_chirp_and_a_blow_through_a_beam_are_the_sum_over_its_modes(widest, steps):
    """Each mode by SciPy's simulation, exact for signals that are linear between steps; in the band
    and with a sparse tangent. The chirp passes the first mode, 40 steps to a period of the second:
    the time steps shift that one by (omega h)^2/24 = 1e-3 over ten periods of memory.
    """
    omega = np.sqrt(eigh(beam().stiffness.toarray(), beam().mass.toarray())[0])
    period = 2 * np.pi / omega[0]
    chirp = {"first": 0.5 * omega[0], "last": 1.5 * omega[0], "duration": 12 * period}
    blow = {"pulse": {"duration": 0.3 * period, "begin": 2.0 * period, "size": 5.0}}
    term = beam([{"chirp": chirp}, blow, {"step": {"rise": period}}])
    h = period / 400
    time = h * np.arange(steps + 1)
    values = np.array([total(one.signal)(time) for one in term.driven])
    loads = np.array([one.load for one in term.driven])
    run = Newmark(widest_band=widest, tolerance=1e-9).run(
        term,
        np.zeros((term.size, 1)),
        np.array([h]),
        steps,
        more=Further(loads, values[:, :, None]),
    )
    squares, modes = eigh(term.stiffness.toarray(), term.mass.toarray())
    true = np.zeros((steps + 1, term.size))
    for square, mode in zip(squares, modes.T):
        drag = mode @ (term.damping @ mode)
        push = (mode @ loads.T) @ values
        true += np.outer(lsim(([1.0], [1.0, drag, square]), push, time)[1], mode)
    assert np.abs(run.displacement[0] - true).max() < 5e-3 * np.abs(true).max()
