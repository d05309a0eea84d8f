"""Newton's iteration on the acceleration where a step's equation of motion holds (`scheme`),
however a body is stored.

    r(a) = p u + p_0 - M a - C v - K q - f(q, v),    [M + gamma h C + beta h^2 (K + df/dq)] da = r
    |r| <= tolerance (|M a + C v| + |K q + f| + |p u + p_0|),  the right side at the first guess

with the factors gamma h and beta h^2 of Newmark's method; other schemes have others (`weights`).

The factor of the tangent is kept as long as the residual falls fast enough. The first guess alone
would be an explicit step: at least one solve makes it implicit. A state that does not converge is
frozen at rest; the others go on.

`newton_step` is the only place that knows this. What it does to a body (`Operations`) is compiled
code in `band` and Python in `sparse`, and so is the step itself.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibrom.kernels.compiled import Numbers, Rows, Vector, part


class Limits(NamedTuple):
    """When a step has converged, and when its tangent is factorised again."""

    tolerance: float
    patience: float
    max_iterations: int


class Iteration(NamedTuple):
    """What an iteration knows of each state, and has counted."""

    norm: Rows  # (1, width) N, |r|
    scale: Rows  # (1, width) N, what |r| is compared with
    previous: Vector  # (width,) N, |r| one iteration ago
    failed: Numbers  # (width,) step at which a state did not converge, -1: none
    iterations: Numbers  # (1,)
    factorisations: Numbers  # (1,)
    factored: Numbers  # (1,) is there a factor?


class Operations(NamedTuple):
    """What a step does to a body; arguments in this order, and `width` last."""

    predict: Callable  # (body, state, step): the first guess
    evaluate: Callable  # (body, state, iteration, step, first): the residual, its norm and scale
    factorise: Callable  # (body, state): the tangent
    correct: Callable  # (body, state): solves for a correction and adds it
    restart: Callable  # (body, state, w): state w without an acceleration
    finish: Callable  # (body, state): the step's end, from the instant where the equation holds
    freeze: Callable  # (body, state, w): state w at rest


def iteration(width: int) -> Iteration:
    """Nothing counted, none failed."""
    norm, scale = np.zeros((2, 1, width))
    iterations, factorisations, factored = np.zeros((3, 1), np.int64)
    failed = np.full(width, -1, np.int64)
    return Iteration(norm, scale, np.zeros(width), failed, iterations, factorisations, factored)


@part
def newton_step(operations, body, state, iteration, limits, step, width):
    """From the end of step `step` - 1 to the end of step `step`."""
    operations.predict(body, state, step, width)
    iterate(operations, body, state, iteration, limits, step, width)
    # Far from equilibrium the guess may lie where Newton's iteration does not find back: once more,
    # without acceleration.
    again = False
    for w in range(width):
        if unsolved(iteration, limits, w):
            operations.restart(body, state, w, width)
            again = True
    if again:
        iteration.factored[0] = 0
        iterate(operations, body, state, iteration, limits, step, width)
    for w in range(width):
        if unsolved(iteration, limits, w):
            iteration.failed[w] = step
            iteration.factored[0] = 0
    operations.finish(body, state, width)
    for w in range(width):
        if iteration.failed[w] >= 0:  # costs no iterations from here on, and cannot overflow
            operations.freeze(body, state, w, width)


@part
def iterate(operations, body, state, iteration, limits, step, width):
    """Corrections until each state has converged, or will not."""
    for count in range(limits.max_iterations + 1):
        operations.evaluate(body, state, iteration, step, count == 0, width)
        pending, slow = judge(iteration, limits, count == 0, width)
        if (not pending and count > 0) or count == limits.max_iterations:
            break
        if slow or iteration.factored[0] == 0:
            operations.factorise(body, state, width)
            iteration.factorisations[0] += 1
            iteration.factored[0] = 1
        operations.correct(body, state, width)
        iteration.iterations[0] += 1


@part
def judge(iteration, limits, first, width):
    """May a state still converge that has not? Would one, at the rate of the last iteration, need
    more than `patience` further ones?
    """
    pending = slow = False
    for w in range(width):
        norm = iteration.norm[0, w]
        if unsolved(iteration, limits, w) and norm < np.inf:
            pending = True
            if not first:
                expected = norm * (norm / iteration.previous[w]) ** limits.patience
                slow = slow or not expected <= limits.tolerance * iteration.scale[0, w]
        iteration.previous[w] = norm
    return pending, slow


@part
def unsolved(iteration, limits, w):
    """Is |r| too large, or no number? Infinity is not above infinity."""
    bound = limits.tolerance * iteration.scale[0, w]
    return iteration.failed[w] < 0 and not (iteration.norm[0, w] <= bound and bound < np.inf)
