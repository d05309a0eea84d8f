"""The series of a force along a manifold, degree by degree.

    f(q_0 + W(z)) - f(q_0) - K W(z) = sum_a f_a z^a
    f(q) = B' w [(L + 2 Q(y, .))' D (L y + Q(y, y))]

y = B q at every point, in the words of `term.Quartic`; K is the tangent at q_0. With the strain's
own products e_a and the stress s_a = D (L_0 y_a + e_a), L_0 = L + 2 Q(y_0, .):

    e_a = sum_(b + c = a) Q(y_b, y_c),    f_a = B' w [L_0' D e_a + 2 sum_(b + c = a) Q(y_b, .)' s_c]

so that each degree costs products of two factors and needs only coefficients of lower degree.
"""

from __future__ import annotations

from copy import copy

import numpy as np

from vibrom.solvers.manifold.monomials import Monomials
from vibrom.solvers.manifold.products import Schedule, entries, multiply
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
        self.stress = np.zeros(0)
        self.y, self.s = np.zeros((kept, k, 2, points)), np.zeros((kept, m, 2, points))
        still = (potential.local @ rest).reshape(k, points)
        twice = 2.0 * np.einsum("oij,ip->ojp", potential.square, still)
        self.linear = potential.linear[:, :, None] + twice  # L_0 (m, k, points)
        self.strain = entries(potential.square)
        self.turned = entries(2.0 * potential.square.transpose(1, 2, 0))  # Q(y, .)' s

    def next(self, pairs: Schedule) -> np.ndarray:
        """f_a (targets, n) complex of the scheduled degree; keeps D e_a for `complete`."""
        targets = len(pairs.begin) - 1
        strain = np.zeros((targets, self.strains, 2, self.points))
        multiply(self.y, self.y, pairs, self.strain, strain)
        self.stress = np.einsum("lm,tmcp->tlcp", self.potential.moduli, strain)
        force = np.einsum("mkp,tmcp->tkcp", self.linear, self.stress)
        multiply(self.y, self.s, pairs, self.turned, force)
        return self.assembled(force)

    def assembled(self, force: np.ndarray) -> np.ndarray:
        """B' w f (targets, n) complex of what acts at the points (targets, k, 2, points)."""
        targets = len(force)
        flat = (force * self.potential.weight).transpose(1, 3, 0, 2)
        both = self.transposed @ flat.reshape(self.components * self.points, targets * 2)
        both = both.reshape(-1, targets, 2)
        return (both[..., 0] + 1j * both[..., 1]).T

    def changed(self, matrix: np.ndarray) -> ForceSeries:
        """The series in other coordinates; `matrix` makes their kept coefficients of these."""
        found = copy(self)
        found.y, found.s = (np.tensordot(matrix, part, 1) for part in (self.y, self.s))
        return found

    def truncated(self, kept: int) -> ForceSeries:
        """The series of the first monomials alone."""
        found = copy(self)
        found.y, found.s = self.y[:kept], self.s[:kept]
        return found

    def local(self, values: np.ndarray) -> np.ndarray:
        """B x (targets, k, 2, points) of coefficients x (targets, n) complex."""
        both = np.stack([values.real, values.imag], axis=1)
        found = self.potential.local @ both.reshape(-1, both.shape[2]).T
        return found.reshape(self.components, self.points, -1, 2).transpose(2, 0, 3, 1)

    def complete(self, places: np.ndarray, displacement: np.ndarray) -> None:
        """Takes the coefficients W_a (targets, n) of the degree whose force was computed last."""
        y = self.local(displacement)
        self.y[places] = y
        strain = np.einsum("mkp,tkcp->tmcp", self.linear, y)
        self.s[places] = np.einsum("lm,tmcp->tlcp", self.potential.moduli, strain)
        if self.stress.size:
            self.s[places] += self.stress
