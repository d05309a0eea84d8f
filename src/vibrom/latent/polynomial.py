"""Polynomials of several variables and their least-squares fit.

    Phi_k(y) = prod_i y_i^e_ki,    f(y) = sum_k R_k Phi_k(y)

with every monomial of total degree lowest..highest in graded order: y1, y2, y1^2, y1 y2, y2^2, ...
Any order, any dimension.
"""

from functools import lru_cache
from itertools import combinations_with_replacement

import numpy as np

from vibrom.models.samples import Samples
from vibrom.models.training import Underdetermined


@lru_cache(maxsize=64)
def exponents(dimension: int, lowest: int, highest: int) -> np.ndarray:
    """(l, dimension) exponents of all monomials of total degree lowest..highest."""
    rows = [
        np.bincount(np.array(combination, int), minlength=dimension)
        for degree in range(lowest, highest + 1)
        for combination in combinations_with_replacement(range(dimension), degree)
    ]
    table = np.array(rows, dtype=np.int64).reshape(-1, dimension)
    table.setflags(write=False)
    return table


def monomials(y: np.ndarray, powers: np.ndarray) -> np.ndarray:
    """(*batch, l) values of the monomials with exponents `powers` (l, dimension) at y (*batch,
    dimension).
    """
    if len(powers) == 0:
        return np.zeros((*y.shape[:-1], 0))
    table = np.ones((int(powers.max()) + 1, *y.shape))
    for degree in range(1, len(table)):
        np.multiply(table[degree - 1], y, out=table[degree])
    result = table[powers[:, 0], ..., 0]
    for axis in range(1, powers.shape[1]):
        result *= table[powers[:, axis], ..., axis]
    return np.moveaxis(result, 0, -1)


def slopes(y: np.ndarray, powers: np.ndarray, along: np.ndarray) -> np.ndarray:
    """(*batch, l) derivatives of the monomials at y along a direction (*batch, dimension):  sum_i
    e_i Phi / y_i along_i.
    """
    total = np.zeros((*y.shape[:-1], len(powers)))
    for axis in range(y.shape[-1]):
        (rising,) = np.nonzero(powers[:, axis])
        lower = powers[rising].copy()
        lower[:, axis] -= 1
        total[..., rising] += powers[rising, axis] * monomials(y, lower) * along[..., axis, None]
    return total


def least_squares(library: np.ndarray, target: np.ndarray | Samples) -> np.ndarray:
    """R (m, l) that minimises |target - library R'|; library (samples, l), target (samples, m).

    Columns are scaled to unit length first, so that the rank decision of the SVD does not depend on
    the units of the variables. Underdetermined where the rank is below l: few samples, samples that
    repeat one another, or motions along fewer directions than there are variables. What the SVD
    would return then, the shortest of all that fit, is no model of anything.
    """
    if isinstance(target, Samples):
        return np.concatenate([least_squares(library, block) for _, block in target.columns()])
    samples, terms = library.shape
    size = np.linalg.norm(library, axis=0)
    size[size == 0.0] = 1.0
    solution, _, rank, _ = np.linalg.lstsq(library / size, target, rcond=None)
    if rank < terms:
        raise Underdetermined(
            f"of {terms} coefficients the {samples} samples determine {rank}; lower the order, or "
            "give data that differ more from one another"
        )
    return (solution / size[:, None]).T


def check_determined(y: np.ndarray, order: int) -> None:
    """Underdetermined where samples y (m, dimension) do not determine a polynomial of this order
    without a constant.
    """
    least_squares(monomials(y / np.abs(y).max(), exponents(y.shape[1], 1, order)), y)
