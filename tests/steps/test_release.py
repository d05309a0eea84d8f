"""Release states against an integration of the same sweep by SciPy."""

from dataclasses import replace

import numpy as np
import pytest
import two_dofs
from scipy.integrate import solve_ivp

from vibrom.artefacts.data import DataError
from vibrom.config.scene import Release, Sweep, Velocity
from vibrom.models.model import Watch
from vibrom.steps.release import displaced, swept, thrown, turning_point

FORCING = 0.3
SWEEP = Sweep(frequencies=(0.9, 1.1), periods=4)


def reference():
    """Displacement and velocity (steps + 1, 2) in the last period of the sweep."""
    model, state = two_dofs.full_order(), np.zeros(4)
    pull = np.linalg.solve(two_dofs.MASS, two_dofs.STIFFNESS)
    push = FORCING * np.linalg.solve(two_dofs.MASS, two_dofs.LOAD)
    for ratio in SWEEP.frequencies:
        omega = ratio * model.frequency
        period = 2.0 * np.pi / omega

        def rate(t, x, omega=omega):
            q, v = x[:2], x[2:]
            return [*v, *(push * np.sin(omega * t) - two_dofs.DAMPING * v - pull @ q)]

        part = np.arange(model.steps_per_period + 1) / model.steps_per_period
        last = period * (SWEEP.periods - 1 + part)
        run = solve_ivp(rate, (0.0, last[-1]), state, t_eval=last, rtol=1e-10, atol=1e-12)
        state = run.y[:, -1]
    return run.y[:2].T, run.y[2:].T


def test_a_sweep_carries_the_motion_on():
    q, v = reference()
    motion = swept(two_dofs.full_order(), "train", FORCING, SWEEP, {})
    # Eight periods of a phase error of (omega h)^2/24 each, h = T/400: a thousandth in all.
    for found, true in ((motion.displacement[0], q), (motion.velocity[0], v)):
        assert np.abs(found - true).max() < 2e-3 * np.abs(true).max()


def test_two_sweeps_that_begin_alike_are_run_once_as_far_as_that():
    longer, legs = Sweep(frequencies=(0.9, 1.1, 1.2), periods=4), {}
    swept(two_dofs.full_order(), "train", FORCING, SWEEP, legs)
    motion = swept(two_dofs.full_order(), "test", FORCING, longer, legs)
    alone = swept(two_dofs.full_order(), "test", FORCING, longer, {})
    assert len(legs) == 3 and np.array_equal(motion.displacement, alone.displacement)


def test_it_is_released_where_it_turns_on_the_side_of_the_load():
    q, v = reference()
    speed = np.where(q @ two_dofs.LOAD > 0.0, np.linalg.norm(v, axis=1), np.inf)
    found = turning_point(two_dofs.full_order(), "train", FORCING, SWEEP, {})
    assert found @ two_dofs.LOAD > 0.0
    assert np.abs(found - q[speed.argmin()]).max() < 2e-3 * np.abs(q).max()


def test_what_the_load_holds_is_released():
    held = displaced(two_dofs.full_order(), "train", Release(forcing=FORCING, static=True), {})
    expected = FORCING * np.linalg.solve(two_dofs.STIFFNESS, two_dofs.LOAD)
    np.testing.assert_allclose(held, expected, rtol=1e-9)


def test_a_velocity_is_that_of_all_points_or_has_the_shape_of_a_mode():
    model = replace(two_dofs.full_order(), axis=np.array([1, 0]))
    fall = thrown(model, "train", Velocity(speed=-2.0, direction="y"), two_dofs.MODES)
    np.testing.assert_array_equal(fall, [-2.0, 0.0])
    swing = thrown(model, "train", Velocity(speed=3.0, mode=2), two_dofs.MODES)
    np.testing.assert_allclose(swing, 3.0 * two_dofs.MODES[1] / two_dofs.MODES[1, 0])
    assert not thrown(model, "train", None, two_dofs.MODES).any()
    assert not displaced(model, "train", Release(velocity=Velocity(speed=1.0, mode=1)), {}).any()


@pytest.mark.parametrize(
    ("given", "words"),
    [({"direction": "z"}, "none in which the body moves"), ({"mode": 3}, "one of the first 2")],
)
def test_a_velocity_that_cannot_be_is_one_line(given, words):
    model = replace(two_dofs.full_order(), axis=np.array([1, 0]))
    with pytest.raises(DataError, match=words):
        thrown(model, "train", Velocity(speed=1.0, **given), two_dofs.MODES)


def test_a_body_that_is_thrown_in_a_mode_swings_as_that_mode():
    """z = v/b e^(-a t) sin b t, within the time steps' (omega h)^2/24 of a phase."""
    model = replace(two_dofs.full_order(), axis=np.array([1, 0]))
    start = thrown(model, "train", Velocity(speed=3.0, mode=1), two_dofs.MODES)
    time = np.arange(101) / 50 * model.period
    state = np.concatenate([np.zeros(2), start])[None]
    found = model.motion(state, None, Watch(time)).displacement[0][0]
    a, b = two_dofs.RATIOS[0] * two_dofs.FREQUENCIES[0], two_dofs.DAMPED
    true = np.outer(np.exp(-a * time) * np.sin(b * time) / b, start)
    assert np.abs(found - true).max() < 1e-3 * np.abs(true).max()
