"""A banded matrix solved again and again for one right-hand side: small dense products.

Substitution would wait from row to row. Cut into blocks at least as large as the half bandwidth b,
A is block tridiagonal, and of two neighbours only b rows and b columns touch. With the Schur
complements  S_1 = A_11,  S_i = A_ii - A_i,i-1 S_i-1^-1 A_i-1,i  a solution of A x = f is

    z_i = S_i^-1 f_i - (S_i^-1 A_i,i-1) z_i-1,    x_i = z_i - (S_i^-1 A_i,i+1) x_i+1,

whose matrices are made beforehand. Source: Golub and Van Loan, Matrix Computations, 4.5.1. Inverted
blocks cost digits where A is nearly singular; an operator that contains a mass is not.

Own code, where LAPACK substitutes row by row: row `without geometric_nonlinearity, one state` of
the benchmark `effects`.
"""

import numpy as np
from numba import types

from vibrom.kernels.lanes import WIDTH, cut, fill, kernel, paste, room


def factorise(band: np.ndarray) -> np.ndarray:
    """(blocks, size + 2 b, size) of a symmetric band (n, b + 1): by columns S_i^-1, then b of
    S_i^-1 A_i,i-1, then b of S_i^-1 A_i,i+1.
    """
    n, half = band.shape[0], band.shape[1] - 1
    size = WIDTH * max(-(-half // WIDTH), 1)
    count = -(-n // size)
    # No entries beyond the band, and ones on the diagonal behind the last row.
    filled = np.pad(band, ((0, count * size - n), (0, size)))
    filled[n:, 0] = 1.0
    row, column = np.indices((size, size))
    factors = room(count * (size + 2 * half), size).reshape(count, size + 2 * half, size)
    before, subtracted = np.zeros((size, size)), 0.0  # A_i,i-1 and A_i,i-1 S_i-1^-1 A_i-1,i
    for i, part in enumerate(filled.reshape(count, size, -1)):
        beyond = np.minimum(size + row - column, size + half)
        behind = np.where(row <= column, part[column, beyond], 0.0)  # A_i+1,i
        inverse = np.linalg.inv(
            part[np.minimum(row, column), np.minimum(abs(row - column), half + 1)] - subtracted
        )
        factors[i, :size] = inverse.T
        factors[i, size : size + half] = (inverse @ before).T[size - half :]
        factors[i, size + half :] = (inverse @ behind.T).T[:half]
        before, subtracted = behind, behind @ inverse @ behind.T
    return factors


@kernel(types.void(types.float64[:, :, ::1], types.float64[:, ::1]))
def solve(factors, x):
    """x (n, 1) becomes A^-1 x, from what `factorise` returns."""
    count, depth, size = factors.shape
    half, n, z = (depth - size) // 2, x.shape[0], room(1, count * size)
    for i in range(count):
        for r in range(0, size, WIDTH):
            at, total = i * depth * size + r, fill(0.0, WIDTH)
            for j in range(min(size, n - i * size)):
                total += x[i * size + j, 0] * cut(factors, at + j * size, WIDTH)
            if i > 0:
                for j in range(half):
                    total -= z[0, i * size - half + j] * cut(factors, at + (size + j) * size, WIDTH)
            paste(z, i * size + r, total)
    for i in range(count - 2, -1, -1):
        for r in range(0, size, WIDTH):
            at, total = (i * depth + size + half) * size + r, cut(z, i * size + r, WIDTH)
            for j in range(half):
                total -= z[0, (i + 1) * size + j] * cut(factors, at + j * size, WIDTH)
            paste(z, i * size + r, total)
    for i in range(n):
        x[i, 0] = z[0, i]
