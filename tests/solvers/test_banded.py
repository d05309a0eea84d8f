"""Banded products, factors and solves against SciPy's dense ones."""

import numpy as np
import pytest
from scenes import LINEAR, body
from scipy.sparse import csr_matrix

from vibrom import effects
from vibrom.bodies import space
from vibrom.kernels import banded


@pytest.mark.parametrize(("width", "n", "half"), [(1, 40, 5), (1, 90, 40), (3, 40, 5), (8, 40, 5)])
def test_product_and_solve(width, n, half):
    rng = np.random.default_rng(0)
    full = np.tril(np.triu(rng.standard_normal((n, n)), -half))
    full = full @ full.T + n * np.eye(n)
    band = banded.to_band(csr_matrix(full), banded.half_bandwidth(csr_matrix(full)))
    multiply_add, multiply_add_both, combine, factorise, solve = banded.kernels(width)
    x, y = rng.standard_normal((n, width)), np.ones((n, width))
    sparse = csr_matrix(
        np.where(np.add.outer(np.arange(n), np.arange(n)) % 3, full, 0.0)
    )  # whole diagonals of it hold zeros, and rows differ in length
    multiply_add(*banded.product(sparse, width), x, y)
    np.testing.assert_allclose(y, 1 + sparse @ x, rtol=1e-12)
    z, a, b = (
        np.ones((n, width)),
        np.arange(1.0, width + 1)[None],
        np.linspace(0.5, 2.0, width)[None],
    )
    multiply_add_both(*banded.products(sparse, csr_matrix(full), width), a, b, x, z)
    np.testing.assert_allclose(z, 1 + a * (sparse @ x) + b * (full @ x), rtol=1e-10)
    combined = np.empty((n, band.shape[1], width))
    combine(np.stack([band, band**2]), np.concatenate([a, b]), combined)
    np.testing.assert_allclose(
        combined, a * band[:, :, None] + b * band[:, :, None] ** 2, rtol=1e-14, atol=1e-12
    )
    factors = np.ascontiguousarray(band[:, :, None] * np.arange(1, width + 1.0))
    factorise(factors)
    b = x.copy()
    solve(factors, b)
    np.testing.assert_allclose(b * np.arange(1, width + 1.0), np.linalg.solve(full, x), rtol=1e-10)


@pytest.mark.parametrize(("cells", "half"), [([40, 2], 9), ([9, 9], 2 * 11 + 1), ([2, 40], 7)])
def test_bodies_are_narrow_bands(cells, half):
    """A bilinear element reaches from one node of a line of k to the next but one of the next line:
    2 (k + 1) + 1.
    """
    made = space.build(body(cells=cells))
    assert banded.half_bandwidth(effects.assemble(made, LINEAR).stiffness) == half


def test_indefinite_matrices_are_solved_and_singular_ones_spoil_no_other():
    matrices = np.array(
        [
            [[4.0, 1.0, 0.0], [1.0, -3.0, 0.5], [0.0, 0.5, 2.0]],
            [[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 0.0]],
        ]
    )
    factors = np.zeros((3, 2, 2))
    factors[:, 0] = np.einsum("wjj->jw", matrices)
    factors[:2, 1] = np.array([matrices[:, 1, 0], matrices[:, 2, 1]])
    *_, factorise, solve = banded.kernels(2)
    x = np.ones((3, 2))
    factorise(factors)
    solve(factors, x)
    np.testing.assert_allclose(x[:, 0], np.linalg.solve(matrices[0], np.ones(3)), rtol=1e-14)
    assert not np.isfinite(x[:, 1]).all()
