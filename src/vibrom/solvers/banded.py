"""Symmetric banded matrices for several states side by side.

A (n, n) with half bandwidth b is stored as  band[j, d, w] = A[j + d, j]  of state w, d = 0..b: one column after the other, the state last.
`factorise` and `solve` are the plain column algorithms (Golub and Van Loan, Matrix Computations, 4.1 and 4.3), written in lanes. L D L' also takes a tangent that a far guess made
indefinite, where Cholesky's method ends.
"""

from functools import cache

import numpy as np
from numba import types
from scipy.sparse import coo_matrix, spmatrix

from vibrom.lanes import WIDTH, cut, kernel, load, paste, store

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


def band_slots(dofs: np.ndarray, half: int, symmetric: bool = True) -> np.ndarray:
    """(elements, d(d+1)/2), or (elements, d*d) for whole matrices, where each entry of an element's matrix goes in the flattened band.

    -1 for clamped ones, and for what a non-symmetric matrix has above the diagonal.
    """
    d = dofs.shape[1]
    rows, columns = (dofs[:, index] for index in (np.tril_indices(d) if symmetric else np.divmod(np.arange(d * d), d)))
    low, high = np.minimum(rows, columns), np.maximum(rows, columns)
    return np.ascontiguousarray(np.where((low >= 0) & (symmetric | (rows >= columns)), low * (half + 1) + (high - low), -1))


def product_form(band: np.ndarray, width: int) -> np.ndarray:
    """What the products take for a matrix (n, b + 1): for one state its diagonals (b + 1, n), whose rows are long."""
    return band if width > 1 else np.ascontiguousarray(band.T)


@kernel(types.void(_one, _one, _one))
def _multiply_add_alone(diagonals, x, y):
    depth, n = diagonals.shape
    x, y = x.reshape(n), y.reshape(n)
    for j in range(n):
        y[j] += diagonals[0, j] * x[j]
    for d in range(1, depth):
        row = diagonals[d]
        for j in range(n - d):
            y[j + d] += row[j] * x[j]
        for j in range(n - d):
            y[j] += row[j] * x[j + d]


@kernel(types.void(_one, _one, _one, _one, _one))
def _multiply_add_both_alone(first, second, x, z, y):
    depth, n = first.shape
    x, z, y = x.reshape(n), z.reshape(n), y.reshape(n)
    for j in range(n):
        y[j] += first[0, j] * x[j] + second[0, j] * z[j]
    for d in range(1, depth):
        a, b = first[d], second[d]
        for j in range(n - d):
            y[j + d] += a[j] * x[j] + b[j] * z[j]
        for j in range(n - d):
            y[j] += a[j] * x[j + d] + b[j] * z[j + d]


@cache
def kernels(width: int):
    """(multiply_add, multiply_add_both, factorise, solve) for `width` states; the products take matrices in `product_form`."""

    @kernel(types.void(_one, _one, _one))
    def multiply_add(band, x, y):
        """y += A x."""
        n, depth = band.shape
        for j in range(n):
            here = load(x, j, width)
            total = band[j, 0] * here
            for d in range(1, min(depth, n - j)):
                value = band[j, d]
                store(y, j + d, load(y, j + d, width) + value * here)
                total += value * load(x, j + d, width)
            store(y, j, load(y, j, width) + total)

    @kernel(types.void(_one, _one, _one, _one, _one))
    def multiply_add_both(first, second, x, z, y):
        """y += A x + B z."""
        n, depth = first.shape
        for j in range(n):
            xj, zj = load(x, j, width), load(z, j, width)
            total = first[j, 0] * xj + second[j, 0] * zj
            for d in range(1, min(depth, n - j)):
                a, b = first[j, d], second[j, d]
                store(y, j + d, load(y, j + d, width) + a * xj + b * zj)
                total += a * load(x, j + d, width) + b * load(z, j + d, width)
            store(y, j, load(y, j, width) + total)

    @kernel(types.void(_band))
    def factorise(band):
        """A = L D L' in place, without pivots; a state with a zero pivot ends as NaN and spoils no other."""
        n, depth = band.shape[0], band.shape[1]
        entries = band.reshape(n * depth, width)
        for j in range(n):
            inverse = 1.0 / load(entries, j * depth, width)
            reach = min(depth, n - j)
            if width == 1 and depth > 3 * WIDTH:  # long enough for lanes along the column
                for d in range(1, reach):
                    value, k = band[j, d, 0] / band[j, 0, 0], d
                    while k + WIDTH <= reach:
                        at = (j + d) * depth + k - d
                        paste(entries, at, cut(entries, at, WIDTH) - value * cut(entries, j * depth + k, WIDTH))
                        k += WIDTH
                    while k < reach:
                        band[j + d, k - d, 0] -= value * band[j, k, 0]
                        k += 1
            else:
                for d in range(1, reach):
                    value = inverse * load(entries, j * depth + d, width)
                    for k in range(d, reach):
                        at = (j + d) * depth + k - d
                        store(entries, at, load(entries, at, width) - value * load(entries, j * depth + k, width))
            # The column becomes that of L, and the diagonal keeps 1/D_j: substitution multiplies by it.
            for d in range(1, reach):
                store(entries, j * depth + d, inverse * load(entries, j * depth + d, width))
            store(entries, j * depth, inverse)

    @kernel(types.void(_band, _one))
    def solve(band, x):
        """x becomes A^-1 x, from the factors that `factorise` left in `band`."""
        n, depth = band.shape[0], band.shape[1]
        entries = band.reshape(n * depth, width)
        for j in range(n):
            here = load(x, j, width)
            for d in range(1, min(depth, n - j)):
                store(x, j + d, load(x, j + d, width) - load(entries, j * depth + d, width) * here)
            store(x, j, here * load(entries, j * depth, width))
        for j in range(n - 1, -1, -1):
            here = load(x, j, width)
            for d in range(min(depth, n - j) - 1, 0, -1):  # the newest last: only that product waits for the row before
                here -= load(entries, j * depth + d, width) * load(x, j + d, width)
            store(x, j, here)

    products = (multiply_add, multiply_add_both) if width > 1 else (_multiply_add_alone, _multiply_add_both_alone)
    return *products, factorise, solve
