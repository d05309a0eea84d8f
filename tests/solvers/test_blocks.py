"""Solves by blocks against LAPACK's banded Cholesky method."""

import numpy as np
import pytest
from scipy.linalg import solveh_banded

from vibrom.kernels import blocks


@pytest.mark.parametrize(
    ("n", "half"), [(1, 0), (5, 0), (7, 3), (8, 1), (20, 8), (241, 9), (240, 17)]
)
def test_any_size_and_band(n, half):
    rng = np.random.default_rng(n)
    band = rng.standard_normal((n, half + 1))
    band[:, 0] += 3 * half + 5
    for d in range(1, half + 1):
        band[n - d :, d] = 0.0
    x = rng.standard_normal((n, 1))
    expected = solveh_banded(band.T, x, lower=True)
    blocks.solve(blocks.factorise(band), x)
    np.testing.assert_allclose(x, expected, rtol=0, atol=1e-14 * np.abs(expected).max())
