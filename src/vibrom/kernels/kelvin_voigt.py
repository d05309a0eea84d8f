"""Viscous stresses at a point of an element, in lanes; see `effects/kelvin_voigt.py`.

Gradients H and their rates K are tuples by rows, as in `saint_venant_kirchhoff`.
"""

import numpy as np

from vibrom.kernels.saint_venant_kirchhoff import (
    PAIRS,
    SIDES,
    deformation,
    first_stress,
    moduli_block,
    square,
    stresses,
)
from vibrom.kernels.unrolled import sum_of, unrolled


@unrolled
def added_rate_stress(d, h, k):
    """F S - D : eps,  S = D : sym(F'K) and eps = sym K, of a rate K of H."""
    return first_stress(d, h, k, stresses.plain(d, _mixed(h, k)))


def _mixed(h, k):
    """Strains of sym(H'K)."""
    dim = SIDES[len(h)]
    products = {
        (i, j): sum_of(h[dim * l + i] * k[dim * l + j] for l in range(dim))
        for i, j in np.ndindex(dim, dim)
    }
    return tuple(
        products[i, j] if i == j else products[i, j] + products[j, i] for i, j in PAIRS[dim]
    )


@unrolled
def rate_elasticity(d, h, k, by_h, by_k):
    """by_h d/dH + by_k d/dK of `added_rate_stress`."""
    dim = SIDES[len(h)]
    f, unit = deformation(h), deformation([0.0] * dim**2)
    linear = [k[dim * i + i] if i == j else k[dim * i + j] + k[dim * j + i] for i, j in PAIRS[dim]]
    s = square(stresses.plain(d, [x + y for x, y in zip(linear, _mixed(h, k))]))
    made = []
    for i, j in np.ndindex(dim, dim):
        row = [by_h * k[dim * j + l] + by_k * f[j][l] for l in range(dim)]
        block = moduli_block(d, f[i], row)
        block = [x - by_k * y for x, y in zip(block, moduli_block(d, unit[i], unit[j]))]
        if i == j:
            stress = [s[a][b] for a in range(dim) for b in range(dim)]
            block = [x + by_h * y for x, y in zip(block, stress)]
        made += block
    return tuple(made)
