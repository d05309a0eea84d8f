"""Symmetric banded matrices for several states side by side.

    A (n, n) of half bandwidth b:   band[j, d, w] = A[j + d, j] of state w,   d = 0..b

One column after the other, the state last. `factorise` and `solve` are the plain column algorithms
(Golub and Van Loan, Matrix Computations, 4.1 and 4.3), written in lanes. L D L' also takes a
tangent that a far guess made indefinite, where Cholesky's method ends. Others: `banded_whole`.

Own code, where LAPACK factorises one matrix a call: rows `factor` and `solve` of the benchmark
`budget`, and all of `sweep`.
"""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from numba import types
from scipy.sparse import coo_matrix, spmatrix

from vibrom.kernels.compiled import Blocks, Places, Rows, kernel, machine_type
from vibrom.kernels.lanes import WIDTH, cut, fill, get, paste, put


class Product(NamedTuple):
    """A symmetric matrix as the products take it; see `product`."""

    values: Rows
    places: Places


class Products(NamedTuple):
    """Two symmetric matrices of one pattern."""

    first: Rows
    second: Rows
    places: Places


class Kernels(NamedTuple):
    """What is compiled for a number of states, or its signatures."""

    multiply_add: Callable  # y += A x of a `Product`
    multiply_add_both: Callable  # y += a A x + b B x of `Products`, a and b (1, width)
    combine: Callable  # band = sum_k scales[k] parts[k]
    factorise: Callable  # A = L D L' in place
    solve: Callable  # x becomes A^-1 x


_band, _rows, _places = machine_type(Blocks), machine_type(Rows), machine_type(Places)
SIGNATURES = Kernels(
    types.void(_rows, _places, _rows, _rows),
    types.void(_rows, _rows, _places, _rows, _rows, _rows, _rows),
    types.void(_band, _rows, _band),
    types.void(_band),
    types.void(_band, _rows),
)


def pointers() -> types.Tuple:
    """The type of `Kernels` as a compiled loop takes them: it is not compiled again with them."""
    return types.Tuple([types.FunctionType(signature) for signature in SIGNATURES])


def half_bandwidth(matrix: spmatrix) -> int:
    """b, the largest distance of an entry from the diagonal."""
    entries = coo_matrix(matrix)
    return int(np.abs(entries.row - entries.col).max(initial=0))


def to_band(matrix: spmatrix, half: int, whole: bool = False) -> np.ndarray:
    """(n, half + 1) lower band of a symmetric matrix, or (n, 2 half + 1) the whole band."""
    entries, above = coo_matrix(matrix), half if whole else 0
    band = np.zeros((matrix.shape[0], half + 1 + above))
    d = entries.row - entries.col
    kept = d >= -above
    np.add.at(band, (entries.col[kept], above + d[kept]), entries.data[kept])
    return band


def band_slots(dofs: np.ndarray, half: int, symmetric: bool = True) -> np.ndarray:
    """Where each entry of an element's matrix goes in the flattened band: (elements, d(d+1)/2), or
    (elements, d*d) for whole matrices.

    -1 for clamped ones, and for what a non-symmetric matrix has above the diagonal.
    """
    d = dofs.shape[1]
    rows, columns = (
        dofs[:, index]
        for index in (np.tril_indices(d) if symmetric else np.divmod(np.arange(d * d), d))
    )
    low, high = np.minimum(rows, columns), np.maximum(rows, columns)
    kept = (low >= 0) & (symmetric | (rows >= columns))
    return np.ascontiguousarray(np.where(kept, low * (half + 1) + (high - low), -1))


def product(matrix: spmatrix | None, width: int) -> Product:
    """A symmetric matrix (n, n), less its zeros; without one, arrays without an entry.

    For one state the diagonals from the main one down, values (k, n) and their distances (k, 1),
    whose rows are long. For more, the rows, values (n, k) and their columns (n, k), filled up with
    zeros on the diagonal.
    """
    if matrix is None:
        return Product(np.zeros((0, 0)), np.zeros((0, 0), np.int64))
    return Product(*_common_pattern([matrix], width))


def products(first: spmatrix, second: spmatrix | None, width: int) -> Products:
    """Two symmetric matrices in the pattern of both; no second one is a matrix of zeros."""
    return Products(*_common_pattern([first, 0.0 * first if second is None else second], width))


def _common_pattern(matrices: list[spmatrix], width: int) -> tuple[np.ndarray, ...]:
    """Values of each matrix, and where they stand."""
    n, pattern = matrices[0].shape[0], sum(abs(matrix) for matrix in matrices).tocsr()
    pattern.eliminate_zeros()
    if width == 1:
        rows, columns = pattern.nonzero()
        distances = np.unique(np.append((rows - columns)[rows >= columns], 0))
        return *(
            np.stack([np.append(matrix.diagonal(-d), np.zeros(d)) for d in distances])
            for matrix in matrices
        ), distances[:, None].astype(np.int64)
    counts = np.diff(pattern.indptr)
    columns = np.tile(np.arange(n)[:, None], counts.max(initial=1)).astype(np.int64)
    there = np.arange(columns.shape[1]) < counts[:, None]
    columns[there] = pattern.indices
    return *(
        np.where(there, matrix.tocsr()[np.arange(n)[:, None], columns].toarray(), 0.0)
        for matrix in matrices
    ), columns


@kernel(SIGNATURES.multiply_add)
def _multiply_add_alone(diagonals, distances, x, y):
    n = diagonals.shape[1]
    x, y = x.reshape(n), y.reshape(n)
    for j in range(n):
        y[j] += diagonals[0, j] * x[j]
    for k in range(1, len(distances)):
        d, row = distances[k, 0], diagonals[k]
        ahead, below = x[d:], y[d:]  # an index j + d would be tested for being negative
        for j in range(n - d):
            below[j] += row[j] * x[j]
        for j in range(n - d):
            y[j] += row[j] * ahead[j]


@kernel(SIGNATURES.multiply_add_both)
def _multiply_add_both_alone(first, second, distances, a, b, x, y):
    n = first.shape[1]
    x, y, a, b = x.reshape(n), y.reshape(n), a[0, 0], b[0, 0]
    for j in range(n):
        y[j] += (a * first[0, j] + b * second[0, j]) * x[j]
    for k in range(1, len(distances)):
        d, one, other = distances[k, 0], first[k], second[k]
        ahead, below = x[d:], y[d:]
        for j in range(n - d):
            below[j] += (a * one[j] + b * other[j]) * x[j]
        for j in range(n - d):
            y[j] += (a * one[j] + b * other[j]) * ahead[j]


@kernel(SIGNATURES.combine)
def _combine_alone(parts, scales, band):
    size = band.size
    band, parts = band.reshape(size), parts.reshape(len(parts), size)
    band[:] = 0.0
    for k in range(len(parts)):
        scale, one = scales[k, 0], parts[k]
        for at in range(size):
            band[at] += scale * one[at]


@cache
def kernels(width: int) -> Kernels:
    """The kernels for `width` states side by side."""
    with_band = _factorise(width), _solve(width)
    if width == 1:
        return Kernels(_multiply_add_alone, _multiply_add_both_alone, _combine_alone, *with_band)
    return Kernels(*_product_kernels(width), _combine(width), *with_band)


def _product_kernels(width: int) -> tuple[Callable, Callable]:
    @kernel(SIGNATURES.multiply_add)
    def multiply_add(values, columns, x, y):
        n, entries = values.shape
        for i in range(n):
            total = get(y, i, width)
            for k in range(entries):
                total += values[i, k] * get(x, columns[i, k], width)
            put(y, i, total)

    @kernel(SIGNATURES.multiply_add_both)
    def multiply_add_both(first, second, columns, a, b, x, y):
        n, entries = first.shape
        by_first, by_second = get(a, 0, width), get(b, 0, width)
        for i in range(n):
            one = other = fill(0.0, width)
            for k in range(entries):
                here = get(x, columns[i, k], width)
                one += first[i, k] * here
                other += second[i, k] * here
            put(y, i, get(y, i, width) + by_first * one + by_second * other)

    return multiply_add, multiply_add_both


def _combine(width: int) -> Callable:
    @kernel(SIGNATURES.combine)
    def combine(parts, scales, band):
        """Of parts (k, n, b + 1) that all states share, and scales (k, width)."""
        n, depth = band.shape[0], band.shape[1]
        entries, parts = band.reshape(n * depth, width), parts.reshape(parts.shape[0], n * depth)
        for at in range(n * depth):
            total = parts[0, at] * get(scales, 0, width)
            for k in range(1, len(parts)):
                total += parts[k, at] * get(scales, k, width)
            put(entries, at, total)

    return combine


def _factorise(width: int) -> Callable:
    @kernel(SIGNATURES.factorise)
    def factorise(band):
        """Without pivots: a state with a zero pivot ends as NaN and spoils no other."""
        n, depth = band.shape[0], band.shape[1]
        entries = band.reshape(n * depth, width)
        for j in range(n):
            inverse = 1.0 / get(entries, j * depth, width)
            reach = min(depth, n - j)
            if width == 1 and depth > 3 * WIDTH:  # long enough for lanes along the column
                for d in range(1, reach):
                    value, k = band[j, d, 0] / band[j, 0, 0], d
                    while k + WIDTH <= reach:
                        at = (j + d) * depth + k - d
                        change = value * cut(entries, j * depth + k, WIDTH)
                        paste(entries, at, cut(entries, at, WIDTH) - change)
                        k += WIDTH
                    while k < reach:
                        band[j + d, k - d, 0] -= value * band[j, k, 0]
                        k += 1
            else:
                for d in range(1, reach):
                    value = inverse * get(entries, j * depth + d, width)
                    for k in range(d, reach):
                        at = (j + d) * depth + k - d
                        change = value * get(entries, j * depth + k, width)
                        put(entries, at, get(entries, at, width) - change)
            # The column becomes that of L, and the diagonal keeps 1/D_j, by which `solve`
            # multiplies.
            for d in range(1, reach):
                put(entries, j * depth + d, inverse * get(entries, j * depth + d, width))
            put(entries, j * depth, inverse)

    return factorise


def _solve(width: int) -> Callable:
    @kernel(SIGNATURES.solve)
    def solve(band, x):
        """From the factors that `factorise` left in `band`."""
        n, depth = band.shape[0], band.shape[1]
        entries = band.reshape(n * depth, width)
        for j in range(n):
            here = get(x, j, width)
            for d in range(1, min(depth, n - j)):
                put(x, j + d, get(x, j + d, width) - get(entries, j * depth + d, width) * here)
            put(x, j, here * get(entries, j * depth, width))
        for j in range(n - 1, -1, -1):
            here = get(x, j, width)
            # The newest last: only that product waits for the row before.
            for d in range(min(depth, n - j) - 1, 0, -1):
                here -= get(entries, j * depth + d, width) * get(x, j + d, width)
            put(x, j, here)

    return solve
