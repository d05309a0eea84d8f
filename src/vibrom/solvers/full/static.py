"""Static equilibria:  K q + sum_i f_i(q, 0) = p_0 + p u,  of one state, without inertia.

`equilibrium` finds one by Newton iteration under a load that grows in steps; `path` follows all of
them through limit points, where the load must fall (snap-through), by arclength continuation: the
load level is unknown too, and corrections stay normal to the predicted step. Source: Crisfield,
Non-linear Finite Element Analysis of Solids and Structures 1, chapters 1 and 9 (the normal plane:
Riks 1979, Ramm 1981).
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from vibrom.solvers.full.sparse import Tangent
from vibrom.term import SceneError, Term

EPSILON = float(np.finfo(float).eps)
SMALLEST = 2.0**-10  # of the first step: a step that fails at this part of it will fail at any


class NoEquilibrium(SceneError):
    """No equilibrium beyond `level` (the part of the load) was found; `displacement` (n,) [m] is
    the last one.
    """

    def __init__(self, message: str, level: float, displacement: np.ndarray):
        super().__init__(message)
        self.level, self.displacement = level, displacement


class Body:
    """The internal force and the tangent of a term at rest."""

    def __init__(self, term: Term):
        self.term, self.still = term, np.zeros((term.size, 1))
        self.pattern = Tangent(term, 0.0, 0.0, 1.0)
        self.stiff = None if term.stiffness is None else abs(term.stiffness)

    def internal(self, q: np.ndarray) -> np.ndarray:
        """K q + sum f(q, 0) (n,) [N]."""
        f = (
            np.zeros((len(q), 1))
            if self.term.stiffness is None
            else (self.term.stiffness @ q)[:, None]
        )
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
        rounding = (
            0.0 if self.stiff is None else 8 * EPSILON * np.linalg.norm(self.stiff @ np.abs(q))
        )
        return bool(
            np.linalg.norm(load - internal)
            <= tolerance * (np.linalg.norm(internal) + np.linalg.norm(load)) + rounding
        )

    def tangent(self, q: np.ndarray) -> csc_matrix:
        """K + sum df/dq (n, n) [N/m]; not positive definite beyond a limit point, not symmetric
        under follower loads.
        """
        return self.pattern.at(np.ascontiguousarray(q[:, None]), self.still)


def equilibrium(
    term: Term,
    signal: float = 0.0,
    *,
    start: np.ndarray | None = None,
    steps: int = 1,
    tolerance: float = 1e-8,
    max_iterations: int = 15,
) -> np.ndarray:
    """q (n,) [m] under the dead load and `signal` times the load, reached from the equilibrium
    `start` (rest) in about `steps` steps.

    The load grows in a straight line from the one that holds `start`. A step that does not converge
    to |r| <= tolerance (|K q + f| + |load|) is halved, one that converges at ease doubles the next.
    """
    body = Body(term)
    q = np.zeros(term.size) if start is None else np.array(start, float)
    before, after = body.internal(q), np.zeros(term.size)
    for part, factor in ((term.dead_load, 1.0), (term.load, signal)):
        if part is not None:
            after = after + factor * part
    level, step = 0.0, 1.0 / steps
    while level < 1.0:
        # The last step ends on the load itself, not next to it.
        target = 1.0 if level + step > 1.0 - 1e-9 else level + step
        found, iterations = _newton(
            body, q, (1.0 - target) * before + target * after, tolerance, max_iterations
        )
        if found is not None:
            q, level = found, target
            step = 2.0 * step if iterations <= 6 else step
        elif step > SMALLEST / steps:
            step *= 0.5
        else:
            raise NoEquilibrium(
                f"no static equilibrium beyond {level:.4g} of the load (signal = {signal:g}): it buckles or snaps there; lower the load, "
                "or follow the path by arclength",
                level,
                q,
            )
    return q


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
            q = q + splu(body.tangent(q)).solve(load - internal)
        except RuntimeError:  # exactly singular
            break
    return None, max_iterations


def path(
    term: Term,
    load: np.ndarray,
    length: float,
    points: int,
    *,
    start: np.ndarray | None = None,
    tolerance: float = 1e-8,
    max_iterations: int = 12,
) -> tuple[np.ndarray, np.ndarray]:
    """Levels (points + 1,) and displacements (points + 1, n) [m] of  K q + sum f(q, 0) = p_0 +
    level load,  from level 0 on.

    `length` [m] is the norm of the displacement's change from one point to the next; it is halved
    for a point that does not converge. `start` is the equilibrium at level 0: rest, unless there is
    a dead load.
    """
    body = Body(term)
    q = (
        np.array(start, float)
        if start is not None
        else np.zeros(term.size)
        if term.dead_load is None
        else equilibrium(term)
    )
    dead = np.zeros(term.size) if term.dead_load is None else term.dead_load
    levels, shapes, level, last, step = [0.0], [q], 0.0, None, length
    while len(levels) <= points:
        tangent = splu(body.tangent(q)).solve(load)
        ahead = 1.0 if last is None or tangent @ last >= 0.0 else -1.0
        predicted = ahead * step / np.linalg.norm(tangent) * tangent
        trial, height = q + predicted, level + ahead * step / np.linalg.norm(tangent)
        for iteration in range(max_iterations + 1):
            internal = body.internal(trial)
            external = dead + height * load
            r = external - internal
            converged = body.holds(trial, internal, external, tolerance)
            if converged or iteration == max_iterations or not np.isfinite(r).all():
                break
            solve = splu(body.tangent(trial)).solve
            by_residual, by_load = solve(r), solve(load)
            raised = -(predicted @ by_residual) / (predicted @ by_load)
            trial, height = trial + by_residual + raised * by_load, height + raised
        if converged:
            q, level, last = trial, height, trial - q
            levels.append(level)
            shapes.append(q)
            step = min(length, 2.0 * step) if iteration <= 5 else step
        elif step > SMALLEST * length:
            step *= 0.5
        else:
            raise NoEquilibrium(
                f"the path of equilibria ends at {level:.4g} of the load: no point {step:.2g} m farther was found; choose a smaller length",
                level,
                q,
            )
    return np.array(levels), np.array(shapes)
