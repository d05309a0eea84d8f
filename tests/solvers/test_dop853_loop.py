"""The compiled Runge-Kutta loop against closed forms, SciPy's one-by-one method and the numpy form
of the same method.
"""

import numpy as np
import pytest
from numba import njit
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from vibrom.latent.polynomial_kernel import constant_kernel, polynomial_kernel
from vibrom.solvers.reduced import dop853
from vibrom.solvers.reduced.dop853_loop import integrate
from vibrom.solvers.reduced.field import KERNEL, Field, Kernel

OMEGA, DAMPING = 1.3, 0.05
POWERS = np.array([[1, 0], [0, 1], [3, 0]])
LINEAR = np.array([[0.0, 1.0, 0.0], [-(OMEGA**2), -DAMPING, 0.0]])
DUFFING = np.array([[0.0, 1.0, 0.0], [-1.0, -0.1, -1.0]])


def oscillator(coefficients, push=1.0):
    return Field(
        polynomial_kernel(np.ones(2), POWERS, coefficients),
        None if push is None else constant_kernel(np.array([0.0, push])),
    )


def solve(field, start, times, rtol=1e-9, atol=1e-12, **options):
    wide = np.full(start.shape[1], 1e6)
    settings = dict(first_step=0.05, reach=wide, limit=10 * wide, max_steps=100_000) | options
    return integrate(field, start, times, rtol=rtol, atol=np.full(start.shape[1], atol), **settings)


def forced_from_rest(t, frequency, amplitude):
    """x'' + c x' + w^2 x = a sin(W t), x = x' = 0 at t = 0: the steady part and the free motion
    that cancels it at the start.
    """
    response = amplitude / (OMEGA**2 - frequency**2 + 1j * DAMPING * frequency)
    damped = np.sqrt(OMEGA**2 - DAMPING**2 / 4)
    at_rest, slope = -response.imag, -frequency * response.real
    free = np.exp(-DAMPING * t / 2) * (
        at_rest * np.cos(damped * t) + (slope + DAMPING * at_rest / 2) / damped * np.sin(damped * t)
    )
    return (response * np.exp(1j * frequency * t)).imag + free


def test_forced_oscillators_from_rest():
    frequency, amplitude = np.linspace(0.5, 2.0, 21), np.linspace(0.1, 1.0, 21)
    times = np.sort(np.random.default_rng(1).uniform(0, 60, (21, 300)), axis=1)
    result = solve(
        oscillator(LINEAR), np.zeros((21, 2)), times, amplitude=amplitude, frequency=frequency
    )
    exact = np.stack([forced_from_rest(t, w, a) for t, w, a in zip(times, frequency, amplitude)])
    # Local errors of 1e-9 of an amplitude below 10 add up over sixty seconds, some 120 steps; the
    # interpolant is of order seven.
    assert np.abs(result.samples[..., 0] - exact).max() < 1e-9 * 10 * 120
    assert list(result.outcome) == ["ok"] * 21 and np.array_equal(result.ended_at, times[:, -1])


def test_work_and_precision():
    """Order eight: the error falls with the steps to the power -8, and in proportion to the
    tolerance.
    """
    tolerances, errors, steps = 10.0 ** -np.arange(3.0, 12.0), [], []
    for tolerance in tolerances:
        result = solve(
            oscillator(LINEAR),
            np.zeros((1, 2)),
            np.array([[60.0]]),
            tolerance,
            tolerance,
            amplitude=np.ones(1),
            frequency=np.ones(1),
        )
        errors.append(abs(result.samples[0, 0, 0] - forced_from_rest(60.0, 1.0, 1.0)))
        steps.append(result.steps)
    errors, steps = np.array(errors), np.array(steps)
    # Signs of local errors cancel more or less at one instant: a tolerance may miss the line by ten
    # times, the line over eight decades less.
    assert -9.5 < np.polyfit(np.log(steps[1:]), np.log(errors[1:]), 1)[0] < -6.5
    assert 0.8 < np.polyfit(np.log(tolerances), np.log(errors), 1)[0] < 1.2
    assert (errors < 100 * tolerances).all()


def test_takes_the_steps_of_the_numpy_form_and_agrees_with_scipy():
    start, times = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, -1.0]]), np.linspace(0, 30, 200)
    amplitude, frequency = np.array([0.5, 0.6, 0.7]), np.full(3, 1.1)

    def duffing(t, y, run):
        return np.stack(
            [
                y[:, 1],
                -y[:, 0]
                - y[:, 0] ** 3
                - 0.1 * y[:, 1]
                + amplitude[run] * np.sin(frequency[run] * t),
            ],
            axis=1,
        )

    settings = dict(
        rtol=1e-9,
        atol=np.full(2, 1e-12),
        first_step=0.05,
        reach=np.full(2, 1.5),
        limit=np.full(2, 100.0),
        max_steps=10_000,
    )
    ours = integrate(
        oscillator(DUFFING),
        start,
        times[None].repeat(3, axis=0),
        amplitude=amplitude,
        frequency=frequency,
        **settings,
    )
    slow = dop853.integrate(duffing, start, times[None].repeat(3, axis=0), **settings)
    assert ours.steps == slow.steps
    # The same steps but for the last digits: an error estimate of 1e-9 knows seven of its own, and
    # so does the step that follows from it.
    np.testing.assert_allclose(ours.samples, slow.samples, rtol=0, atol=1e-10)
    for name, tolerance in (("left_at", 1e-6), ("peak", 1e-6), ("last", 1e-9), ("ended_at", 0.0)):
        np.testing.assert_allclose(
            getattr(ours, name), getattr(slow, name), rtol=tolerance, err_msg=name
        )
    for k in range(3):
        peer = solve_ivp(
            lambda t, y: duffing(np.array([t]), y[None], np.array([k]))[0],
            (0, 30),
            start[k],
            method="DOP853",
            t_eval=times,
            rtol=1e-11,
            atol=1e-13,
        )
        np.testing.assert_allclose(ours.samples[k], peer.y.T, atol=1e-6)


def test_a_run_is_the_same_alone_and_in_a_queue_to_the_last_bit():
    rng = np.random.default_rng(2)
    start, amplitude, frequency = (
        rng.uniform(-2, 2, (21, 2)),
        rng.uniform(0, 1, 21),
        rng.uniform(0.5, 2, 21),
    )
    times = (
        np.linspace(0, 1, 50) * rng.uniform(5, 30, 21)[:, None]
    )  # lanes fall free at different times
    together = solve(oscillator(DUFFING), start, times, amplitude=amplitude, frequency=frequency)
    for k in range(21):
        alone = solve(
            oscillator(DUFFING),
            start[k : k + 1],
            times[k : k + 1],
            amplitude=amplitude[k : k + 1],
            frequency=frequency[k : k + 1],
        )
        assert np.array_equal(together.samples[k], alone.samples[0])
        assert np.array_equal(together.last[k], alone.last[0]) and np.array_equal(
            together.peak[k], alone.peak[0]
        )


@pytest.mark.parametrize("r", range(1, 7))
def test_any_dimension(r):
    matrix = np.random.default_rng(r).standard_normal((r, r)) - 1.5 * np.eye(r)
    start, times = np.random.default_rng(9).standard_normal((10, r)), np.linspace(0, 3, 7)
    result = solve(
        Field(polynomial_kernel(np.ones(r), np.eye(r, dtype=int), matrix)),
        start,
        times[None].repeat(10, axis=0),
    )
    exact = np.stack([start @ expm(matrix * t).T for t in times], axis=1)
    np.testing.assert_allclose(result.samples, exact, atol=1e-7 * np.abs(exact).max())


def test_events_end_one_run_and_no_other():
    """y' = y^2 from 1 is 1/(1 - t): 5 at t = 0.8, 50 at t = 0.98; from -1 it is -1/(1 + t)."""
    square = Field(polynomial_kernel(np.ones(1), np.array([[2]]), np.ones((1, 1))))
    start = np.where(np.arange(12) % 3 == 1, 1.0, -1.0)[:, None]
    times = np.linspace(0, 2, 50)[None].repeat(12, axis=0)
    result = solve(square, start, times, reach=np.full(1, 5.0), limit=np.full(1, 50.0))
    quiet = solve(square, start[:1], times[:1], reach=np.full(1, 5.0), limit=np.full(1, 50.0))
    for k in range(12):
        if k % 3 == 1:
            assert (
                result.outcome[k] == "diverged"
                and 0.8 <= result.left_at[k] <= result.ended_at[k]
                and 0.98 <= result.ended_at[k] < 1.0
            )
            assert (
                result.last[k, 0] == pytest.approx(1 / (1 - result.ended_at[k]), rel=1e-6)
                and result.peak[k, 0] == result.last[k, 0]
            )
            told = times[k] <= result.ended_at[k]
            assert (
                np.isfinite(result.samples[k, told]).all()
                and np.isnan(result.samples[k, ~told]).all()
            )
        else:
            assert (
                result.outcome[k] == "ok"
                and np.isnan(result.left_at[k])
                and np.array_equal(result.samples[k], quiet.samples[0])
            )
    np.testing.assert_allclose(quiet.samples[0, :, 0], -1 / (1 + times[0]), rtol=1e-8)


def test_a_step_that_vanishes_is_an_outcome():
    @njit([KERNEL])
    def wall(z, numbers, index, work, out):
        """The first coordinate is time; beyond numbers[0] there is no slope."""
        for w in range(8):
            out[0, w] = 1.0
            out[1, w] = 1.0 if z[0, w] < numbers[0] else np.nan

    result = solve(
        Field(Kernel(wall, np.array([0.5]), np.zeros(1, np.int64), 0)),
        np.array([[0.0, 0.0], [-2.0, 0.0]]),
        np.array([[0.1, 1.0]] * 2),
    )
    assert list(result.outcome) == ["step_underflow", "ok"]
    # A step may end a shade before the wall, never beyond it.
    assert 0.49 < result.ended_at[0] <= 0.5 and np.isfinite(result.last).all()
    np.testing.assert_allclose(result.samples[:, :, 1], [[0.1, np.nan], [0.1, 1.0]])


def test_a_run_that_crawls_is_stopped():
    result = solve(
        oscillator(LINEAR, None),
        np.array([[1.0, 0.0], [0.0, 0.0]]),
        np.array([[1000.0], [0.1]]),
        max_steps=20,
    )
    assert list(result.outcome) == ["step_underflow", "ok"]


def test_first_and_last_instants():
    times = np.array([[0.0, 0.0, 0.5, 1.0, 1.0], [0.0, 0.0, 0.0, 0.0, 0.0]])
    start = np.array([[1.0, 0.0], [3.0, 4.0]])
    result = solve(oscillator(LINEAR, None), start, times)
    assert np.array_equal(result.samples[0, 0], start[0]) and np.array_equal(
        result.samples[0, 1], start[0]
    )
    np.testing.assert_allclose(result.samples[0, 3], result.last[0], rtol=1e-14)
    assert np.array_equal(result.samples[0, 3], result.samples[0, 4])
    assert np.array_equal(result.samples[1], start[1:].repeat(5, axis=0)) and list(
        result.outcome
    ) == ["ok", "ok"]


def test_a_force_without_its_signal_is_refused():
    with pytest.raises(ValueError, match="needs the amplitude and the frequency of each run"):
        solve(oscillator(LINEAR), np.zeros((1, 2)), np.ones((1, 1)))
