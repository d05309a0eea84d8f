"""Compiled ratios of polynomials, eight states side by side:  dz/dt = R Phi(z / s) / d Phi(z / s).

The denominator is one more row of the polynomials of `polynomial_kernel`.
"""

import numpy as np

from vibrom.kernels.lanes import WIDTH, fill, get, put
from vibrom.latent.polynomial_kernel import polynomial_kernel, weighted
from vibrom.solvers.reduced.field import Kernel, field_kernel


@field_kernel
def _ratio(z, numbers, index, work, out):
    # Tables as those of `polynomial_kernel`, with the denominator's row last.
    r, products = len(z), index[0]
    put(work, 0, fill(1.0, WIDTH))
    for i in range(r):
        put(work, 1 + i, get(z, i, WIDTH) * numbers[i])
    for k in range(products):
        factor, variable = index[1 + 2 * k], 1 + index[2 + 2 * k]
        put(work, 1 + r + k, get(work, factor, WIDTH) * get(work, variable, WIDTH))
    at, coefficient = 1 + 2 * products, r
    for i in range(r + 1):
        total = weighted(numbers, index, work, coefficient, at)
        if i < r:
            put(out, i, total)
        else:
            inverse = 1.0 / total
            for j in range(r):
                put(out, j, get(out, j, WIDTH) * inverse)
        coefficient += index[at]
        at += 1 + index[at]


def ratio_kernel(
    scale: np.ndarray, powers: np.ndarray, numerators: np.ndarray, denominator: np.ndarray
) -> Kernel:
    """With s (r,), exponents (l, r), R (r, l) and d (l,)."""
    if np.count_nonzero(denominator[powers.any(axis=1)]) == 0:
        constant = denominator[~powers.any(axis=1)].sum()
        return polynomial_kernel(scale, powers, numerators / constant)
    rows = polynomial_kernel(scale, powers, np.vstack([numerators, denominator]))
    return Kernel(_ratio, rows.numbers, rows.index, rows.rows, len(scale))
