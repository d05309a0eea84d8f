"""The stiffness of a deformed body without what its stresses add, and a mass.

    A(q) = s M + K + sum_points w B' [J' D J - L' D L] B,    J = L + 2 Q(y, .),    y = B q

in the words of `term.Quartic`. Compressed bodies have tangents that are nowhere near positive
definite, and singular at some states; A is positive definite at any. Forces that are no cubic
polynomials are left out.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dgbsv, dpbsv
from scipy.sparse import coo_matrix, csc_matrix, csr_matrix, tril
from scipy.sparse.linalg import splu

from vibrom.solvers.threads import mapped, worth
from vibrom.term import Quartic, Term

WIDEST = 100  # half bandwidth that is still factorised as a band


class Material:
    """A of a term, at several displacements and any scale s of its mass [1/s^2]."""

    def __init__(self, term: Term):
        self.n = term.size
        potentials = [
            part for force in term.forces if force.quartic is not None for part in force.quartic()
        ]
        linear = [tril(term.mass)]
        linear += [] if term.stiffness is None else [tril(term.stiffness)]
        squares = [_Square(part) for part in potentials]
        rows, columns = (
            np.concatenate([getattr(part, name) for part in (*linear, *squares)])
            for name in ("row", "col")
        )
        self.row, self.column, place = _places(rows, columns)
        self.half = int((self.row - self.column).max())
        ends = np.cumsum([len(part.row) for part in (*linear, *squares)])[:-1]
        places = np.split(place, ends)
        self.linear = [
            np.bincount(where, part.data, len(self.row)) for where, part in zip(places, linear)
        ]
        self.parts = [
            (part, part.spread(where, len(self.row)))
            for where, part in zip(places[len(linear) :], squares)
        ]

    def at(self, q: np.ndarray, scale: float) -> np.ndarray:
        """Its entries (m, k) at `row` and `column`, the lower triangle, of displacements (m, n)."""
        mass, *stiffness = self.linear
        found = np.tile(scale * mass + sum(stiffness), (len(q), 1))
        for part, spread in self.parts:
            found += (spread @ np.stack([part.moduli(one) for one in q], axis=1)).T
        return found

    def solve(self, q: np.ndarray, r: np.ndarray, scale: float) -> np.ndarray:
        """A(q)^-1 r (m, n) of displacements and right sides (m, n)."""

        def some(rows: np.ndarray) -> list[np.ndarray]:
            return [self._solved(*one) for one in zip(self.at(q[rows], scale), r[rows])]

        count = min(worth(self.n), len(q))
        parts = mapped(some, np.array_split(np.arange(len(q)), count), count)
        return np.stack([one for part in parts for one in part])

    def _solved(self, values: np.ndarray, r: np.ndarray) -> np.ndarray:
        """Of entries (k,) and a right side (n,)."""
        half, below = self.half, self.row - self.column
        if half > WIDEST:
            lower = csc_matrix((values, (self.row, self.column)), shape=(self.n, self.n))
            return splu(lower + tril(lower, -1).T.tocsc()).solve(r)
        band = np.zeros((half + 1, self.n), order="F")
        band[below, self.column] = values
        _, found, fault = dpbsv(band, r, lower=True, overwrite_ab=True)
        if not fault:
            return found
        # With pivots: rounding may leave a body that is stretched beyond all measure indefinite.
        band = np.zeros((3 * half + 1, self.n), order="F")
        band[2 * half + below, self.column] = band[2 * half - below, self.row] = values
        return dgbsv(half, half, band, r, overwrite_ab=True)[2]


class _Square:
    """One potential: entries of B' (.) B, the lower triangle, as a linear function of that of what
    stands between, point by point.
    """

    def __init__(self, potential: Quartic):
        self.potential, points = potential, len(potential.weight)
        local = coo_matrix(potential.local)
        point, component = local.row % points, local.row // points
        order = np.argsort(point, kind="stable")
        point, component, dof, value = (
            part[order] for part in (point, component, local.col, local.data)
        )
        left, right = _pairs(point, points)
        lower = dof[left] >= dof[right]
        left, right = left[lower], right[lower]
        self.row, self.col = dof[left].astype(np.int64), dof[right].astype(np.int64)
        self.value = value[left] * value[right]
        k = potential.linear.shape[1]
        self.triangle = np.tril_indices(k)
        place = np.zeros((k, k), np.int64)
        place[self.triangle] = place.T[self.triangle] = np.arange(k * (k + 1) // 2)
        self.between = place[component[left], component[right]] * points + point[left]
        self.count = k * (k + 1) // 2 * points
        self.undeformed = self._moduli(np.zeros(local.shape[1]))

    def spread(self, place: np.ndarray, size: int) -> csr_matrix:
        """(size, c): what stands between goes to these places (l,) of the entries."""
        return csr_matrix((self.value, (place, self.between)), shape=(size, self.count))

    def moduli(self, q: np.ndarray) -> np.ndarray:
        """w (J' D J - L' D L) of all points (c,) of a displacement (n,); c counts the lower
        triangles, point by point.
        """
        return self._moduli(q) - self.undeformed

    def _moduli(self, q: np.ndarray) -> np.ndarray:
        part = self.potential
        m, k = part.linear.shape
        y = (part.local @ q).reshape(k, -1)
        slope = 2.0 * part.square.transpose(0, 2, 1).reshape(-1, k) @ y + part.linear.reshape(-1, 1)
        slope = slope.reshape(m, k, -1)
        stress = (part.moduli @ slope.reshape(m, -1)).reshape(m, k, -1) * part.weight
        found = [np.einsum("mp,mp->p", slope[:, i], stress[:, j]) for i, j in zip(*self.triangle)]
        return np.concatenate(found)


def _places(row: np.ndarray, column: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Row and column of each entry of a lower triangle, once; which of them each given one is."""
    width = int((row - column).max()) + 1
    slots = column * np.int64(width) + (row - column)
    if width > WIDEST:
        slots, place = np.unique(slots, return_inverse=True)
    else:  # as many as a band has, and sorting takes longer than looking at all of them
        there = np.bincount(slots) > 0
        place = (np.cumsum(there) - 1)[slots]
        slots = np.flatnonzero(there)
    return slots // width + slots % width, slots // width, place


def _pairs(point: np.ndarray, points: int) -> tuple[np.ndarray, np.ndarray]:
    """Which entries, in the order of their points, share one: two index arrays."""
    count = np.bincount(point, minlength=points)
    start, own = np.cumsum(count) - count, count[point]
    left = np.repeat(np.arange(len(point)), own)
    return left, start[point[left]] + np.arange(len(left)) - np.repeat(np.cumsum(own) - own, own)
