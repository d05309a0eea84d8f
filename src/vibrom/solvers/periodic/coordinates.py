"""Coordinates in which a stiff body is not stiff.

    y = R^-T (f(q) + s^2 M (q - q_0) - f(q_0)) / 10,    R'R = K + s^2 M,    s = 10 Omega_1

f is the internal force, q_0 the rest state and K the stiffness there, of follower loads its
symmetric part. Slow modes enter by their
displacement, stiff ones by their force: a body that turns far while it stretches little changes
little in y, whereas a straight line in q stretches it beyond all measure, and a step along it is
lost. Near rest y = R (q - q_0)/10, and |y|^2 is Omega_1^2 q'Mq for slow motions.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from vibrom.solvers.full.static import Body
from vibrom.solvers.full.tangent import Tangent
from vibrom.term import Term

SHIFT = 10.0  # times the first frequency: slower modes count as slow
ROUNDS, CLOSE = 25, 1e-7  # Newton's iteration squares it once more
RAMP = 4  # parts of the way from rest


class NoState(ArithmeticError):
    """Coordinates to which no displacement was found."""


@dataclass(frozen=True)
class Coordinates:
    """Of the displacements of a body."""

    term: Term
    rest: np.ndarray  # (n,) m
    frequency: float  # rad/s, Omega_1
    # (n,) m, where the last search ended and the next one begins
    near: list[np.ndarray] = field(default_factory=list)

    @cached_property
    def _body(self) -> Body:
        return Body(self.term)

    @cached_property
    def _tangent(self) -> Tangent:
        """K + df/dq + s^2 M."""
        return Tangent(self.term, (SHIFT * self.frequency) ** 2, 0.0, 1.0)

    @cached_property
    def root(self) -> np.ndarray:
        """R/10, an upper triangle."""
        stiffness = self._at(self.rest).toarray()
        return cholesky(0.5 * (stiffness + stiffness.T)) / SHIFT

    @cached_property
    def _still(self) -> np.ndarray:
        """f(q_0) [N]."""
        return self._body.internal(self.rest)

    def _at(self, q: np.ndarray):
        """The tangent at q."""
        state = np.ascontiguousarray(q[:, None])
        return self._tangent.at(state, np.zeros_like(state))

    def _force(self, q: np.ndarray) -> np.ndarray:
        """f(q) + s^2 M (q - q_0) - f(q_0) [N]."""
        held = (SHIFT * self.frequency) ** 2 * (self.term.mass @ (q - self.rest))
        return self._body.internal(q) - self._still + held

    def of(self, q: np.ndarray) -> np.ndarray:
        """The coordinates (n,) of a displacement (n,) [m]."""
        self.near[:] = [q]
        return solve_triangular(self.root, self._force(q), trans="T") / SHIFT**2

    def to(self, y: np.ndarray) -> np.ndarray:
        """The displacement (n,) [m] of y, from that of the last search or, if that is too far, from
        rest. Raises NoState.
        """
        for _ in self.near[:1]:
            try:
                return self._search(y, self.near[0])
            except NoState:
                self.near.clear()
        q = self.rest
        for share in np.linspace(0.0, 1.0, RAMP + 1)[1:]:
            q = self._search(share * y, q)
        return q

    def _search(self, y: np.ndarray, q: np.ndarray) -> np.ndarray:
        """The displacement (n,) of y by Newton's iteration from q (n,). Raises NoState."""
        force = SHIFT**2 * (self.root.T @ y)
        for _ in range(ROUNDS):
            state = np.ascontiguousarray(q[:, None])
            factor = self._tangent.factor(state, np.zeros_like(state))
            change = factor.solve(force - self._force(q))
            q = q + change
            if not np.isfinite(change).all():
                break
            if np.linalg.norm(change) <= CLOSE * np.linalg.norm(q - self.rest):
                self.near[:] = [q]
                return q
        raise NoState("no displacement has these internal forces")

    def slope(self, q: np.ndarray, change: np.ndarray) -> np.ndarray:
        """Changes of y (n, c) that go with changes of the displacement (n, c) at q."""
        return solve_triangular(self.root, self._at(q) @ change, trans="T") / SHIFT**2

    def axes(self, q: np.ndarray, along: np.ndarray) -> np.ndarray:
        """Changes of the displacement (n, c) at q that go with changes `along` (n, c) of y."""
        state = np.ascontiguousarray(q[:, None])
        factor = self._tangent.factor(state, np.zeros_like(state))
        return factor.solve(SHIFT**2 * np.ascontiguousarray(self.root.T @ along))
