"""Static equilibria:  K q + sum_i f_i(q, 0) = p_0 + p u,  of one state, without inertia.

`equilibrium` finds one by Newton iteration under a load that grows in steps. `path` follows all of
them through limit points, where the load must fall (snap-through), by arclength continuation: the
load level is unknown too, and corrections stay normal to the predicted step. Source: Crisfield,
Non-linear Finite Element Analysis of Solids and Structures 1, chapters 1 and 9 (the normal plane:
Riks 1979, Ramm 1981).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.sparse import csc_matrix

from vibrom.solvers.full.factors import factor
from vibrom.solvers.full.shapes import shaped
from vibrom.solvers.full.tangent import Tangent
from vibrom.term import SceneError, Term

EPSILON = float(np.finfo(float).eps)
SMALLEST = 2.0**-10  # of the first step: a step that fails at this part of it will fail at any


class NoEquilibrium(SceneError):
    """No equilibrium was found beyond a part of the load."""

    def __init__(self, message: str, level: float, displacement: np.ndarray):
        super().__init__(message)
        self.level = level  # the part of the load
        self.displacement = displacement  # (n,) m, the last equilibrium


class Body:
    """The internal force and the tangent of a term at rest."""

    def __init__(self, term: Term):
        if term.stiffness is None and not term.forces:
            raise SceneError(
                "effects has nothing that holds the body, and without it there is no equilibrium; "
                "list elasticity"
            )
        self.term, self.still = term, np.zeros((term.size, 1))
        self.pattern = Tangent(term, 0.0, 0.0, 1.0)
        self.stiff = None if term.stiffness is None else abs(term.stiffness)

    def internal(self, q: np.ndarray) -> np.ndarray:
        """K q + sum f(q, 0) (n,) [N]."""
        stiffness, f = self.term.stiffness, np.zeros((len(q), 1))
        if stiffness is not None:
            f[:, 0] = stiffness @ q
        state = np.ascontiguousarray(q[:, None])
        for force in self.term.forces:
            force.kernels(1)[0](state, self.still, force.dofs, force.table, f)
        return f[:, 0]

    def holds(
        self, q: np.ndarray, internal: np.ndarray, load: np.ndarray, tolerance: float
    ) -> bool:
        """|r| <= tolerance (|K q + f| + |load|), or r is rounding: in slender bodies entries of K q
        are far larger than their sum.
        """
        bound = tolerance * (np.linalg.norm(internal) + np.linalg.norm(load))
        if self.stiff is not None:
            bound += 8 * EPSILON * np.linalg.norm(self.stiff @ np.abs(q))
        return bool(np.linalg.norm(load - internal) <= bound < np.inf)

    def tangent(self, q: np.ndarray) -> csc_matrix:
        """K + sum df/dq (n, n) [N/m]; not positive definite beyond a limit point, not symmetric
        under follower loads.
        """
        return self.pattern.at(np.ascontiguousarray(q[:, None]), self.still)

    def factor(self, q: np.ndarray):
        """The tangent's factor."""
        return factor(self.tangent(q), self.pattern.symmetric)


def equilibrium(
    term: Term,
    signal: float = 0.0,
    *,
    start: np.ndarray | None = None,  # (n,) m, an equilibrium; None: the undeformed body
    steps: int = 1,
    tolerance: float = 1e-8,
    max_iterations: int = 15,
) -> np.ndarray:
    """q (n,) [m] under the dead load and `signal` times the load, reached from `start` in about
    `steps` steps.

    The load grows in a straight line from the one that holds `start`. A step that does not converge
    to |r| <= tolerance (|K q + f| + |load|) is halved, one that converges at ease doubles the next.
    """
    body, n = Body(term), term.size
    q = np.zeros(n) if start is None else shaped("start", start, n=n).copy()
    before, after = body.internal(q), np.zeros(n)
    for part, times in ((term.dead_load, 1.0), (term.load, signal)):
        if part is not None:
            after = after + times * part
    _finite(after)
    level, step = 0.0, 1.0 / steps
    while level < 1.0:
        # The last step ends on the load itself, not next to it.
        target = 1.0 if level + step > 1.0 - 1e-9 else level + step
        load = (1.0 - target) * before + target * after
        found, iterations = _newton(body, q, load, tolerance, max_iterations)
        if found is not None:
            q, level = found, target
            step = 2.0 * step if iterations <= 6 else step
        elif step > SMALLEST / steps:
            step *= 0.5
        else:
            raise NoEquilibrium(
                f"no static equilibrium beyond {level:.4g} of the load (signal = {signal:g}): it "
                "buckles or snaps there; lower the load, or follow the path by arclength",
                level,
                q,
            )
    return q


def _finite(load: np.ndarray) -> None:
    """Raises where the squares of a load are beyond the largest number."""
    with np.errstate(over="ignore"):
        size = np.linalg.norm(load)
    if not np.isfinite(size):
        raise NoEquilibrium(
            f"the load reaches {np.abs(load).max():.3g} N, which is too large to compute with; "
            "lower it",
            0.0,
            np.zeros_like(load),
        )


def _newton(
    body: Body, q: np.ndarray, load: np.ndarray, tolerance: float, max_iterations: int
) -> tuple[np.ndarray | None, int]:
    """The equilibrium under `load` near q, or None; and the iterations that it took."""
    first = np.inf
    for iteration in range(max_iterations + 1):
        internal = body.internal(q)
        if body.holds(q, internal, load, tolerance):
            return q, iteration
        norm = np.linalg.norm(load - internal)
        # A long predictor stretches a slender body: its first residual may be large, later ones may
        # not grow beyond it.
        if not np.isfinite(norm) or (iteration > 1 and norm > 1e3 * first):
            break
        first = norm if iteration == 1 else first
        try:
            q = q + body.factor(q).solve(load - internal)
        except RuntimeError:  # exactly singular
            break
    return None, max_iterations


class Point(NamedTuple):
    """A point of a path."""

    level: float  # of the load
    q: np.ndarray  # (n,) m


def path(
    term: Term,
    load: np.ndarray,  # (n,) N
    length: float,
    points: int,
    *,
    start: np.ndarray | None = None,  # (n,) m; None: the equilibrium under the dead load
    tolerance: float = 1e-8,
    max_iterations: int = 12,
) -> tuple[np.ndarray, np.ndarray]:
    """Levels (points + 1,) and displacements (points + 1, n) [m] of  K q + sum f(q, 0) = p_0 +
    level load,  from level 0 on.

    `length` [m] is the norm of the displacement's change from one point to the next; it is halved
    for a point that does not converge. `start` is the equilibrium at level 0.
    """
    body, n = Body(term), term.size
    load = shaped("load", load, n=n)
    _finite(load)
    if start is not None:
        q = shaped("start", start, n=n).copy()
    else:
        q = np.zeros(n) if term.dead_load is None else equilibrium(term)
    found, last, step = [Point(0.0, q)], None, length
    while len(found) <= points:
        here = found[-1]
        along = body.factor(here.q).solve(load)
        ahead = step / np.linalg.norm(along)
        if last is not None and along @ last < 0.0:
            ahead = -ahead
        guess = Point(here.level + ahead, here.q + ahead * along)
        point, iterations = _corrected(body, load, guess, ahead * along, tolerance, max_iterations)
        if point is not None:
            found.append(point)
            last = point.q - here.q
            step = min(length, 2.0 * step) if iterations <= 5 else step
        elif step > SMALLEST * length:
            step *= 0.5
        else:
            raise NoEquilibrium(
                f"the path of equilibria ends at {here.level:.4g} of the load: no point "
                f"{step:.2g} m farther was found; choose a smaller length",
                here.level,
                here.q,
            )
    return np.array([point.level for point in found]), np.array([point.q for point in found])


def _corrected(
    body: Body,
    load: np.ndarray,
    guess: Point,
    predicted: np.ndarray,
    tolerance: float,
    max_iterations: int,
) -> tuple[Point | None, int]:
    """The point of the path in the plane normal to the predicted step, or None; and the iterations
    that it took.
    """
    level, q = guess
    dead = 0.0 if body.term.dead_load is None else body.term.dead_load
    for iteration in range(max_iterations + 1):
        internal, external = body.internal(q), dead + level * load
        if body.holds(q, internal, external, tolerance):
            return Point(level, q), iteration
        r = external - internal
        if not np.isfinite(r).all():
            break
        solve = body.factor(q).solve
        by_residual, by_load = solve(r), solve(load)
        raised = -(predicted @ by_residual) / (predicted @ by_load)
        level, q = level + raised, q + by_residual + raised * by_load
    return None, max_iterations
