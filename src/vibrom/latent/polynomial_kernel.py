"""Compiled polynomials of eight states side by side:  dz/dt = R Phi(z / s), and the constant force
that goes with linear encoders.

Every monomial is one multiplication, of an earlier monomial by a variable; monomials that the list
lacks are put in between. Zero coefficients cost nothing. The bounded form (see `extrapolation`)
carries with each monomial its derivative along z - c, by the rule of products, and adds the two.
"""

from functools import lru_cache

import numpy as np
from numba import njit

from vibrom.kernels.lanes import WIDTH, fill, get, part, positive, put, sqrt
from vibrom.solvers.reduced.field import Kernel, field_kernel


@part
def weighted(numbers, index, work, coefficient, at):
    """sum_k R_k Phi_k of the monomials in `work` that a row of the index, which begins at `at` with
    their number, names. Four sums at once, as each addition waits for the one before it; slices,
    as places counted from zero need no check for negative ones.
    """
    places = index[at + 1 : at + 1 + index[at]]
    values = numbers[coefficient : coefficient + len(places)]
    a = b = c = d = fill(0.0, WIDTH)
    for quarter in range(len(places) // 4):
        k = 4 * quarter
        a = a + get(work, places[k], WIDTH) * values[k]
        b = b + get(work, places[k + 1], WIDTH) * values[k + 1]
        c = c + get(work, places[k + 2], WIDTH) * values[k + 2]
        d = d + get(work, places[k + 3], WIDTH) * values[k + 3]
    for k in range(len(places) - len(places) % 4, len(places)):
        a = a + get(work, places[k], WIDTH) * values[k]
    return (a + b) + (c + d)


@njit(error_model="numpy")
def _rows(r, products, coefficient, numbers, index, work, out):
    """out_i = sum_k R_ik Phi_k of the monomials in `work`."""
    at = 1 + 2 * products
    for i in range(r):
        put(out, i, weighted(numbers, index, work, coefficient, at))
        coefficient += index[at]
        at += 1 + index[at]


@field_kernel
def _polynomial(z, numbers, index, work, out):
    # numbers: 1/s (r), then the coefficients row by row; index: number of products, their (factor,
    # variable), then for each row a count and its monomials.
    r, products = len(z), index[0]
    put(work, 0, fill(1.0, WIDTH))
    for i in range(r):
        put(work, 1 + i, get(z, i, WIDTH) * numbers[i])
    for k in range(products):
        put(
            work,
            1 + r + k,
            get(work, index[1 + 2 * k], WIDTH) * get(work, 1 + index[2 + 2 * k], WIDTH),
        )
    _rows(r, products, r, numbers, index, work, out)


@field_kernel
def _bounded(z, numbers, index, work, out):
    # As `_polynomial`, with 1/reach (r) between 1/s and the coefficients; work: the monomials, then
    # their derivatives along z - c.
    r, products = len(z), index[0]
    d, along = r // 2, 1 + r + products
    put(work, 0, fill(1.0, WIDTH))
    put(work, along, fill(0.0, WIDTH))
    for i in range(d):
        position, velocity = get(z, i, WIDTH), get(z, d + i, WIDTH)
        x, y = position * numbers[r + i], velocity * numbers[r + d + i]
        square = x * x + y * y
        shrink = positive(square - 1.0, 1.0 / sqrt(square), 1.0)
        rest = 1.0 - shrink
        put(work, 1 + i, position * shrink * numbers[i])
        put(work, 1 + d + i, velocity * shrink * numbers[d + i])
        put(work, along + 1 + i, position * rest * numbers[i])
        put(work, along + 1 + d + i, velocity * rest * numbers[d + i])
    for k in range(products):
        factor, variable = index[1 + 2 * k], 1 + index[2 + 2 * k]
        a, b = get(work, factor, WIDTH), get(work, variable, WIDTH)
        put(work, 1 + r + k, a * b)
        put(
            work,
            along + 1 + r + k,
            get(work, along + factor, WIDTH) * b + a * get(work, along + variable, WIDTH),
        )
    for k in range(along):
        put(work, k, get(work, k, WIDTH) + get(work, along + k, WIDTH))
    _rows(r, products, 2 * r, numbers, index, work, out)


@field_kernel
def _constant(z, numbers, index, work, out):
    for i in range(len(z)):
        put(out, i, fill(numbers[i], WIDTH))


@lru_cache(maxsize=64)
def _products(
    dimension: int, powers: tuple[tuple[int, ...], ...]
) -> tuple[list[tuple[int, int]], list[int], int]:
    """(factor, variable) of each product, where each wanted monomial is kept, and how many are
    kept: 1, the variables, then the products.
    """
    kept = {(0,) * dimension: 0} | {
        tuple(int(axis == variable) for axis in range(dimension)): 1 + variable
        for variable in range(dimension)
    }
    products: list[tuple[int, int]] = []

    def place(power: tuple[int, ...]) -> int:
        if power not in kept:
            # Halving the degree instead would be shallower; a factor that the list holds anyway
            # costs nothing.
            parents = [
                (tuple(e - (axis == variable) for axis, e in enumerate(power)), variable)
                for variable in range(dimension)
                if power[variable]
            ]
            parent, variable = next(
                ((known, variable) for known, variable in parents if known in kept), parents[0]
            )
            products.append((place(parent), variable))
            kept[power] = len(kept)
        return kept[power]

    places = [place(power) for power in sorted(powers, key=sum)]
    order = dict(zip(sorted(powers, key=sum), places))
    return products, [order[power] for power in powers], len(kept)


def polynomial_kernel(
    scale: np.ndarray, powers: np.ndarray, coefficients: np.ndarray, reach: np.ndarray | None = None
) -> Kernel:
    """sum_k R_k prod_i (z_i / s_i)^e_ki  with s (r,), exponents (l, r) and R (r, l); beyond `reach`
    (r,) continued along the radius.
    """
    products, places, rows = _products(len(scale), tuple(map(tuple, powers.tolist())))
    numbers, index = (
        [1.0 / np.asarray(part, float) for part in (scale, reach) if part is not None],
        [len(products), *(number for pair in products for number in pair)],
    )
    for row in np.asarray(coefficients, float):
        (used,) = np.nonzero(row)
        numbers.append(row[used])
        index += [len(used), *(places[k] for k in used)]
    function, rows = (_polynomial, rows) if reach is None else (_bounded, 2 * rows)
    integers = np.array(index, dtype=np.int64)
    return Kernel(function, np.concatenate(numbers), integers, rows, len(scale))


def constant_kernel(value: np.ndarray) -> Kernel:
    """The same (r,) for every state."""
    return Kernel(_constant, np.array(value, dtype=float), np.zeros(1, np.int64), 0, len(value))
