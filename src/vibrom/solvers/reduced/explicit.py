"""Explicit Runge-Kutta methods with embedded error estimate, each lane with its own adaptive step:

    K_i = f(t + c_i h, y + h sum_{j<i} a_ij K_j),    y(t + h) = y + h sum_i b_i K_i

A method is a `Tableau`. Its local error is estimated by differences e of two sets of weights,

    e = h sum_i e_i K_i,    error = |e| |e| / sqrt(|e|^2 + 0.01 |e'|^2)

with the mean square norm |.| over the tolerance, and e' an estimate of lower order that damps e
where e alone would be too trusting; without e' the error is |e| (Hairer, Norsett, Wanner, Solving
Ordinary Differential Equations I, II.4 and II.5).
"""

from typing import NamedTuple

import numpy as np
from numba import types

from vibrom.kernels.lanes import WIDTH, get, put, sqrt
from vibrom.solvers.reduced.field import evaluate, flow_of
from vibrom.solvers.reduced.loop import compiled, marching
from vibrom.solvers.reduced.parts import part, record, zeros
from vibrom.solvers.reduced.records import HERMITE, OK, RETRY, lanes_for

SAFETY, SLOWEST, FASTEST = 0.9, 0.2, 10.0  # of the next step over this one
_TINY = np.finfo(float).tiny


class Tableau(NamedTuple):
    """A method of s stages, with the rate at the end of the step as stage s and n - s - 1 more
    stages for the interpolant.
    """

    weights: np.ndarray  # (n, n) row i leads to stage i: a, then b as row s, then those of the rest
    nodes: np.ndarray  # (n,) c
    error: np.ndarray  # (s + 1,) e
    lower_error: np.ndarray  # (s + 1,) e', zeros where there is none
    interpolant: np.ndarray  # (terms, n) h times these of K are the terms beyond Hermite's
    order: int  # of the error estimate: the error falls with h^order


class Scratch(NamedTuple):
    """Work space of a step."""

    stages: np.ndarray  # (n, r, WIDTH) K
    at: np.ndarray  # (r, WIDTH) where a stage is evaluated
    instant: np.ndarray  # (WIDTH,) [s], and when
    error: np.ndarray  # (WIDTH,) over the tolerance


_f1, _f2 = types.float64[::1], types.float64[:, ::1]
TABLEAU = record(Tableau, _f2, _f1, _f1, _f1, _f2, types.int64)


@part
def _sum(weights, count, stages, i):
    """sum_j weights_j K_j of coordinate i."""
    r, total = stages.shape[1], get(stages, i, WIDTH) * weights[0]
    for j in range(1, count):
        if weights[j] != 0.0:  # a third of them
            total = total + get(stages, j * r + i, WIDTH) * weights[j]
    return total


@part
def _stage(s, target, flow, lanes, tableau, scratch):
    """k_s, evaluated at the state that it fills `target` with."""
    step = get(lanes.step, 0, WIDTH)
    for i in range(len(target)):
        rise = _sum(tableau.weights[s], s, scratch.stages, i)
        put(target, i, get(lanes.y, i, WIDTH) + step * rise)
    put(scratch.instant, 0, get(lanes.t, 0, WIDTH) + step * tableau.nodes[s])
    evaluate(flow, scratch.instant, target, scratch.stages[s])


@part
def _estimate(lanes, tolerance, tableau, scratch):
    """The error of the step over the tolerance."""
    r, count, step = len(lanes.y), len(tableau.error), get(lanes.step, 0, WIDTH)
    upper, lower = step * 0.0, step * 0.0
    for i in range(r):
        for w in range(WIDTH):
            size = max(abs(lanes.y[i, w]), abs(lanes.new[i, w]))
            scratch.instant[w] = tolerance.atol[i] + tolerance.rtol * size
        scale = get(scratch.instant, 0, WIDTH)
        e = _sum(tableau.error, count, scratch.stages, i) / scale
        d = _sum(tableau.lower_error, count, scratch.stages, i) / scale
        upper, lower = upper + e * e, lower + d * d
    put(scratch.error, 0, step * upper / sqrt((upper + lower * 0.01 + _TINY) * r))


@part
def _factor(error, order, freely):
    """The next step over this one; `freely`: it may be longer."""
    if error == 0.0:
        factor = FASTEST
    elif order == 8:
        factor = SAFETY / np.sqrt(np.sqrt(np.sqrt(error)))
    else:
        factor = SAFETY * error ** (-1.0 / order)
    if np.isnan(factor):
        return SLOWEST
    return min(max(factor, SLOWEST), FASTEST if freely else 1.0)


@part
def attempt(flow, lanes, problem, tableau, scratch):
    """A step of all lanes, and the length of the next one."""
    r, s = len(lanes.y), len(tableau.error) - 1
    for w in range(WIDTH):
        left = lanes.end[w] - lanes.t[w]
        lanes.step[w] = min(lanes.h[w], left)
        # Landing on the end exactly, not by a sum that may fall short of it.
        lanes.arrival[w] = lanes.end[w] if lanes.step[w] == left else lanes.t[w] + lanes.step[w]
    for i in range(r):
        put(scratch.stages, i, get(lanes.rate, i, WIDTH))
    for stage in range(1, s):
        _stage(stage, scratch.at, flow, lanes, tableau, scratch)
    _stage(s, lanes.new, flow, lanes, tableau, scratch)
    for i in range(r):
        put(lanes.new_rate, i, get(scratch.stages, s * r + i, WIDTH))
    _estimate(lanes, problem.tolerance, tableau, scratch)
    for w in range(WIDTH):
        accepted = scratch.error[w] < 1.0  # False for NaN too
        freely = accepted and lanes.verdict[w] == OK
        lanes.h[w] = lanes.step[w] * _factor(scratch.error[w], tableau.order, freely)
        lanes.verdict[w] = OK if accepted else RETRY


@part
def interpolate(flow, lanes, tableau, scratch):
    """The terms beyond Hermite's."""
    r, n, step = len(lanes.y), len(tableau.nodes), get(lanes.step, 0, WIDTH)
    for stage in range(len(tableau.error), n):
        _stage(stage, scratch.at, flow, lanes, tableau, scratch)
    for term in range(len(tableau.interpolant)):
        for i in range(r):
            rise = _sum(tableau.interpolant[term], n, scratch.stages, i)
            put(lanes.dense, (HERMITE + term) * r + i, step * rise)


march = marching(attempt, interpolate)


@compiled(TABLEAU)
def solve(drift, force, tables, problem, solution, tableau):
    """The loop with these steps."""
    r, n = problem.start.shape[1], len(tableau.nodes)
    lane = zeros(2)
    scratch = Scratch(zeros(n * r).reshape(n, r, WIDTH), zeros(r), lane[0], lane[1])
    flow, lanes = flow_of(drift, force, tables, r), lanes_for(r, len(tableau.interpolant))
    march(flow, lanes, problem, solution, tableau, scratch)


def plan(first_step: float, shortest: float, end: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First step and most steps of runs that end at `end` (b,) [s] and crawl where their mean step
    is below `shortest` [s].
    """
    return np.full(len(end), first_step), (end / shortest).astype(np.int64) + 1000
