"""The loop over time that all steppers share, WIDTH runs side by side.

A stepper knows one step of a method; the loop knows runs, samples, events and bounds. Each lane
carries one run with its own time and step. When a run ends, its lane takes the next of the queue,
so that no lane waits for another. Samples at any instant of a step come from the polynomial

    y(t + x h) = y + x (d_0 + (1 - x) (d_1 + x (d_2 + (1 - x) (d_3 + ...))))

whose first three terms are the cubic of Hermite through value and rate at both ends of the step;
a stepper may add more (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.6).

A stepper is two compiled functions:

    attempt(flow, lanes, problem, method, scratch)       from t, y, rate and h of each lane: step,
        arrival, new, new_rate, the next h, and the verdict: OK, RETRY or a failure
    interpolate(flow, lanes, method, scratch)            d_3, d_4, ... of the last attempt
"""

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from numba import types
from numba.core.errors import NumbaExperimentalFeatureWarning

from vibrom.kernels.lanes import WIDTH, get, kernel, put
from vibrom.solvers.reduced.field import MAP, TABLES, evaluate
from vibrom.solvers.reduced.parts import part
from vibrom.solvers.reduced.records import DIVERGED, OK, PROBLEM, SOLUTION, STEP_UNDERFLOW

_TINY = np.finfo(float).tiny


def compiled(method: types.Type) -> Callable:
    """Compiles `solve(drift, force, tables, problem, solution, method)`, where numba knows the
    record of the method as the type `method`, and keeps it on disk.
    """

    def compile(solve):
        signature = types.void(MAP, MAP, TABLES, PROBLEM, SOLUTION, method)
        with warnings.catch_warnings():
            # Maps are passed as function pointers.
            warnings.simplefilter("ignore", NumbaExperimentalFeatureWarning)
            return kernel(signature, fastmath={"contract"})(solve)

    return compile


def marching(attempt: Any, interpolate: Any) -> Callable:
    """The loop around a stepper. It integrates all runs of `problem` and fills `solution`."""

    def march(flow, lanes, problem, solution, method, scratch):
        runs, queue, going = len(problem.start), 0, 0
        while going > 0 or queue < runs:
            before = queue
            for w in range(WIDTH):
                if lanes.run[w] < 0 and queue < runs:
                    _enter(w, queue, flow, lanes, problem, solution)
                    queue += 1
            if queue > before:
                going += queue - before
                evaluate(flow, lanes.t, lanes.y, lanes.rate)
            attempt(flow, lanes, problem, method, scratch)
            if _due(lanes, problem):
                _hermite(lanes)
                interpolate(flow, lanes, method, scratch)
            going -= _settle(flow, lanes, problem, solution)

    # A name of its own, as code on disk is told apart by names.
    march.__qualname__ = f"march_{attempt.py_func.__module__}"
    return part(march)


@part
def _enter(w, k, flow, lanes, problem, solution):
    """Run k of the queue enters lane w."""
    m = problem.times.shape[1]
    lanes.run[w], lanes.tried[w], lanes.sampled[w], lanes.verdict[w] = k, 0, 0, OK
    lanes.t[w], lanes.end[w], lanes.h[w] = 0.0, problem.times[k, m - 1], problem.first_step[k]
    flow.amplitude[w], flow.frequency[w] = (
        problem.forcing.amplitude[k],
        problem.forcing.frequency[k],
    )
    for i in range(problem.start.shape[1]):
        lanes.y[i, w] = solution.last[k, i] = problem.start[k, i]
        solution.peak[k, i] = abs(problem.start[k, i])
    while lanes.sampled[w] < m and problem.times[k, lanes.sampled[w]] <= 0.0:
        for i in range(problem.start.shape[1]):
            solution.samples[k, lanes.sampled[w], i] = problem.start[k, i]
        lanes.sampled[w] += 1


@part
def _due(lanes, problem):
    """Whether an instant of `times` lies in an accepted step."""
    for w in range(WIDTH):
        k, j = lanes.run[w], lanes.sampled[w]
        left = k >= 0 and lanes.verdict[w] == OK and j < problem.times.shape[1]
        if left and problem.times[k, j] <= lanes.arrival[w]:
            return True
    return False


@part
def _hermite(lanes):
    """The terms d_0, d_1, d_2 of the interpolant."""
    r, step = len(lanes.y), get(lanes.step, 0, WIDTH)
    for i in range(r):
        rise = get(lanes.new, i, WIDTH) - get(lanes.y, i, WIDTH)
        at_start, at_end = get(lanes.rate, i, WIDTH), get(lanes.new_rate, i, WIDTH)
        put(lanes.dense, i, rise)
        put(lanes.dense, r + i, step * at_start - rise)
        put(lanes.dense, 2 * r + i, 2.0 * rise - step * (at_end + at_start))


@part
def _settle(flow, lanes, problem, solution):
    """Draws the conclusions of an attempt: samples, events, ends of runs; returns how many end."""
    ended = 0
    for w in range(WIDTH):
        k, verdict = lanes.run[w], lanes.verdict[w]
        if k < 0:
            continue
        lanes.tried[w] += 1
        blown = False
        if verdict == OK:
            _sample(w, k, lanes, problem, solution)
            blown = _advance(w, k, lanes, problem, solution)
        over = lanes.t[w] >= lanes.end[w]
        shortest = 10 * np.spacing(max(lanes.t[w], _TINY))
        stuck = lanes.tried[w] >= problem.most_steps[k] or lanes.h[w] < shortest
        if blown:
            solution.ending[k] = DIVERGED
        elif over:
            solution.ending[k] = OK
        elif verdict > OK:
            solution.ending[k] = verdict
        elif stuck:
            solution.ending[k] = STEP_UNDERFLOW
        else:
            continue
        solution.ended_at[k] = lanes.t[w]
        lanes.run[w], lanes.t[w], lanes.end[w], lanes.h[w] = -1, 0.0, 0.0, 0.0
        flow.amplitude[w] = 0.0
        for i in range(len(lanes.y)):
            lanes.y[i, w] = 0.0
        ended += 1
    return ended


@part
def _sample(w, k, lanes, problem, solution):
    """The samples of run k in the step of lane w."""
    j, terms = lanes.sampled[w], len(lanes.dense)
    while j < problem.times.shape[1] and problem.times[k, j] <= lanes.arrival[w]:
        x = (problem.times[k, j] - lanes.t[w]) / lanes.step[w]
        for i in range(len(lanes.y)):
            value = 0.0
            for term in range(terms - 1, -1, -1):
                value = (value + lanes.dense[term, i, w]) * (1.0 - x if term % 2 else x)
            solution.samples[k, j, i] = lanes.y[i, w] + value
        j += 1
    lanes.sampled[w] = j


@part
def _advance(w, k, lanes, problem, solution):
    """Run k takes the step of lane w; returns whether it has diverged."""
    outside, blown = False, False
    for i in range(len(lanes.y)):
        lanes.y[i, w] = solution.last[k, i] = lanes.new[i, w]
        lanes.rate[i, w] = lanes.new_rate[i, w]
        size = abs(lanes.new[i, w])
        solution.peak[k, i] = max(solution.peak[k, i], size)
        outside = outside or size > problem.bounds.reach[i]
        blown = blown or not size <= problem.bounds.limit[i]
    lanes.t[w] = lanes.arrival[w]
    solution.steps[k] += 1
    if outside and np.isnan(solution.left_at[k]):
        solution.left_at[k] = lanes.t[w]
    return blown
