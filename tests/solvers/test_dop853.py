"""The side-by-side Runge-Kutta method against closed forms and SciPy's one-by-one one."""

import numpy as np
from scipy.integrate import solve_ivp

from vibrom.solvers.reduced.dop853 import integrate

WIDE = np.array([1e6, 1e6])


def oscillator(t, y, run):
    return np.stack([y[:, 1], -y[:, 0]], axis=1)


def duffing(t, y, run):
    return np.stack(
        [y[:, 1], -y[:, 0] - y[:, 0] ** 3 - 0.1 * y[:, 1] + (0.5 + 0.1 * run) * np.sin(1.1 * t)],
        axis=1,
    )


def solve(field, start, times, rtol=1e-9, atol=1e-12, **options):
    settings = (
        dict(first_step=np.array(0.05), reach=WIDE, limit=10 * WIDE, max_steps=100_000) | options
    )
    return integrate(field, start, times, rtol=rtol, atol=np.full(2, atol), **settings)


def test_oscillator_at_any_instant():
    times = np.sort(np.random.default_rng(0).uniform(0, 50, (3, 400)), axis=1)
    start = np.array([[1.0, 0.0], [0.0, 2.0], [-3.0, 1.0]])
    result = solve(oscillator, start, times)
    exact = np.stack(
        [
            start[:, :1] * np.cos(times) + start[:, 1:] * np.sin(times),
            start[:, 1:] * np.cos(times) - start[:, :1] * np.sin(times),
        ],
        axis=-1,
    )
    # Global error: the tolerance times the fifty radians, with a margin of ten; the interpolant is
    # of order seven.
    assert np.abs(result.samples - exact).max() < 1e-9 * 50 * 10
    assert list(result.outcome) == ["ok"] * 3


def test_error_falls_with_the_tolerance():
    times, errors, steps = np.array([[20.0]]), [], []
    for rtol in (1e-4, 1e-6, 1e-8, 1e-10):
        result = solve(oscillator, np.array([[1.0, 0.0]]), times, rtol=rtol, atol=rtol)
        errors.append(abs(result.samples[0, 0, 0] - np.cos(20.0)))
        steps.append(result.steps)
    # Order eight: error ~ steps^-8, so the slope of log error over log steps is about -8; the
    # controller wastes some.
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert -12 < slope < -6.5


def test_each_run_is_what_it_is_alone():
    starts, times = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, -1.0]]), np.linspace(0, 30, 200)
    together = solve(duffing, starts, np.repeat(times[None], 3, axis=0))
    for index, start in enumerate(starts):
        alone = solve(lambda t, y, run: duffing(t, y, np.array([index])), start[None], times[None])
        # The same steps; matrix products of other sizes may round the last digit differently, and
        # the motion carries that on.
        np.testing.assert_allclose(together.samples[index], alone.samples[0], rtol=0, atol=1e-10)
        peer = solve_ivp(
            lambda t, y: duffing(t, y[None], np.array([index]))[0],
            (0, 30),
            start,
            method="DOP853",
            t_eval=times,
            rtol=1e-11,
            atol=1e-13,
        )
        np.testing.assert_allclose(together.samples[index], peer.y.T, atol=1e-6)


def test_a_blow_up_ends_one_run_and_no_other():
    def field(t, y, run):
        return np.where(run[:, None] == 0, y**2, -y)

    result = solve(
        field,
        np.array([[1.0, 1.0], [1.0, 1.0]]),
        np.linspace(0, 2, 50)[None].repeat(2, axis=0),
        reach=np.full(2, 5.0),
        limit=np.full(2, 50.0),
    )
    # dy/dt = y^2 from 1 is 1/(1 - t): 5 at t = 0.8, 50 at t = 0.98.
    assert list(result.outcome) == ["diverged", "ok"]
    assert 0.8 <= result.left_at[0] <= 1.0 and 0.98 <= result.ended_at[0] <= 1.0
    assert np.isfinite(result.last).all() and np.isnan(result.samples[0, -1]).all()
    np.testing.assert_allclose(result.samples[1, :, 0], np.exp(-np.linspace(0, 2, 50)), rtol=1e-8)


def test_a_step_that_vanishes_is_an_outcome():
    def field(t, y, run):
        return np.where(t[:, None] < 0.5, 1.0, np.nan) * np.ones_like(y)

    result = solve(field, np.array([[0.0, 0.0]]), np.array([[0.1, 1.0]]))
    assert result.outcome[0] == "step_underflow"
    # A step may end a shade before the wall, never beyond it.
    assert 0.49 < result.ended_at[0] <= 0.5
    assert np.isfinite(result.last).all()


def test_a_run_that_crawls_is_stopped():
    result = solve(oscillator, np.array([[1.0, 0.0]]), np.array([[1000.0]]), max_steps=20)
    assert result.outcome[0] == "step_underflow"
