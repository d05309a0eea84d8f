"""Corrections of a point near a branch:  F(u) = 0,  n . (u - u~) = 0,  u = (x/X, p/P).

    Newton      A_k du_k = -F(u_k), A_k the derivative at u_k:  |du_k+1| = b |du_k|^2
    Broyden     A_k improved by rank-one updates, and made again where corrections stall

Where the derivative costs no more than the value Newton's method is taken. How large b is tells how
far off the last derivative is, 2 b |du|, and with it the tangent and the multipliers: corrections
go on until that is small enough.

Source: Kelley, Solving Nonlinear Equations with Newton's Method (2003), section 4.3 (Broyden's
method); Deuflhard, Newton Methods for Nonlinear Problems (2004), section 2.1 (b).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg.lapack import dgetrf, dgetrs

ROUNDING = 1e-9  # of a correction

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


class Lost(ArithmeticError):
    """No solution was found where one was looked for."""


def norm(vector: np.ndarray) -> float:
    """As numpy's, which takes four times as long for three numbers."""
    return math.sqrt(vector @ vector)


def sizes(x: np.ndarray, of_p: float) -> np.ndarray:
    """(m + 1,) the sizes of x (m,) and p that count as one."""
    scale = np.full(len(x) + 1, norm(x) or 1.0)
    scale[-1] = of_p
    return scale


class Corrector:
    """Solves F = 0 and n . (u - u~) = 0, in relative units, from one matrix."""

    def __init__(
        self,
        problem: Problem,
        pace: Pace,
        scale: np.ndarray,
        normal: np.ndarray,
        near: Value | None = None,
        bent: float = 0.0,
        room: float = 1.0,  # of Newton's corrections
    ):
        self.problem, self.pace, self.scale, self.normal = problem, pace, scale, normal
        self.factor: Any = None
        self.bent, self.room = bent, room
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
        return self._newton(guess) if self.pace.newton else self._broyden(guess)

    def _evaluated(self, u: np.ndarray, derivative: bool) -> Value:
        value = self.problem(u[:-1] * self.scale[0], float(u[-1] * self.scale[-1]), derivative)
        if not value.ok:
            raise Lost("the motion did not last for a period")
        if derivative:
            self.prepare(value)
        return value

    def _newton(self, guess: np.ndarray) -> tuple[np.ndarray, Value, int]:
        """Each correction is `bent` times the square of the one before it, and the derivative, and
        with it the tangent, is 2 `bent` times the last one off.
        """
        u, before, bent = guess.copy(), np.inf, 0.0
        for count in range(1, self.pace.iterations + 1):
            value = self._evaluated(u, True)
            change = self.correction(value, float(self.normal @ (u - guess)))
            size = norm(change)
            if not size <= min(max(2.0 * before, self.pace.exact), self.room):
                raise Lost("corrections grow")
            u = u + change
            if np.inf > before > self.pace.exact:  # smaller ones tell of rounding
                bent = self.bent = max(bent, size / before**2)
            straight = max(self.pace.near / max(self.bent, 1.0), ROUNDING)
            if size <= min(self.pace.exact, straight) and not value.rough:
                return u, value, count
            before = np.inf if value.rough else size
        raise Lost("corrections are too many")

    def _broyden(self, guess: np.ndarray) -> tuple[np.ndarray, Value, int]:
        u, before, exact = guess.copy(), np.inf, self.factor is None
        kept: Value | None = None
        for count in range(1, self.pace.iterations + 1):
            value = self._evaluated(u, exact)
            if exact:
                # An older matrix may have told too little of how far it is, near a fold at most.
                before = np.inf
            change = self.correction(value, float(self.normal @ (u - guess)))
            size = norm(change)
            if not size <= min(2.0 * before, 1.0):
                raise Lost("corrections grow")
            u = u + change
            if exact and size <= self.pace.near and not value.rough:
                kept = value
            if kept is not None and size <= self.pace.tolerance and not value.rough:
                return u, kept, count
            # A derivative is due where its own correction will be small, or others do no good.
            rate = size / before if np.isfinite(before) else 0.1
            exact = rate > 0.5 or (kept is None and size * rate <= 0.3 * self.pace.near)
            before = np.inf if value.rough else size
        raise Lost("corrections are too many")

    def tangent(self, value: Value) -> np.ndarray:
        """The unit null vector of the derivative, along the normal."""
        self.prepare(value)
        end = np.zeros(len(self.normal))
        end[-1] = 1.0
        t = self._solved(end)
        return t / norm(t)
