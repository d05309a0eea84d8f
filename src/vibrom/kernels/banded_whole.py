"""Banded matrices that are not symmetric, for several states side by side:  A = L U,

    A (n, n) of half bandwidth b:   band[j, b + d, w] = A[j + d, j] of state w,   d = -b..b

without pivots: what is added to a mass that dominates it needs none, and a state with a zero pivot
ends as NaN and spoils no other. Golub and Van Loan, Matrix Computations, 4.3.1. For the tangents of
mean forces, which follow a step's end at a fixed start.
"""

from collections.abc import Callable
from functools import cache

import numpy as np

from vibrom.kernels import banded
from vibrom.kernels.banded import SIGNATURES, Kernels
from vibrom.kernels.lanes import WIDTH, cut, get, kernel, paste, put


def slots(dofs: np.ndarray, half: int, symmetric: bool) -> list[np.ndarray]:
    """Where each entry of an element's matrix goes in the flattened band, -1 where it is clamped:
    (elements, d*d); of a symmetric one (elements, d(d+1)/2) for its lower triangle, and again for
    what mirrors it.
    """
    d = dofs.shape[1]
    lower = np.tril_indices(d) if symmetric else np.divmod(np.arange(d * d), d)
    rows, columns = (dofs[:, index] for index in lower)

    def places(rows: np.ndarray, columns: np.ndarray, kept: np.ndarray) -> np.ndarray:
        at = columns * (2 * half + 1) + half + rows - columns
        return np.ascontiguousarray(np.where(kept & (rows >= 0) & (columns >= 0), at, -1))

    found = [places(rows, columns, np.array(True))]
    if symmetric and d > 1:
        found.append(places(columns, rows, lower[0] != lower[1]))
    return found


@cache
def kernels(width: int) -> Kernels:
    """As `banded.kernels`, with these factors."""
    return banded.kernels(width)._replace(factorise=_factorise(width), solve=_solve(width))


def _factorise(width: int) -> Callable:
    @kernel(SIGNATURES.factorise)
    def factorise_whole(band):
        n, depth = band.shape[0], band.shape[1]
        half = depth // 2
        entries = band.reshape(n * depth, width)
        for j in range(n):
            below, reach = j * depth + half, min(half + 1, n - j)
            inverse = 1.0 / get(entries, below, width)
            for d in range(1, reach):
                put(entries, below + d, inverse * get(entries, below + d, width))
            put(entries, below, inverse)
            for c in range(1, reach):
                above = (j + c) * depth + half - c
                value, d = get(entries, above, width), 1
                if width == 1 and reach > 3 * WIDTH:  # long enough for lanes along the column
                    number = band[j + c, half - c, 0]
                    while d + WIDTH <= reach:
                        change = number * cut(entries, below + d, WIDTH)
                        paste(entries, above + d, cut(entries, above + d, WIDTH) - change)
                        d += WIDTH
                while d < reach:
                    change = value * get(entries, below + d, width)
                    put(entries, above + d, get(entries, above + d, width) - change)
                    d += 1

    return factorise_whole


def _solve(width: int) -> Callable:
    @kernel(SIGNATURES.solve)
    def solve_whole(band, x):
        """From the factors that `factorise_whole` left in `band`."""
        n, depth = band.shape[0], band.shape[1]
        half = depth // 2
        entries = band.reshape(n * depth, width)
        for j in range(n):
            here, below = get(x, j, width), j * depth + half
            for d in range(1, min(half + 1, n - j)):
                put(x, j + d, get(x, j + d, width) - get(entries, below + d, width) * here)
        for j in range(n - 1, -1, -1):
            at = j * depth + half
            here = get(x, j, width) * get(entries, at, width)
            put(x, j, here)
            for d in range(1, min(half, j) + 1):
                put(x, j - d, get(x, j - d, width) - get(entries, at - d, width) * here)

    return solve_whole
