"""Gauss's implicit method against closed forms and the explicit method of order eight."""

import numpy as np
import pytest
from vector_fields import DUFFING, EXPLICIT, OSCILLATOR, polynomial, solve

from vibrom.solvers.reduced.steppers.gauss import equal_steps

TIGHT = {"rtol": 1e-13, "atol": 1e-14, "reach": 10.0}
START = np.array([[0.6, 0.8]])


def test_order_four_of_an_oscillator():
    counts, errors = np.array([20, 40, 80, 160]), []
    for count in counts:
        times = np.array([[10.0]])
        end = solve(equal_steps(10.0 / count), OSCILLATOR, START, times, **TIGHT).last[0, 0]
        errors.append(abs(end - 0.6 * np.cos(10.0) - 0.8 * np.sin(10.0)))
    order = -np.diff(np.log(errors)) / np.diff(np.log(counts))
    assert np.abs(order - 4.0).max() < 0.1


def test_order_four_between_the_steps():
    """The cubic of Hermite misses y'''' h^4/384 in the middle of a step."""
    times, errors = np.linspace(0.0, 10.0, 1601)[None], []
    exact = 0.6 * np.cos(times[0]) + 0.8 * np.sin(times[0])
    for count in (25, 50, 100, 200):
        found = solve(equal_steps(10.0 / count), OSCILLATOR, START, times, **TIGHT).samples[0, :, 0]
        errors.append(np.abs(found - exact).max())
    assert np.abs(np.log2(np.array(errors[:-1]) / errors[1:]) - 4.0).max() < 0.1


def test_agrees_with_the_explicit_method_on_forced_nonlinear_runs():
    times = np.sort(np.random.default_rng(0).uniform(0, 20, (5, 200)), axis=1)
    start = np.tile([0.4, 0.0], (5, 1))
    forcing = np.linspace(0, 0.5, 5), np.linspace(0.8, 1.2, 5)
    exact = solve(EXPLICIT, DUFFING, start, times, 1e-12, 1e-14, forcing=forcing).samples
    errors = [
        np.abs(
            solve(equal_steps(h), DUFFING, start, times, **TIGHT, forcing=forcing).samples - exact
        ).max()
        for h in (0.1, 0.05, 0.025)
    ]
    assert np.abs(np.log2(np.array(errors[:-1]) / errors[1:]) - 4.0).max() < 0.25


@pytest.mark.parametrize("step", [0.1, 1.0, 5.0])  # to less than two steps a period
def test_an_undamped_oscillator_keeps_its_energy(step):
    start, times = np.array([[1.0, 0.0]]), np.array([[2000.0]])
    end = solve(equal_steps(step), OSCILLATOR, start, times, **TIGHT).last[0]
    assert abs(end @ end - 1.0) < 1e-12 * 2000 / step  # a rounding a step


def test_the_energy_of_a_nonlinear_oscillator_does_not_drift():
    """Symplectic: of x'' = -x - x^3 the energy error of ten thousand steps is that of a hundred."""
    stepper, start = equal_steps(0.2), np.array([[1.0, 0.0]])
    field = polynomial({(0, 1): 1.0}, {(1, 0): -1.0, (3, 0): -1.0})
    times = np.linspace(0.0, 2000.0, 10001)[None]  # the ends of the steps
    x, v = solve(stepper, field, start, times, **TIGHT).samples[0].T
    error = np.abs(v**2 / 2 + x**2 / 2 + x**4 / 4 - 0.75)
    assert error[:100].max() > 1e-8 and error[-100:].max() < 1.05 * error[:100].max()


def test_a_stiff_damper_is_no_reason_for_short_steps():
    """y1' = y2 and y2' = -1e6 y2 - 1e6 y1 settles on y1' = -y1; explicit steps must stay below
    3e-6.
    """
    field = polynomial({(0, 1): 1.0}, {(1, 0): -1e6, (0, 1): -1e6})
    start, times = np.array([[1.0, -1.0]]), np.array([[1.0]])
    result = solve(equal_steps(0.05), field, start, times, 1e-10, 1e-10)
    assert result.outcome == ["ok"] and result.steps[0] == 20
    assert abs(result.last[0, 0] - np.exp(-1.0)) < 1e-5
    assert solve(EXPLICIT, field, start, times, 1e-10, 1e-10).outcome == ["step_underflow"]


def test_an_iteration_that_fails_is_an_outcome_and_spoils_no_other_run():
    # y1' = y1^3: from 1 infinite at t = 1/2; from 0.1 at t = 50.
    field, start = polynomial({(3, 0): 1.0}, {}), np.array([[1.0, 0.0], [0.1, 0.0]])
    result = solve(equal_steps(0.01), field, start, np.tile([0.25, 0.7], (2, 1)), 1e-13, 1e-14)
    assert result.outcome == ["no_convergence", "ok"] and 0.45 < result.ended_at[0] < 0.55
    np.testing.assert_allclose(
        result.samples[:, 0, 0], [(1 - 0.5) ** -0.5, (100 - 0.5) ** -0.5], rtol=1e-6
    )
    assert np.isnan(result.samples[0, 1]).all()
    assert result.samples[1, 1, 0] == pytest.approx((100 - 1.4) ** -0.5, rel=1e-9)
