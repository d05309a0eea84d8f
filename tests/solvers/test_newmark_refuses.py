"""Newmark where there is no motion: steps that do not converge, bodies without mass, arguments that
do not fit.
"""

import numpy as np
import pytest
from scenes import LINEAR, body

from vibrom import effects
from vibrom.artefacts.outcome import Outcome
from vibrom.bodies import space
from vibrom.solvers.full.newmark import Newmark, Record
from vibrom.term import SceneError


def test_failed_convergence_has_a_time_and_spoils_no_other(cantilever):
    made, term = cantilever
    # Two steps a period of a load that folds the beam: Newton's method cannot follow it.
    signal = np.stack([np.full(60, 1e-3), np.full(60, 5e7), np.full(60, 1e-3)], axis=1)
    motion = Newmark(max_iterations=8).run(
        term, np.zeros((made.size, 3)), np.full(3, 8e-3), 59, signal=signal
    )
    assert motion.outcomes == ["ok", "no_convergence", "ok"]
    assert 0 < motion.failed_at[1] <= 59 * 8e-3
    failed = round(motion.failed_at[1] / 8e-3)
    assert (
        np.isnan(motion.displacement[1, failed:]).all()
        and np.isfinite(motion.displacement[[0, 2]]).all()
    )


WRONG = {
    "displacement": ({"displacement": np.zeros(240)}, r"\(240,\); .* \(n, states\) = \(240, 1\)"),
    "velocity": ({"velocity": np.zeros((240, 2))}, r"\(240, 2\); .* \(n, states\) = \(240, 3\)"),
    "step": ({"step": np.full(1, 1e-5)}, r"\(1,\); .* \(states,\) = \(3,\)"),
    "signal": (
        {"signal": np.zeros((5, 3))},
        r"\(5, 3\); needed is \(steps \+ 1, states\) = \(6, 3\)",
    ),
    "record.probes": ({"record": Record(probes=np.array([3, 240]))}, "240; needed are dofs from 0"),
    "record": ({"record": Record(every=0)}, "every = 0"),
    "steps": ({"steps": -1}, "-1; needed"),
    "initial_acceleration": ({"initial_acceleration": "none"}, "'none' .*equilibrium, zero"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_does_not_fit_is_named(name, cantilever):
    """Compiled code would read beyond its arrays."""
    given, message = WRONG[name]
    fitting = {"displacement": np.zeros((240, 3)), "step": np.full(3, 1e-5), "steps": 5}
    with pytest.raises(ValueError, match=rf"^{name} ?(has|=|:) .*{message}"):
        Newmark().run(cantilever[1], **{**fitting, **given})


def test_a_scene_without_mass_does_not_move():
    made = space.build(body(cells=[2, 1]))
    term = effects.assemble(made, {"elasticity": LINEAR["elasticity"]})
    with pytest.raises(SceneError, match="effects has no inertia.*list inertia"):
        Newmark().run(term, np.zeros((made.size, 1)), np.array([1e-5]), 1)


def test_nodes_without_mass_have_no_acceleration_of_equilibrium():
    """A mass at the tip alone: from rest the acceleration may be zero, and is then of no weight."""
    made = space.build(body(cells=[2, 1]))
    term = effects.assemble(
        made,
        {
            "elasticity": LINEAR["elasticity"],
            "tip_mass": {"at": [1.0, 0.0], "mass": 1.0},
        },
    )
    start, step = np.zeros((made.size, 1)), np.array([1e-5])
    with pytest.raises(SceneError, match="some node has no mass.*list inertia, or choose"):
        Newmark().run(term, start, step, 1)
    motion = Newmark().run(term, start, step, 1, initial_acceleration="zero")
    assert not motion.displacement.any()


@pytest.mark.parametrize("settings", [{}, {"widest_band": 0}])
def test_a_load_beyond_all_numbers_is_no_motion(settings, cantilever):
    """The squares of its entries are infinite, and infinity is not above infinity."""
    _, term = cantilever
    signal = np.full((6, 1), 1e300)
    start, step = np.zeros((term.size, 1)), np.array([1e-5])
    motion = Newmark(**settings, max_iterations=3).run(
        term, start, step, 5, signal=signal, initial_acceleration="zero"
    )
    assert motion.outcomes == [Outcome.NO_CONVERGENCE] and motion.failed_at == [1e-5]


@pytest.mark.parametrize("effect", [{}, {"geometric_nonlinearity": {}}])
def test_no_step_keeps_the_start(effect):
    made = space.build(body(cells=[2, 1]))
    start = 1e-3 * np.ones((made.size, 2))
    motion = Newmark().run(
        effects.assemble(made, {**LINEAR, **effect}),
        start,
        np.full(2, 1e-5),
        0,
        record=Record(probes=np.array([1])),
    )
    np.testing.assert_array_equal(motion.displacement, start.T[:, None])
    np.testing.assert_array_equal(motion.probes, start.T[:, 1:2, None])
