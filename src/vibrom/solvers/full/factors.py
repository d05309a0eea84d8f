"""Factors of large sparse matrices, whose `solve(b)` gives A^-1 b.

Positive definite ones are factorised as a band by LAPACK (Cholesky) where that fits into `ROOM`:
bodies in space fill a sparse factor so much that the band is faster. Of 27 000 displacements, half
bandwidth 725: 0.8 s against 27 s of SuperLU, and a seventh of the memory. Others, and those that
turn out indefinite, go to SuperLU; an ordering of the symmetric pattern keeps its fill low.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import LinAlgError, cho_solve_banded, cholesky_banded
from scipy.sparse import csc_matrix, spmatrix
from scipy.sparse.linalg import splu

WIDE = 200  # half bandwidth from which on a matrix is one of these
ROOM = 2**31  # bytes of a band


class Cholesky:
    """The factor of a symmetric positive definite band; raises LinAlgError where it is not one."""

    def __init__(self, matrix: csc_matrix, half: int):
        n = matrix.shape[0]
        column = np.repeat(np.arange(n), np.diff(matrix.indptr))
        low = matrix.indices >= column
        band = np.zeros((n, half + 1))
        band[column[low], (matrix.indices - column)[low]] = matrix.data[low]
        self.band = cholesky_banded(band.T, overwrite_ab=True, lower=True, check_finite=False)

    def solve(self, b: np.ndarray) -> np.ndarray:
        """A^-1 b."""
        return cho_solve_banded((self.band, True), b, check_finite=False)


def half_bandwidth(matrix: csc_matrix) -> int:
    """Of a matrix by columns."""
    column = np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr))
    return int(np.abs(matrix.indices - column).max(initial=0))


def is_wide(matrix: spmatrix) -> bool:
    """Is a matrix beyond what is cheap whatever one does?"""
    return half_bandwidth(csc_matrix(matrix)) > WIDE


def factor(matrix: csc_matrix, symmetric: bool, pivots: bool = True):
    """The factor; without pivots where a symmetric matrix is known to need none."""
    if symmetric:
        half = half_bandwidth(matrix)
        if half > WIDE and 8 * matrix.shape[0] * (half + 1) <= ROOM:
            try:
                return Cholesky(matrix, half)
            except LinAlgError:
                pass
        if half > WIDE or not pivots:
            options = {"SymmetricMode": True} if not pivots else None
            return splu(matrix, permc_spec="MMD_AT_PLUS_A", options=options or {})
    return splu(matrix)
