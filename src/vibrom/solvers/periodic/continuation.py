"""Pseudo-arclength continuation:  F(x, p) = 0  along p, through folds.

    F(u) = 0,   n . (u - u~) = 0,    u = (x/X, p/P),   u~ = u_0 + s t + s^2/2 t'

t is the tangent at the last point, t' its change over the last step, n = t; X is the size of x at
the last point and P a scale of p, so that a step is a relative change. Corrections keep the matrix
of the last point and improve it by Broyden's rank-one updates; it is made again where they stall.
At each solution the matrix is its own, but for 1e-4 of its size: eigenvalues decide on stability.
Steps are as long as the tangent turns little enough and the corrections are few enough.

Source: Keller, Lectures on Numerical Methods in Bifurcation Problems (1987), chapter 4; Kelley,
Solving Nonlinear Equations with Newton's Method (2003), section 4.3 (Broyden's method).

No package carries forced periodic motions of hundreds of displacements at this speed: PyCont-Lite
solves G(u, p) = 0 by Krylov iterations on the residual, each of which costs a period of the full
order, and finds no multipliers of a map; pacopy leaves the solver to its caller and has no
stability; bifpy and PyCoBi wrap Auto-07p, which is meant for some tens of equations; jaxcont wants
the model in JAX.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.linalg.lapack import dgetrf, dgetrs

# value and derivative, or the value alone
Problem = Callable[[np.ndarray, float, bool], "Value"]


@dataclass(frozen=True)
class Value:
    """F at a point."""

    residual: np.ndarray  # (m,) in units of x
    by_x: np.ndarray | None = None  # (m, m)
    by_p: np.ndarray | None = None  # (m,)
    ok: bool = True  # could F be evaluated?
    rough: bool = False  # is it good for a correction only?
    details: Any = None  # what else the evaluation found


@dataclass(frozen=True)
class Pace:
    """How far a step goes. Lengths are relative changes: of x to its size, of p to its scale."""

    scale: float  # P, a change of p that counts as one
    first: float = 0.05
    largest: float = 0.5
    smallest: float = 1e-5
    turn: float = 0.25  # rad, that the tangent may turn in a step
    tolerance: float = 1e-6  # of the last correction, which is still made
    exact: float = 1e-5  # the same of Newton's method, after which about its square is left
    near: float = 1e-4  # of the derivative's own point to the solution
    iterations: int = 16
    few: int = 9  # evaluations up to which a step may grow
    newton: bool = False  # is the derivative as cheap as the value?
    heard: Callable[[int], object] = int  # hears of every point of a walk


@dataclass(frozen=True)
class Point:
    """A solution and the direction in which the branch leaves it."""

    x: np.ndarray  # (m,)
    p: float
    tangent: np.ndarray  # (m + 1,) of x and p, of length one in the metric of this point
    value: Value  # with its derivative
    arc: float = 0.0  # along the branch
    iterations: int = 0  # evaluations that it took
    shrunk: float = 0.0  # the most that Newton's corrections left in the next ones

    def scale(self, pace: Pace) -> np.ndarray:
        """(m + 1,) the sizes of x and p that count as one."""
        return _scale(self.x, pace.scale)

    @property
    def u(self) -> np.ndarray:
        """(m + 1,) x and p."""
        return np.append(self.x, self.p)


def _norm(vector: np.ndarray) -> float:
    """As numpy's, which takes four times as long for three numbers."""
    return math.sqrt(vector @ vector)


def _scale(x: np.ndarray, of_p: float) -> np.ndarray:
    """(m + 1,) the sizes of x (m,) and p that count as one."""
    scale = np.full(len(x) + 1, _norm(x) or 1.0)
    scale[-1] = of_p
    return scale


# Steps in a row no longer than STUCK lead nowhere, and a walk ends: as many as may turn by CRAWL
# [rad], and FEWEST at least. It passes folds close by each other, and sharp turns, in fewer.
CRAWL, FEWEST, STUCK = 6.0, 24, 2e-3
SHRINK = 0.2  # what Newton's corrections may leave in the next ones; more, and steps become shorter


class Lost(ArithmeticError):
    """No solution was found where one was looked for."""


class _Corrector:
    """Solves F = 0 and n . (u - u~) = 0, in relative units, from one matrix."""

    def __init__(
        self,
        problem: Problem,
        pace: Pace,
        scale: np.ndarray,
        normal: np.ndarray,
        near: Value | None = None,
    ):
        self.problem, self.pace, self.scale, self.normal = problem, pace, scale, normal
        self.factor: Any = None
        self.shrunk = 0.0  # the most that is left of a correction in the next one
        if near is not None and not pace.newton:
            self.prepare(near)

    def prepare(self, value: Value) -> None:
        """Takes the matrix of this value."""
        m = len(value.residual)
        matrix = np.empty((m + 1, m + 1))
        matrix[:m, :m], matrix[:m, m] = value.by_x, value.by_p * (self.scale[m] / self.scale[0])
        matrix[m] = self.normal
        if not np.isfinite(matrix).all():
            raise Lost("the derivative is not finite")
        self.factor, self.steps = dgetrf(matrix)[:2], []

    def _solved(self, right: np.ndarray) -> np.ndarray:
        """By LAPACK itself: around it SciPy takes three times as long as three unknowns do."""
        return dgetrs(*self.factor, right)[0]

    def correction(self, value: Value, off: float) -> np.ndarray:
        """The next change of u, by Broyden's updates of the matrix (Kelley's recursion)."""
        right = -np.append(value.residual / self.scale[0], off)
        change = self._solved(right)
        for one, other in zip(self.steps, self.steps[1:]):
            change += other * (one @ change) / (one @ one)
        if self.steps:
            last = self.steps[-1]
            change /= 1.0 - (last @ change) / (last @ last)
        self.steps.append(change)
        return change

    def solve(self, guess: np.ndarray) -> tuple[np.ndarray, Value, int]:
        """(u, the value with its derivative near there, evaluations), in relative units."""
        u, before, exact = guess.copy(), np.inf, self.pace.newton or self.factor is None
        kept: Value | None = None
        bent = 0.0
        for count in range(1, self.pace.iterations + 1):
            value = self.problem(u[:-1] * self.scale[0], float(u[-1] * self.scale[-1]), exact)
            if not value.ok:
                raise Lost("the motion did not last for a period")
            if exact:
                self.prepare(value)
                # An older matrix may have told too little of how far it is, near a fold at most.
                before = before if self.pace.newton else np.inf
            change = self.correction(value, float(self.normal @ (u - guess)))
            size = _norm(change)
            if not size <= min(2.0 * before, 1.0):
                raise Lost("corrections grow")
            u = u + change
            if exact and size <= self.pace.near and not value.rough:
                kept = value
            enough = self.pace.tolerance
            if self.pace.newton:
                enough = self.pace.exact
                if before > enough:
                    self.shrunk = max(self.shrunk, size / before)
                    bent = max(bent, size / before**2)
                # Corrections are `bent` times the square of those before: twice that times this
                # one is missed by the derivative, and by the tangent.
                enough = min(enough, self.pace.near / max(bent, 1.0))
            if kept is not None and size <= enough and not value.rough:
                return u, kept, count
            # A derivative is due where its own correction will be small, or others do no good.
            rate = size / before if np.isfinite(before) else 0.1
            due = rate > 0.5 or (kept is None and size * rate <= 0.3 * self.pace.near)
            exact, before = self.pace.newton or due, np.inf if value.rough else size
        raise Lost("corrections are too many")

    def tangent(self, value: Value) -> np.ndarray:
        """The unit null vector of the derivative, along the normal."""
        self.prepare(value)
        end = np.zeros(len(self.normal))
        end[-1] = 1.0
        t = self._solved(end)
        return t / _norm(t)


def at(problem: Problem, x: np.ndarray, p: float, pace: Pace, toward: float = 1.0) -> Point:
    """The solution at this p near x; its tangent has p growing if `toward` is positive."""
    scale = _scale(x, pace.scale)
    corrector = _Corrector(problem, pace, scale, np.append(np.zeros(len(x)), 1.0))
    u, value, count = corrector.solve(np.append(x, p) / scale)
    tangent = np.sign(toward) * corrector.tangent(value)
    return replace(_point(u, value, count, scale, tangent, 0.0), shrunk=corrector.shrunk)


def _point(
    u: np.ndarray, value: Value, count: int, scale: np.ndarray, tangent: np.ndarray, arc: float
) -> Point:
    """The solution u, with its tangent in its own metric."""
    x = u[:-1] * scale[0]
    direction = tangent * scale
    own = direction / _norm(direction / _scale(x, scale[-1]))
    return Point(x, float(u[-1] * scale[-1]), own, value, arc, count)


def beyond(
    problem: Problem, point: Point, length: float, pace: Pace, before: Point | None = None
) -> Point:
    """The solution at this arclength from `point`, predicted with the help of a point `before` it.
    Raises Lost.
    """
    scale = point.scale(pace)
    normal = point.tangent / scale
    guess = point.u / scale + length * normal
    if before is not None:
        guess += _curved(before, point, scale, length)
    corrector = _Corrector(problem, pace, scale, np.sign(length) * normal, point.value)
    u, value, count = corrector.solve(guess)
    tangent = np.sign(length) * corrector.tangent(value)
    ahead = _point(u, value, count, scale, tangent, point.arc + length)
    return replace(ahead, shrunk=corrector.shrunk)


def _curved(before: Point, point: Point, scale: np.ndarray, length: float) -> np.ndarray:
    """What the cubic through two points and their tangents adds to the second tangent."""
    back = (before.u - point.u) / scale
    here, there = point.tangent / scale, before.tangent / scale
    there = there / _norm(there)
    h = -np.sign(back @ here) * _norm(back)
    square = (back + h * here) / h**2
    cubic = (there - here + 2.0 * h * square) / h**2
    return length**2 * (square + (length + h) * cubic)


def onto(problem: Problem, left: Point, right: Point, p: float, pace: Pace) -> Point:
    """The solution at p, from a straight line between two neighbours. Raises Lost."""
    share = (p - left.p) / (right.p - left.p)
    scale = left.scale(pace)
    normal = np.append(np.zeros(len(left.x)), 1.0)
    corrector = _Corrector(problem, pace, scale, normal, left.value)
    guess = (left.u + share * (right.u - left.u)) / scale
    guess[-1] = p / pace.scale
    u, value, count = corrector.solve(guess)
    tangent = corrector.tangent(value)
    sign = np.sign(tangent @ (left.tangent / scale)) or 1.0
    return _point(u, value, count, scale, sign * tangent, left.arc + share * (right.arc - left.arc))


def turning(left: Point, right: Point, pace: Pace) -> float:
    """Angle [rad] between two tangents."""
    scale = left.scale(pace)
    one, other = left.tangent / scale, right.tangent / scale
    cosine = one @ other / (_norm(one) * _norm(other))
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)))


def walk(problem: Problem, start: Point, pace: Pace) -> Iterator[Point]:
    """The branch from `start` along its tangent, `start` itself left out, for as long as it is
    wanted. Raises Lost where the smallest step finds no solution, or where it only creeps on.
    """
    point, before, length, short, held = start, None, pace.first, 0, False
    while short < max(FEWEST, CRAWL / pace.turn):
        try:
            ahead = beyond(problem, point, length, pace, before)
            angle = turning(point, ahead, pace)
            if angle > 2.5 * pace.turn:
                raise Lost("the branch turns too much in one step")
        except Lost:
            length, held = 0.5 * length, True  # and not longer at once
            if length < pace.smallest:
                raise
            continue
        short = short + 1 if length <= STUCK else 0
        most = 0.7 if ahead.iterations > pace.few else 1.0 if held else 2.0
        # The prediction's error, and with it the first contraction, go with the length's power 4.
        most = min(most, (SHRINK / max(ahead.shrunk, 1e-12)) ** 0.25)
        growth = max(min(pace.turn / max(angle, 1e-12), most), 0.4)
        length, held = min(length * growth, pace.largest), False
        before, point = point, ahead
        pace.heard(1)
        yield point
    raise Lost("the branch is followed by steps that are too short")
