"""Banded products, factors and solves against SciPy's dense ones."""

import numpy as np
import pytest
from scipy.sparse import csr_matrix

from vibrom.solvers import banded


@pytest.mark.parametrize(("width", "n", "half"), [(1, 40, 5), (1, 90, 40), (3, 40, 5), (8, 40, 5)])
def test_product_and_solve(width, n, half):
    rng = np.random.default_rng(0)
    full = np.tril(np.triu(rng.standard_normal((n, n)), -half))
    full = full @ full.T + n * np.eye(n)
    band = banded.to_band(csr_matrix(full), banded.half_bandwidth(csr_matrix(full)))
    multiply_add, multiply_add_both, cholesky, solve = banded.kernels(width)
    x, y = rng.standard_normal((n, width)), np.ones((n, width))
    multiply_add(banded.product_form(band, width), x, y)
    np.testing.assert_allclose(y, 1 + full @ x, rtol=1e-12)
    z = np.ones((n, width))
    multiply_add_both(banded.product_form(band, width), banded.product_form(2.0 * band, width), x, x**2, z)
    np.testing.assert_allclose(z, 1 + full @ (x + 2.0 * x**2), rtol=1e-11)
    factors = np.ascontiguousarray(band[:, :, None] * np.arange(1, width + 1.0))
    cholesky(factors)
    b = x.copy()
    solve(factors, b)
    np.testing.assert_allclose(b * np.arange(1, width + 1.0), np.linalg.solve(full, x), rtol=1e-10)


def test_indefinite_state_spoils_no_other():
    matrix = np.array([np.eye(3), -np.eye(3)])
    factors = np.zeros((3, 1, 2))
    factors[:, 0, :] = np.einsum("wjj->jw", matrix)
    cholesky = banded.kernels(2)[2]
    cholesky(factors)
    assert np.isfinite(factors[..., 0]).all()
    assert not np.isfinite(factors[..., 1]).all()
