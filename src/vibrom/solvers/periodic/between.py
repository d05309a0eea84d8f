"""Points of a branch between two neighbours: at a given p, or at the root of a test."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import islice

from vibrom.solvers.periodic import continuation
from vibrom.solvers.periodic.continuation import Lost, Pace, Point, Problem, beyond, walk

MOST = 8  # points between two on the way to a root
FEW = 32  # quarter steps from one to the other, which may be shorter still


def onto(problem: Problem, left: Point, right: Point, p: float, pace: Pace) -> Point:
    """The solution at p, between two neighbours; where they are too far apart, after shorter steps
    from the left one. Raises Lost.
    """
    length = 0.25 * (right.arc - left.arc)
    try:
        return continuation.onto(problem, left, right, p, pace)
    except Lost:
        if length < pace.smallest:
            raise
    shorter = replace(pace, first=length, largest=length, heard=int)
    below, before = left.p < p, left
    for ahead in islice(walk(problem, left, shorter), FEW):
        if (ahead.p < p) != below:
            return onto(problem, before, ahead, p, pace)
        before = ahead
    raise Lost("the branch does not come to p")


def root(
    problem: Problem,
    left: Point,
    right: Point,
    test: Callable[[Point], float],
    close: Callable[[Point], bool],
    pace: Pace,
) -> list[Point]:
    """Points between two neighbours on which `test` has opposite signs, the root first: what regula
    falsi (in its Illinois form) visits, two at least, until one is `close`.
    """
    found: list[Point] = []
    low, high, at_low, at_high, kept = left, right, test(left), test(right), 0
    for _ in range(MOST):
        share = at_low / (at_low - at_high)
        length = (high.arc - low.arc) * min(max(share, 0.02), 0.98)
        try:
            middle = beyond(problem, low, length, pace, high)
        except Lost:
            break
        value = test(middle)
        found.insert(0, middle)
        if found[1:] and close(middle):
            break
        if (value > 0) == (at_high > 0):  # an end that stays twice counts half
            high, at_high, at_low = middle, value, at_low * (0.5 if kept < 0 else 1.0)
            kept = -1
        else:
            low, at_low, at_high = middle, value, at_high * (0.5 if kept > 0 else 1.0)
            kept = 1
    return found
