"""Gauss's implicit Runge-Kutta method of two stages and order 4, with equal steps:

    K_i = f(t + c_i h, y + h sum_j a_ij K_j),   y(t + h) = y + h (K_1 + K_2)/2,
    a = [[1/4, 1/4 - s], [1/4 + s, 1/4]],   c = 1/2 -+ s,   s = sqrt(3)/6

A-stable and symplectic: no step is too long for a damped mode, and no numerical damping hides what
a model does (Hairer, Lubich, Wanner, Geometric Numerical Integration, II.1.3). Newton's iteration
keeps the Jacobian of the step's start, taken by differences; a run whose iteration fails ends as
`no_convergence`. The cubic of Hermite between the ends of a step is of the method's order.
"""

from functools import partial
from typing import NamedTuple

import numpy as np
from numba import types

from vibrom.kernels.lanes import WIDTH, get, put
from vibrom.solvers.reduced.field import evaluate, flow_of
from vibrom.solvers.reduced.integrate import Stepper
from vibrom.solvers.reduced.loop import compiled, marching
from vibrom.solvers.reduced.parts import part, zeros
from vibrom.solvers.reduced.records import NO_CONVERGENCE, OK, lanes_for

_S = np.sqrt(3.0) / 6.0
WEIGHTS, NODES = np.array([[0.25, 0.25 - _S], [0.25 + _S, 0.25]]), np.array([0.5 - _S, 0.5 + _S])
ITERATIONS = 20
# of the range: the differences behind the Jacobian; half the digits, which costs Newton an
# iteration and the solution nothing
NUDGE = 1e-7
# Newton's last correction, over the tolerance
CONVERGED = 0.1


class Scratch(NamedTuple):
    """Work space of a step."""

    stages: np.ndarray  # (2, r, WIDTH) K
    rates: np.ndarray  # (2, r, WIDTH) f at the stages
    at: np.ndarray  # (r, WIDTH) where a stage is evaluated
    instant: np.ndarray  # (WIDTH,) [s], and when
    jacobian: np.ndarray  # (r, r, WIDTH) df_i/dy_j at the start of the step
    matrix: np.ndarray  # (2r, 2r) of the Newton equations of one lane
    right: np.ndarray  # (2r,)


@part
def _differentiate(flow, lanes, reach, scratch):
    """The Jacobian, by columns."""
    r = len(lanes.y)
    for j in range(r):
        # A coordinate without bounds is taken to be of size one.
        nudge = NUDGE * (reach[j] if np.isfinite(reach[j]) else 1.0)
        for i in range(r):
            put(scratch.at, i, get(lanes.y, i, WIDTH) + (nudge if i == j else 0.0))
        evaluate(flow, lanes.t, scratch.at, scratch.rates[0])
        for i in range(r):
            change = get(scratch.rates, i, WIDTH) - get(lanes.rate, i, WIDTH)
            put(scratch.jacobian, i * r + j, change / nudge)


@part
def _evaluate_stages(flow, lanes, scratch):
    """The rates at both stages."""
    r, h = len(lanes.y), get(lanes.h, 0, WIDTH)
    for s in range(2):
        put(scratch.instant, 0, get(lanes.t, 0, WIDTH) + h * NODES[s])
        for i in range(r):
            rise = get(scratch.stages, i, WIDTH) * WEIGHTS[s, 0]
            rise += get(scratch.stages, r + i, WIDTH) * WEIGHTS[s, 1]
            put(scratch.at, i, get(lanes.y, i, WIDTH) + h * rise)
        evaluate(flow, scratch.instant, scratch.at, scratch.rates[s])


@part
def _correct(w, lanes, tolerance, scratch):
    """Newton's correction of the stages of lane w; returns whether it was small."""
    r, h, matrix, right = len(lanes.y), lanes.h[w], scratch.matrix, scratch.right
    for s in range(2):
        for i in range(r):
            right[s * r + i] = scratch.rates[s, i, w] - scratch.stages[s, i, w]
            for j in range(r):
                change = h * scratch.jacobian[i, j, w]
                matrix[s * r + i, j] = -WEIGHTS[s, 0] * change
                matrix[s * r + i, r + j] = -WEIGHTS[s, 1] * change
            matrix[s * r + i, s * r + i] += 1.0
    _eliminate(matrix, right)
    small = True
    for i in range(r):
        allowed = tolerance.atol[i] + tolerance.rtol * abs(lanes.y[i, w])
        for s in range(2):
            scratch.stages[s, i, w] += right[s * r + i]
            small = small and h * abs(right[s * r + i]) <= CONVERGED * allowed  # False for NaN
    return small


@part
def _eliminate(matrix, right):
    """Solves matrix x = right in place, by Gauss's elimination with row exchanges."""
    n = len(right)
    for k in range(n):
        top = k
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > abs(matrix[top, k]):
                top = i
        if top != k:
            for j in range(k, n):
                matrix[k, j], matrix[top, j] = matrix[top, j], matrix[k, j]
            right[k], right[top] = right[top], right[k]
        for i in range(k + 1, n):
            share = matrix[i, k] / matrix[k, k]
            for j in range(k + 1, n):
                matrix[i, j] -= share * matrix[k, j]
            right[i] -= share * right[k]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            right[i] -= matrix[i, j] * right[j]
        right[i] /= matrix[i, i]


@part
def attempt(flow, lanes, problem, method, scratch):
    """A step of all lanes."""
    r, half = len(lanes.y), get(lanes.h, 0, WIDTH) * 0.5
    _differentiate(flow, lanes, problem.bounds.reach, scratch)
    for i in range(r):
        put(scratch.stages, i, get(lanes.rate, i, WIDTH))
        put(scratch.stages, r + i, get(lanes.rate, i, WIDTH))
    _iterate(flow, lanes, problem.tolerance, scratch)
    for i in range(r):
        rise = get(scratch.stages, i, WIDTH) + get(scratch.stages, r + i, WIDTH)
        put(lanes.new, i, get(lanes.y, i, WIDTH) + half * rise)
    for w in range(WIDTH):
        h = lanes.step[w] = lanes.h[w]
        # Multiples of the step, not sums of it; no further step where it is zero.
        after, count = np.rint(lanes.t[w] / h) + 1.0, np.rint(lanes.end[w] / h)
        lanes.arrival[w] = after * h if after < count else lanes.end[w]
    evaluate(flow, lanes.arrival, lanes.new, lanes.new_rate)


@part
def _iterate(flow, lanes, tolerance, scratch):
    """Newton's iteration of all lanes, and the verdict on it."""
    going = 0
    for w in range(WIDTH):
        running = lanes.run[w] >= 0
        lanes.verdict[w] = NO_CONVERGENCE if running else OK
        going += running
    for _ in range(ITERATIONS):
        _evaluate_stages(flow, lanes, scratch)
        for w in range(WIDTH):
            if lanes.verdict[w] != OK and _correct(w, lanes, tolerance, scratch):
                lanes.verdict[w] = OK
                going -= 1
        if going == 0:
            return


@part
def interpolate(flow, lanes, method, scratch):
    """No term beyond Hermite's."""


march = marching(attempt, interpolate)


@compiled(types.Tuple(()))
def solve(drift, force, tables, problem, solution, method):
    """The loop with these steps."""
    r = problem.start.shape[1]
    scratch = Scratch(
        zeros(2 * r).reshape(2, r, WIDTH),
        zeros(2 * r).reshape(2, r, WIDTH),
        zeros(r),
        zeros(1)[0],
        zeros(r * r).reshape(r, r, WIDTH),
        np.zeros((2 * r, 2 * r)),
        np.zeros(2 * r),
    )
    flow, lanes = flow_of(drift, force, tables, r), lanes_for(r, 0)
    march(flow, lanes, problem, solution, method, scratch)


def stepper(time_scale: float, steps: int) -> Stepper:
    """The method for this time scale [s], in `steps` steps to a period."""
    return equal_steps(2 * np.pi * time_scale / steps)


def equal_steps(longest: float) -> Stepper:
    """The method in equal steps of at most `longest` [s], the last one ending with the run."""
    return Stepper(solve, (), partial(_plan, longest))


def _plan(longest: float, end: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    count = np.maximum(np.ceil(end / longest), 1.0)
    return end / count, count.astype(np.int64) + 1
