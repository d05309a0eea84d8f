"""Pseudo-arclength continuation:  F(x, p) = 0  along p, through folds.

    F(u) = 0,   n . (u - u~) = 0,    u = (x/X, p/P),   u~ = u_0 + s t + s^2/2 t'

t is the tangent at the last point, t' its change over the last step, n = t; X is the size of x at
the last point and P a scale of p, so that a step is a relative change. Corrections are those of
`corrector`. At each solution the derivative is its own, but for 1e-4 of its size: eigenvalues
decide on stability. Steps are as long as the tangent turns little enough and the corrections are
few enough. Along a branch det(dF/du; t) keeps its sign, but where another one crosses: a step that
changes it and has passed no crossing has gone over the gap between two branches that nearly cross,
and is taken again, shorter.

Source: Keller, Lectures on Numerical Methods in Bifurcation Problems (1987), chapter 4.

No package carries forced periodic motions of hundreds of displacements at this speed: PyCont-Lite
solves G(u, p) = 0 by Krylov iterations on the residual, each of which costs a period of the full
order, and finds no multipliers of a map; pacopy leaves the solver to its caller and has no
stability; bifpy and PyCoBi wrap Auto-07p, which is meant for some tens of equations; jaxcont wants
the model in JAX.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from vibrom.solvers.periodic.corrector import Corrector, Lost, Pace, Problem, Value, norm, sizes


@dataclass(frozen=True)
class Point:
    """A solution and the direction in which the branch leaves it."""

    x: np.ndarray  # (m,)
    p: float
    tangent: np.ndarray  # (m + 1,) of x and p, of length one in the metric of this point
    value: Value  # with its derivative
    arc: float = 0.0  # along the branch
    iterations: int = 0  # evaluations that it took
    bent: float = 0.0  # a correction by Newton's method over the square of the one before it

    def scale(self, pace: Pace) -> np.ndarray:
        """(m + 1,) the sizes of x and p that count as one."""
        return sizes(self.x, pace.scale)

    @property
    def u(self) -> np.ndarray:
        """(m + 1,) x and p."""
        return np.append(self.x, self.p)


# Steps in a row no longer than STUCK lead nowhere, and a walk ends: as many as may turn by CRAWL
# [rad], and FEWEST at least. It passes folds close by each other, and sharp turns, in fewer.
CRAWL, FEWEST, STUCK = 6.0, 24, 2e-3
GAP = 0.01  # length at which a gap between two branches is as good as a crossing
NEWTON_FEW = 3  # evaluations of Newton's method up to which a step may grow


def at(problem: Problem, x: np.ndarray, p: float, pace: Pace, toward: float = 1.0) -> Point:
    """The solution at this p near x; its tangent has p growing if `toward` is positive."""
    scale = sizes(x, pace.scale)
    corrector = Corrector(problem, pace, scale, np.append(np.zeros(len(x)), 1.0))
    u, value, count = corrector.solve(np.append(x, p) / scale)
    return _point(corrector, u, value, count, float(np.sign(toward)), 0.0)


def _point(
    corrector: Corrector, u: np.ndarray, value: Value, count: int, sign: float, arc: float
) -> Point:
    """The solution u, with its tangent in its own metric."""
    scale, tangent = corrector.scale, sign * corrector.tangent(value)
    x = u[:-1] * scale[0]
    direction = tangent * scale
    own = direction / norm(direction / sizes(x, scale[-1]))
    return Point(x, float(u[-1] * scale[-1]), own, value, arc, count, corrector.bent)


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
    sign = float(np.sign(length))
    # A prediction that is a whole step off may lead to another branch.
    given = problem, pace, scale, sign * normal, point.value, point.bent, abs(length)
    corrector = Corrector(*given)
    u, value, count = corrector.solve(guess)
    return _point(corrector, u, value, count, sign, point.arc + length)


def _curved(before: Point, point: Point, scale: np.ndarray, length: float) -> np.ndarray:
    """What the cubic through two points and their tangents adds to the second tangent."""
    back = (before.u - point.u) / scale
    here, there = point.tangent / scale, before.tangent / scale
    there = there / norm(there)
    h = -np.sign(back @ here) * norm(back)
    square = (back + h * here) / h**2
    cubic = (there - here + 2.0 * h * square) / h**2
    return length**2 * (square + (length + h) * cubic)


def onto(problem: Problem, left: Point, right: Point, p: float, pace: Pace) -> Point:
    """The solution at p, from a straight line between two neighbours. Raises Lost."""
    share = (p - left.p) / (right.p - left.p)
    scale = left.scale(pace)
    normal = np.append(np.zeros(len(left.x)), 1.0)
    corrector = Corrector(problem, pace, scale, normal, left.value)
    guess = (left.u + share * (right.u - left.u)) / scale
    guess[-1] = p / pace.scale
    u, value, count = corrector.solve(guess)
    sign = float(np.sign(corrector.tangent(value) @ (left.tangent / scale))) or 1.0
    return _point(corrector, u, value, count, sign, left.arc + share * (right.arc - left.arc))


def turning(left: Point, right: Point, pace: Pace) -> float:
    """Angle [rad] between two tangents."""
    scale = left.scale(pace)
    one, other = left.tangent / scale, right.tangent / scale
    cosine = one @ other / (norm(one) * norm(other))
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)))


def orientation(point: Point) -> float:
    """The sign of det(dF/du; t)."""
    m = len(point.x)
    matrix = np.empty((m + 1, m + 1))
    matrix[:m, :m], matrix[:m, m], matrix[m] = point.value.by_x, point.value.by_p, point.tangent
    return float(np.linalg.slogdet(matrix)[0])


def _before_gap(
    problem: Problem, point: Point, ahead: Point, pace: Pace, before: Point | None
) -> float:
    """How far to go from `point`, as the orientation is another one `ahead`: as far as that, if
    there the branch is crossed by another one.
    """
    side, low, high, near, far = orientation(point), 0.0, ahead.arc - point.arc, point, ahead
    while high - low > GAP:
        # Not by half: where steps are doubled, that leads onto a crossing itself.
        length = low + 0.4 * (high - low)
        try:
            middle = beyond(problem, point, length, pace, before)
        except Lost:
            return length
        if orientation(middle) == side:
            low, near = length, middle
        else:
            high, far = length, middle
    crossed = norm((far.u - near.u) / point.scale(pace)) <= 2.0 * (high - low)
    return ahead.arc - point.arc if crossed else low or 0.4 * high


def walk(problem: Problem, start: Point, pace: Pace) -> Iterator[Point]:
    """The branch from `start` along its tangent, `start` itself left out, for as long as it is
    wanted. Raises Lost where the smallest step finds no solution, or where it only creeps on.
    """
    point, before, length, short, held = start, None, pace.first, 0, False
    side = orientation(start)
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
        now = orientation(ahead)
        shorter = length if now == side else _before_gap(problem, point, ahead, pace, before)
        if shorter < length:
            length, held = shorter, True
            continue
        short = short + 1 if length <= STUCK else 0
        few = NEWTON_FEW if pace.newton else pace.few
        most = 0.7 if ahead.iterations > few else 1.0 if held else 2.0
        growth = max(min(pace.turn / max(angle, 1e-12), most), 0.4)
        length, held = min(length * growth, pace.largest), False
        before, point, side = point, ahead, now
        pace.heard(1)
        yield point
    raise Lost("the branch is followed by steps that are too short")
