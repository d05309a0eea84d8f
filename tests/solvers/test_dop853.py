"""Explicit Runge-Kutta methods against closed forms and SciPy."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import RK45, solve_ivp
from scipy.linalg import expm
from vector_fields import (
    DUFFING,
    EXPLICIT,
    FORCED,
    OSCILLATOR,
    equal_explicit_steps,
    forced_from_rest,
    solve,
)

from vibrom.latent.polynomial_kernel import polynomial_kernel
from vibrom.solvers.reduced.explicit import Tableau
from vibrom.solvers.reduced.field import VectorField
from vibrom.solvers.reduced.steppers.dop853 import TABLEAU


def dormand_prince_5():
    """The method of order 5(4) of the same authors: five more numbers make its interpolant."""
    weights, s = np.zeros((7, 7)), 6
    weights[:s, : s - 1], weights[s, :s] = RK45.A, RK45.B
    continued = np.array(
        [
            -12715105075 / 11282082432,
            0.0,
            87487479700 / 32700410799,
            -10690763975 / 1880347072,
            701980252875 / 199316789632,
            -1453857185 / 822651844,
            69997945 / 29380423,
        ]
    )
    nodes = np.append(RK45.C, 1.0)
    return Tableau(weights, nodes, RK45.E.copy(), np.zeros(7), continued[None], 5)


def test_forced_oscillators_from_rest():
    frequency, amplitude = np.linspace(0.5, 2.0, 21), np.linspace(0.1, 1.0, 21)
    times = np.sort(np.random.default_rng(1).uniform(0, 60, (21, 300)), axis=1)
    result = solve(EXPLICIT, FORCED, np.zeros((21, 2)), times, forcing=(amplitude, frequency))
    exact = np.stack([forced_from_rest(t, w, a) for t, w, a in zip(times, frequency, amplitude)])
    # Local errors of 1e-9 of an amplitude below 10 add up over sixty seconds, some 120 steps; the
    # interpolant is of order seven.
    assert np.abs(result.samples[..., 0] - exact).max() < 1e-9 * 10 * 120
    assert result.outcome == ["ok"] * 21 and np.array_equal(result.ended_at, times[:, -1])


@pytest.mark.parametrize("r", range(1, 7))
def test_linear_systems_of_any_dimension(r):
    matrix = np.random.default_rng(r).standard_normal((r, r)) - 1.5 * np.eye(r)
    start, times = np.random.default_rng(9).standard_normal((10, r)), np.linspace(0, 3, 7)
    field = VectorField(polynomial_kernel(np.ones(r), np.eye(r, dtype=int), matrix))
    result = solve(EXPLICIT, field, start, times[None].repeat(10, axis=0))
    exact = np.stack([start @ expm(matrix * t).T for t in times], axis=1)
    np.testing.assert_allclose(result.samples, exact, atol=1e-7 * np.abs(exact).max())


def test_the_error_is_proportional_to_the_tolerance_and_of_order_eight_in_the_steps():
    tolerances, errors, steps = 10.0 ** -np.arange(3.0, 12.0), [], []
    for tolerance in tolerances:
        result = solve(
            EXPLICIT,
            FORCED,
            np.zeros((1, 2)),
            np.array([[60.0]]),
            tolerance,
            tolerance,
            forcing=(np.ones(1), np.ones(1)),
        )
        errors.append(abs(result.samples[0, 0, 0] - forced_from_rest(60.0, 1.0, 1.0)))
        steps.append(result.steps[0])
    errors, steps = np.array(errors), np.array(steps)
    # Signs of local errors cancel more or less at one instant: a tolerance may miss the line by ten
    # times, the line over eight decades less.
    assert -9.5 < np.polyfit(np.log(steps[1:]), np.log(errors[1:]), 1)[0] < -6.5
    assert 0.8 < np.polyfit(np.log(tolerances), np.log(errors), 1)[0] < 1.2
    assert (errors < 100 * tolerances).all()


@pytest.mark.parametrize(
    ("tableau", "order", "between", "shortest"),
    [(TABLEAU, 8, 7, 0.2), (dormand_prince_5(), 5, 4, 0.06)],
    ids=["dormand_prince_8", "dormand_prince_5"],
)
def test_another_method_is_another_tableau(tableau, order, between, shortest):
    """One step of length h misses the end by h^(order + 1), and the motion between, by an
    interpolant of order q, by h^(q + 1).
    """
    lengths, errors = shortest * np.array([1.0, 1.5, 2.0]), []
    for h in lengths:
        times = np.linspace(0.0, h, 21)
        one = equal_explicit_steps(tableau, 1)
        result = solve(one, OSCILLATOR, np.array([[1.0, 0.0]]), times[None], 1.0, 1.0)
        assert result.steps[0] == 1
        error = np.hypot(*(result.samples[0] - np.stack([np.cos(times), -np.sin(times)], axis=1)).T)
        errors.append([error[-1], error.max()])
    end, inside = np.polyfit(np.log(lengths), np.log(errors), 1)[0]
    assert abs(end - (order + 1)) < 0.1 and abs(inside - (between + 1)) < 0.1


def test_agrees_with_scipy_on_a_nonlinear_field():
    start, times = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, -1.0]]), np.linspace(0, 30, 200)
    amplitude, frequency = np.array([0.5, 0.6, 0.7]), np.full(3, 1.1)
    ours = solve(
        EXPLICIT, DUFFING, start, times[None].repeat(3, axis=0), forcing=(amplitude, frequency)
    )
    for k in range(3):

        def duffing(t, y, k=k):
            push = amplitude[k] * np.sin(frequency[k] * t)
            return [y[1], -y[0] - y[0] ** 3 - 0.1 * y[1] + push]

        peer = solve_ivp(
            duffing, (0, 30), start[k], method="DOP853", t_eval=times, rtol=1e-9, atol=1e-12
        )
        # Both within the tolerance of each step, which the motion remembers for twenty seconds.
        np.testing.assert_allclose(ours.samples[k], peer.y.T, atol=1e-7)


def test_takes_the_steps_of_scipy():
    """From the same first step: the method, its estimate and its control are the same."""
    first = replace(EXPLICIT, plan=lambda end: (np.full(1, 0.05), np.full(1, 1000)))
    ours = solve(first, OSCILLATOR, np.array([[1.0, 0.5]]), np.array([[30.0]]))
    peer = solve_ivp(
        lambda t, y: [y[1], -y[0]],
        (0, 30),
        [1.0, 0.5],
        method="DOP853",
        rtol=1e-9,
        atol=1e-12,
        first_step=0.05,
    )
    assert ours.steps[0] == len(peer.t) - 1
    np.testing.assert_allclose(ours.last[0], peer.y[:, -1], rtol=0, atol=1e-13)
