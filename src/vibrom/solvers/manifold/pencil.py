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

    columns: np.ndarray  # B (n, k)
    rows: np.ndarray  # G (k, n)
    corner: np.ndarray  # D (k, k)
    right: np.ndarray  # g (k,)
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
    def _bands(self) -> np.ndarray:
        """(3, 3 b + 1, n): M, C and K as LAPACK stores a band, with room for its pivots, column by
        column.
        """
        b, n = self.half, self.size
        bands = np.zeros((3, n, 3 * b + 1)).transpose(0, 2, 1)
        for band, part in zip(bands, (self.mass, self.damping, self.stiffness)):
            entries = part.tocoo()
            np.add.at(band, (2 * b + entries.row - entries.col, entries.col), entries.data)
        return bands

    def factor(self, s: complex, shift: tuple[np.ndarray, float] | None = None):
        """Solves with A(s), plus a number at some diagonal entries, for right sides (n, k)."""
        places, number = shift or (np.zeros(0, int), 0.0)
        if self.half <= WIDEST:
            mass, damping, stiffness = self._bands
            band = s * s * mass + s * damping + stiffness
            band[2 * self.half, places] += number
            factors, pivots, _ = zgbtrf(band, self.half, self.half, overwrite_ab=1)
            return lambda f: zgbtrs(factors, self.half, self.half, f, pivots)[0]
        added = np.zeros(self.size)
        added[places] = number
        matrix = csc_matrix(self.at(s) + diags(added), dtype=complex)
        if not self.symmetric:
            return splu(matrix).solve
        options = {"SymmetricMode": True, "DiagPivotThresh": PIVOT}
        return splu(matrix, permc_spec="MMD_AT_PLUS_A", options=options).solve

    def solve(self, s: complex, f: np.ndarray) -> np.ndarray:
        """A(s)^-1 f (n,)."""
        return self.factor(s)(f[:, None])[:, 0]

    def solve_bordered(
        self, s: complex, f: np.ndarray, border: Border
    ) -> tuple[np.ndarray, np.ndarray]:
        """(w, r) of the bordered system."""
        k, x = len(border.pinned), self._stiffest
        ends = np.zeros((self.size, k), complex)
        ends[border.pinned, range(k)] = x
        solve = self.factor(s, (border.pinned, x))
        plain, raised, columns = np.split(
            solve(np.column_stack([f, ends, border.columns])), [1, 1 + k], axis=1
        )
        # w = plain + raised t - columns r, with t = E w
        unknowns = np.hstack([raised, -columns])
        small = np.vstack([unknowns[border.pinned], border.rows @ unknowns])
        small[:k, :k] -= np.eye(k)
        small[k:, k:] += border.corner
        known = np.concatenate([plain[border.pinned, 0], border.rows @ plain[:, 0]])
        found = np.linalg.solve(small, np.concatenate([np.zeros(k), border.right]) - known)
        return plain[:, 0] + unknowns @ found, found[k:]
