"""Symmetric banded matrices for several states side by side.

A (n, n) with half bandwidth b is stored as  band[j, d, w] = A[j + d, j]  of state w, d = 0..b: one column after the other, the state last.
`cholesky` and `solve` are the plain column algorithms (Golub and Van Loan, Matrix Computations, 4.3.5); with the number of states
fixed at compilation their inner loops become vector instructions.
"""

from functools import cache

import numpy as np
from numba import njit, types
from scipy.sparse import coo_matrix, spmatrix

_band = types.float64[:, :, ::1]
_one = types.float64[:, ::1]


def half_bandwidth(matrix: spmatrix) -> int:
    entries = coo_matrix(matrix)
    return int(np.abs(entries.row - entries.col).max(initial=0))


def to_band(matrix: spmatrix, half: int) -> np.ndarray:
    """(n, half + 1) lower band of a symmetric matrix."""
    entries = coo_matrix(matrix)
    band = np.zeros((matrix.shape[0], half + 1))
    lower = entries.row >= entries.col
    np.add.at(band, (entries.col[lower], (entries.row - entries.col)[lower]), entries.data[lower])
    return band


def band_slots(dofs: np.ndarray, half: int) -> np.ndarray:
    """(elements, d(d+1)/2) where each entry of an element's lower triangle goes in the flattened band, -1 for clamped ones."""
    rows, columns = (dofs[:, index] for index in np.tril_indices(dofs.shape[1]))
    low, high = np.minimum(rows, columns), np.maximum(rows, columns)
    return np.ascontiguousarray(np.where(low >= 0, low * (half + 1) + (high - low), -1))


@cache
def kernels(width: int):
    """(multiply_add, multiply_add_each, cholesky, solve) for `width` states."""

    @njit([types.void(_one, _one, _one)], cache=True, fastmath=True, error_model="numpy")
    def multiply_add(band, x, y):
        """y += A x, the same A for every state."""
        n, depth = band.shape
        for j in range(n):
            for w in range(width):
                y[j, w] += band[j, 0] * x[j, w]
            for d in range(1, min(depth, n - j)):
                value = band[j, d]
                for w in range(width):
                    y[j + d, w] += value * x[j, w]
                    y[j, w] += value * x[j + d, w]

    @njit([types.void(_band, _one, _one)], cache=True, fastmath=True, error_model="numpy")
    def multiply_add_each(band, x, y):
        """y += A x, an A for each state."""
        n, depth = band.shape[0], band.shape[1]
        for j in range(n):
            for w in range(width):
                y[j, w] += band[j, 0, w] * x[j, w]
            for d in range(1, min(depth, n - j)):
                for w in range(width):
                    y[j + d, w] += band[j, d, w] * x[j, w]
                    y[j, w] += band[j, d, w] * x[j + d, w]

    @njit([types.void(_band)], cache=True, fastmath=True, error_model="numpy")
    def cholesky(band):
        """A = L L' in place; a state whose A is not positive definite ends as NaN and spoils no other."""
        n, depth = band.shape[0], band.shape[1]
        inverse = np.empty(width)
        for j in range(n):
            for w in range(width):
                inverse[w] = 1.0 / np.sqrt(band[j, 0, w])
            # The diagonal keeps 1/L_jj: substitution multiplies by it.
            for w in range(width):
                band[j, 0, w] = inverse[w]
            reach = min(depth, n - j)
            for d in range(1, reach):
                for w in range(width):
                    band[j, d, w] *= inverse[w]
            for d in range(1, reach):
                for k in range(d, reach):
                    for w in range(width):
                        band[j + d, k - d, w] -= band[j, d, w] * band[j, k, w]

    @njit([types.void(_band, _one)], cache=True, fastmath=True, error_model="numpy")
    def solve(band, x):
        """x becomes A^-1 x, from the factor that `cholesky` left in `band`."""
        n, depth = band.shape[0], band.shape[1]
        for j in range(n):
            for w in range(width):
                x[j, w] *= band[j, 0, w]
            for d in range(1, min(depth, n - j)):
                for w in range(width):
                    x[j + d, w] -= band[j, d, w] * x[j, w]
        for j in range(n - 1, -1, -1):
            for d in range(1, min(depth, n - j)):
                for w in range(width):
                    x[j, w] -= band[j, d, w] * x[j + d, w]
            for w in range(width):
                x[j, w] *= band[j, 0, w]

    return multiply_add, multiply_add_each, cholesky, solve
