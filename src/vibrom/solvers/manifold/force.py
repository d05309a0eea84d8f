"""The series of a force along a manifold, degree by degree.

    f(q_0 + W(z)) - f(q_0) - K W(z) = sum_a f_a z^a
    f(q) = B' w [(L + 2 Q(y, .))' D (L y + Q(y, y))]

y = B q at every point, in the words of `term.Quartic`; K is the tangent at q_0. With the strain's
own products e_a and the stress s_a = D (L_0 y_a + e_a), L_0 = L + 2 Q(y_0, .):

    e_a = sum_(b + c = a) Q(y_b, y_c),    f_a = B' w [L_0' D e_a + 2 sum_(b + c = a) Q(y_b, .)' s_c]

so that each degree costs products of two factors and needs only coefficients of lower degree.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import copy

import numpy as np
from scipy.sparse import csr_matrix

from vibrom.solvers.manifold.monomials import Monomials
from vibrom.solvers.manifold.products import Schedule, entries, multiply
from vibrom.solvers.threads import mapped, worth
from vibrom.term import Quartic, SceneError, Term


class NoPolynomial(SceneError):
    """A force is no cubic polynomial of the displacements."""


def potentials(term: Term) -> tuple[Quartic, ...]:
    """Of all forces of a term; NoPolynomial names the effect that brings another one."""
    found: list[Quartic] = []
    for force in term.forces:
        if force.quartic is None:
            effect = getattr(force.kernels, "__module__", "").rpartition(".")[2]
            raise NoPolynomial(
                f"effects.{effect}: its force is no cubic polynomial of the displacements, and a "
                "manifold from the equations is a power series; leave the effect out, or use a "
                "method that learns"
            )
        found += force.quartic()
    return tuple(found)


class ForceSeries:
    """One potential, about the displacement `rest` (n,)."""

    def __init__(self, potential: Quartic, rest: np.ndarray, monomials: Monomials):
        self.potential, points = potential, len(potential.weight)
        m, k = potential.linear.shape
        self.points, self.strains, self.components = points, m, k
        self.transposed = potential.local.T.tocsr()
        kept = int(monomials.kept.sum())
        self.y, self.s = np.zeros((kept, k, 2, points)), np.zeros((kept, m, 2, points))
        self.stress = np.zeros_like(self.s)  # of degree 1
        still = (potential.local @ rest).reshape(k, points)
        twice = 2.0 * np.einsum("oij,ip->ojp", potential.square, still)
        self.linear = potential.linear[:, :, None] + twice  # L_0 (m, k, points)
        self.strain = entries(potential.square)
        self.turned = entries(2.0 * potential.square.transpose(1, 2, 0))  # Q(y, .)' s

    def next(self, pairs: Schedule) -> np.ndarray:
        """f_a (targets, n) complex of the scheduled degree; keeps D e_a for `complete`."""
        self.stress = np.zeros((len(pairs.begin) - 1, self.strains, 2, self.points))
        multiply(self.y, self.y, pairs, self.strain, self.stress)
        force = self.answered(self.stress)
        multiply(self.y, self.s, pairs, self.turned, force)
        return self.assembled(force)

    def answered(self, strain: np.ndarray) -> np.ndarray:
        """L_0' D e (targets, k, 2, points) of strains e (targets, m, 2, points), which become the
        stresses D e.
        """
        force = np.empty((len(strain), self.components, 2, self.points))

        def one(e: np.ndarray, f: np.ndarray) -> None:
            e[:] = np.tensordot(self.potential.moduli, e, 1)
            np.einsum("mkp,mcp->kcp", self.linear, e, out=f)

        self._each(one, strain, force)
        return force

    def assembled(self, force: np.ndarray) -> np.ndarray:
        """B' w f (targets, n) complex of what acts at the points (targets, k, 2, points)."""
        found = np.empty((len(force), self.transposed.shape[0]), complex)

        def one(f: np.ndarray, into: np.ndarray) -> None:
            f *= self.potential.weight
            into.real, into.imag = (self.transposed @ f[:, c].ravel() for c in range(2))

        self._each(one, force, found)
        return found

    def elastic(self, values: np.ndarray, stress: np.ndarray, y: np.ndarray, s: np.ndarray) -> None:
        """Of coefficients x (targets, n) complex:  y <- B x (targets, k, 2, points) and
        s <- D L_0 y + `stress` (targets, m, 2, points).
        """

        def one(x: np.ndarray, more: np.ndarray, y: np.ndarray, s: np.ndarray) -> None:
            for c, part in enumerate((x.real, x.imag)):
                y[:, c] = (self.potential.local @ part).reshape(len(y), -1)
            strain = np.einsum("mkp,kcp->mcp", self.linear, y)
            np.add(np.tensordot(self.potential.moduli, strain, 1), more, out=s)

        self._each(one, values, stress, y, s)

    def _each(self, function: Callable[..., None], *targets: np.ndarray) -> None:
        """Calls the function with what belongs to each target."""
        mapped(lambda some: function(*some), zip(*targets), worth(self.points))

    def changed(self, matrix: csr_matrix) -> ForceSeries:
        """The series in other coordinates; `matrix` makes their kept coefficients of these, each of
        those before it.
        """
        found, size = copy(self), len(self.y)
        found.y, found.s = (
            (matrix[:size, :size] @ part.reshape(size, -1)).reshape(part.shape)
            for part in (self.y, self.s)
        )
        return found

    def truncated(self, kept: int) -> ForceSeries:
        """The series of the first monomials alone."""
        found = copy(self)
        found.y, found.s = self.y[:kept], self.s[:kept]
        return found

    def complete(self, places: np.ndarray, displacement: np.ndarray) -> None:
        """Takes the coefficients W_a (targets, n) of the degree whose force was computed last, at
        consecutive places.
        """
        here = slice(places[0], places[-1] + 1)
        self.elastic(displacement, self.stress, self.y[here], self.s[here])
