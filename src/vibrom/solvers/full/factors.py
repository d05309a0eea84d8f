"""Factors of large sparse matrices, whose `solve(b)` gives A^-1 b.

Positive definite ones are factorised as a band by LAPACK (Cholesky) where that fits into `ROOM`:
bodies in space fill a sparse factor so much that the band is faster (`python -m benchmarks solid`).
Others, and those that turn out indefinite, go to SuperLU; an ordering of the symmetric pattern
keeps its fill low.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import LinAlgError, cho_solve_banded, cholesky_banded
from scipy.sparse import csc_matrix, spmatrix
from scipy.sparse.linalg import splu

from vibrom.kernels.banded import half_bandwidth, to_band

WIDE = 200  # half bandwidth from which on a matrix is one of these
ROOM = 2**31  # bytes of a band


class Cholesky:
    """The factor of a symmetric positive definite band; raises LinAlgError where it is not one."""

    def __init__(self, matrix: csc_matrix, half: int):
        band = to_band(matrix, half).T
        self.band = cholesky_banded(band, overwrite_ab=True, lower=True, check_finite=False)

    def solve(self, b: np.ndarray) -> np.ndarray:
        """A^-1 b."""
        return cho_solve_banded((self.band, True), b, check_finite=False)


def is_wide(matrix: spmatrix) -> bool:
    """Is a matrix beyond what is cheap whatever one does?"""
    return half_bandwidth(matrix) > WIDE


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
