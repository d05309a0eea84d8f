"""Monomials of complex coordinates, and what products and derivatives do to them.

    z^a = prod_i z_i^a_i,    z^a z^b = z^(a + b),    d z^a / dz_i = a_i z^(a - e_i)

They stand in graded order, degrees 1 to `order`. The 2d coordinates come in pairs (i, d + i): of a
complex pair of eigenvalues the two are conjugate where the motion is real, and so are the
coefficients of a monomial and of its mirror, which has the two exchanged. Of each such couple only
one, the kept one, is computed and stored.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations_with_replacement

import numpy as np


@dataclass(frozen=True)
class Pairs:
    """Products  z^left z^right = z^target  with kept targets, target by target."""

    target: np.ndarray  # (k,)
    left: np.ndarray  # (k,)
    right: np.ndarray  # (k,)


@dataclass(frozen=True)
class Monomials:
    """Of degrees 1 to `order` in as many coordinates as `mirror` has entries."""

    order: int
    mirror: tuple[int, ...]  # coordinate that each coordinate's conjugate is; itself where real

    def __len__(self) -> int:
        return len(self.powers)

    @cached_property
    def powers(self) -> np.ndarray:
        """(l, 2d) exponents."""
        m = len(self.mirror)
        rows = [
            np.bincount(chosen, minlength=m)
            for degree in range(1, self.order + 1)
            for chosen in combinations_with_replacement(range(m), degree)
        ]
        return np.array(rows, dtype=np.int64)

    @cached_property
    def degrees(self) -> np.ndarray:
        """(l,) total degree of each."""
        return self.powers.sum(axis=1)

    @cached_property
    def _codes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """A number for each, by digits; the numbers in ascending order, and whose they are."""
        digits = (self.order + 1) ** np.arange(len(self.mirror))
        codes = self.powers @ digits
        order = np.argsort(codes)
        return digits, codes[order], order

    def index(self, powers: np.ndarray) -> np.ndarray:
        """Which monomial has these exponents (*batch, 2d); -1 where there is none."""
        digits, codes, order = self._codes
        degree = powers.sum(axis=-1)
        inside = (powers.min(axis=-1) >= 0) & (degree >= 1) & (degree <= self.order)
        place = np.searchsorted(codes, np.where(inside, powers @ digits, codes[0]))
        return np.where(inside, order[place], -1)

    def of_degree(self, degree: int) -> slice:
        """Where the monomials of this degree stand."""
        return slice(*np.searchsorted(self.degrees, [degree, degree + 1]))

    @cached_property
    def conjugate(self) -> np.ndarray:
        """(l,) the mirror of each monomial."""
        return self.index(self.powers[:, list(self.mirror)])

    @cached_property
    def kept(self) -> np.ndarray:
        """(l,) is it the one of its couple that is computed?"""
        return np.arange(len(self)) <= self.conjugate

    @cached_property
    def raised(self) -> np.ndarray:
        """(2d, l) the monomial times each coordinate; -1 beyond the order."""
        return self.index(self.powers + np.eye(len(self.mirror), dtype=np.int64)[:, None])

    @cached_property
    def lowered(self) -> np.ndarray:
        """(2d, l) the monomial over each coordinate; -1 where that is none or the constant."""
        return self.index(self.powers - np.eye(len(self.mirror), dtype=np.int64)[:, None])

    def pairs(self, degree: int) -> Pairs:
        """Of all targets of this degree that are kept."""
        targets, lefts, rights = [], [], []
        for below in range(1, degree):
            left, right = (
                np.arange(len(self))[self.of_degree(part)] for part in (below, degree - below)
            )
            target = self.index(self.powers[left][:, None] + self.powers[right])
            keep = self.kept[target]
            targets.append(target[keep])
            lefts.append(np.broadcast_to(left[:, None], target.shape)[keep])
            rights.append(np.broadcast_to(right, target.shape)[keep])
        if not targets:
            return Pairs(*(np.zeros(0, np.int64),) * 3)
        joined = [np.concatenate(part) for part in (targets, lefts, rights)]
        order = np.argsort(joined[0], kind="stable")
        return Pairs(*(part[order] for part in joined))

    def values(self, z: np.ndarray) -> np.ndarray:
        """(*batch, l) of complex coordinates z (*batch, 2d)."""
        found = np.empty((len(self), *z.shape[:-1]), complex)
        axis = self.powers.argmax(axis=1)
        below = self.lowered[axis, np.arange(len(self))]
        for k in range(len(self)):
            factor = z[..., axis[k]]
            found[k] = factor if below[k] < 0 else found[below[k]] * factor
        return np.moveaxis(found, 0, -1)
