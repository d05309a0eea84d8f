"""Series that multiply a manifold's own: the tangent of the force, derivatives along the flow.

    (df/dq(W) x)_a,    (DX R)_a = sum (left_i + 1) X_(left + e_i) R_i,right,    (s X)_a

A series of this file has a constant: coefficient 0 is that of 1, coefficient 1 + k that of
monomial k. The manifold's own series have none.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vibrom.solvers.manifold.force import ForceSeries
from vibrom.solvers.manifold.monomials import Monomials
from vibrom.solvers.manifold.products import Schedule, entries, multiply


@dataclass(frozen=True)
class Degree:
    """All products  z^left z^right = z^target  with targets of one degree, kept or not."""

    monomials: Monomials
    targets: np.ndarray  # (t,) counted with the constant
    row: np.ndarray  # (k,) which of them, ascending
    left: np.ndarray  # (k,) counted with the constant
    right: np.ndarray  # (k,) counted without: its degree is at least one

    @classmethod
    def of(cls, monomials: Monomials, degree: int) -> Degree:
        """All of a degree, zero included."""
        powers = np.pad(monomials.powers, ((1, 0), (0, 0)))
        degrees = powers.sum(axis=1)
        targets = np.nonzero(degrees == degree)[0]
        found = [np.zeros((3, 0), np.int64)]
        for below in range(degree):
            left = np.nonzero(degrees == below)[0]
            right = np.nonzero(monomials.degrees == degree - below)[0]
            place = monomials.index(powers[left][:, None] + monomials.powers[right]) + 1
            parts = np.broadcast_arrays(place - targets[0], left[:, None], right)
            found.append(np.array([part.ravel() for part in parts]))
        row, left, right = np.concatenate(found, axis=1)
        order = np.argsort(row, kind="stable")
        return cls(monomials, targets, row[order], left[order], right[order])

    @property
    def range(self) -> slice:
        """Where the targets stand."""
        return slice(self.targets[0], self.targets[-1] + 1)

    @cached_property
    def begin(self) -> np.ndarray:
        """(t + 1,) where the products of each target begin."""
        return np.searchsorted(self.row, np.arange(len(self.targets) + 1))

    def times(self, series: np.ndarray) -> np.ndarray:
        """(t, l'): products with a scalar series (1 + l,), its constant left out; l' counts the
        coefficients of lower degrees.
        """
        found = np.zeros((len(self.targets), self.targets[0]), complex)
        found[self.row, self.left] = series[self.right + 1]
        return found

    def along(self, dynamics: np.ndarray) -> np.ndarray:
        """(t, l'): DX R of the series X, with the part of R (2d, l) above degree 1."""
        found = np.zeros((len(self.targets), self.targets[0]), complex)
        powers = np.pad(self.monomials.powers, ((1, 0), (0, 0)))
        raised = np.vstack([np.arange(len(dynamics)), self.monomials.raised.T]) + 1
        above = self.right >= len(dynamics)
        row, left, right = (part[above] for part in (self.row, self.left, self.right))
        for i, rate in enumerate(dynamics):
            found[row, raised[left, i]] += (powers[left, i] + 1) * rate[right]
        return found


class TangentSeries:
    """df/dq(W) x, less its part at rest, of one potential and of a series x (1 + l, n).

    With d = B x and the stress t = D (L_0 d + 2 Q(y, d)), in the words of `force`:
    B' w [L_0' D 2 Q(y, d) + 2 Q(d, .)' s + 2 Q(y, .)' t]
    """

    def __init__(self, force: ForceSeries, monomials: Monomials):
        self.force, size = force, 1 + len(monomials)
        self.d = np.zeros((size, force.components, 2, force.points))
        self.t = np.zeros((size, force.strains, 2, force.points))
        self.stretch = entries(2.0 * force.potential.square)
        place = np.cumsum(monomials.kept) - 1
        self.place = place[np.minimum(np.arange(len(monomials)), monomials.conjugate)]
        self.sign = np.where(monomials.kept, 1.0, -1.0)

    def next(self, degree: Degree) -> np.ndarray:
        """Its coefficients (t, n) of this degree."""
        force, count = self.force, len(degree.targets)
        known = self.place[degree.right], self.sign[degree.right]
        own = degree.left, np.ones(len(degree.left))
        plan, turned = (
            Schedule(degree.begin, *factors) for factors in ((*known, *own), (*own, *known))
        )
        self.stress = np.zeros((count, force.strains, 2, force.points))
        multiply(force.y, self.d, plan, self.stretch, self.stress)
        total = force.answered(self.stress)
        multiply(self.d, force.s, turned, force.turned, total)
        multiply(force.y, self.t, plan, force.turned, total)
        return force.assembled(total)

    def complete(self, degree: Degree, values: np.ndarray) -> None:
        """Takes the coefficients x_a (t, n) of the degree whose products were taken last."""
        here = degree.range
        self.force.elastic(values, self.stress, self.d[here], self.t[here])
