"""Linear systems of the quadratic pencil  A(s) = s^2 M + s C + K,  plain and bordered.

    A w + B r = f,    G w + D r = g    with k rows G and columns B

Near an eigenvalue A is singular and the bordered system is not. Block elimination then takes
A + E' x E, with x added to m diagonal entries, as its matrix and the m displacements E w as further
unknowns: the band stays as it is. A narrow band is factorised by LAPACK, a wide one by SuperLU.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg.lapack import zgbtrf, zgbtrs
from scipy.sparse import csc_matrix, csr_matrix, diags
from scipy.sparse.linalg import splu

from vibrom.kernels.banded import half_bandwidth

WIDEST = 100  # half bandwidth that is still factorised as a band
PIVOT = 0.01  # a diagonal entry is the pivot unless the column holds one a hundred times as large


class Border(NamedTuple):
    """k further unknowns and equations."""

    columns: np.ndarray  # B' (k, n)
    rows: np.ndarray  # G (k, n)
    corner: np.ndarray  # D (k, k)
    pinned: np.ndarray  # (m,) displacements in which the near null vectors of A differ most


@dataclass(frozen=True)
class Pencil:
    """M, C and K (n, n) of one pattern, symmetric or not."""

    mass: csr_matrix
    damping: csr_matrix
    stiffness: csr_matrix

    @property
    def size(self) -> int:
        """Number of unknowns n."""
        return self.mass.shape[0]

    @cached_property
    def symmetric(self) -> bool:
        """Are all three?"""
        parts = (self.mass, self.damping, self.stiffness)
        return all(abs(a - a.T).max() <= 1e-9 * abs(a).max() for a in parts)

    @cached_property
    def half(self) -> int:
        """Half bandwidth of all three."""
        return max(half_bandwidth(part) for part in (self.mass, self.damping, self.stiffness))

    def at(self, s: complex) -> csr_matrix:
        """A(s)."""
        return s * s * self.mass + s * self.damping + self.stiffness

    def derivative(self, s: complex) -> csr_matrix:
        """dA/ds = 2 s M + C."""
        return 2.0 * s * self.mass + self.damping

    @cached_property
    def _stiffest(self) -> float:
        """The largest entry of K."""
        return float(np.abs(self.stiffness.data).max())

    @cached_property
    def _entries(self) -> tuple[np.ndarray, np.ndarray]:
        """Where their entries stand in a band as LAPACK stores it, with room for its pivots, column
        by column; and the values (3, k) of M, C and K there.
        """
        parts = [part.tocoo() for part in (self.mass, self.damping, self.stiffness)]
        rows, columns = (
            np.concatenate([getattr(p, name) for p in parts]) for name in ("row", "col")
        )
        slots = columns.astype(np.int64) * (3 * self.half + 1) + 2 * self.half + rows - columns
        places, own = np.unique(slots, return_inverse=True)
        ends = np.cumsum([part.nnz for part in parts])[:-1]
        values = [
            np.bincount(where, part.data, len(places))
            for where, part in zip(np.split(own, ends), parts)
        ]
        return places, np.array(values)

    def solve(
        self, s: complex, f: np.ndarray, shift: tuple[np.ndarray, float] | None = None
    ) -> np.ndarray:
        """A(s)^-1 f (k, n); with a shift, A plus a number at some diagonal entries."""
        places, number = shift or (np.zeros(0, int), 0.0)
        if self.half <= WIDEST:
            return self._solve_band(s, f, places, number)
        added = np.zeros(self.size)
        added[places] = number
        matrix = csc_matrix(self.at(s) + diags(added), dtype=complex)
        symmetric = {
            "permc_spec": "MMD_AT_PLUS_A",
            "options": {"SymmetricMode": True, "DiagPivotThresh": PIVOT},
        }
        return splu(matrix, **(symmetric if self.symmetric else {})).solve(f.T).T

    def _solve_band(
        self, s: complex, f: np.ndarray, places: np.ndarray, number: float
    ) -> np.ndarray:
        half, (slots, (mass, damping, stiffness)) = self.half, self._entries
        band = np.zeros(self.size * (3 * half + 1), complex)
        band[slots] = s * s * mass + s * damping + stiffness
        band = band.reshape(self.size, -1)
        band[places, 2 * half] += number
        factors, pivots, _ = zgbtrf(band.T, half, half, overwrite_ab=True)
        return zgbtrs(factors, half, half, f.T, pivots)[0].T

    def solve_bordered(
        self, s: complex, f: np.ndarray, g: np.ndarray, border: Border
    ) -> tuple[np.ndarray, np.ndarray]:
        """(w, r) of the bordered system, for right sides f (j, n) and g (j, k)."""
        m, x = len(border.pinned), self._stiffest
        ends = np.zeros((m, self.size))
        ends[range(m), border.pinned] = x
        solved = self.solve(s, np.concatenate([f, ends, border.columns]), (border.pinned, x))
        plain, raised, columns = np.split(solved, [len(f), len(f) + m])
        # w = plain + raised t - columns r, with t = E w
        unknowns = np.concatenate([raised, -columns])
        small = np.hstack([unknowns[:, border.pinned], unknowns @ border.rows.T])
        small[:m, :m] -= np.eye(m)
        small[m:, m:] += border.corner.T
        known = np.hstack([-plain[:, border.pinned], g - plain @ border.rows.T])
        found = np.linalg.solve(small.T, known.T).T
        return plain + found @ unknowns, found[:, m:]
