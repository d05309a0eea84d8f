"""A polynomial manifold over given coordinates, by least squares.

    q = N(y),   v = N'(y),   dz/dt = R(y) + S(y) p u,   y = z / Z

All are polynomials in every reduced coordinate, positions and velocities alike. A sample of the
training data weighs |y|^`amplitude_power`.

A load changes the state at the rate (0, M^-1 p u). What of it is motion along the manifold, the
symplectic form of the free body says, as it does for any canonical change of coordinates:

    t_i = (dq/dy_i, dv/dy_i),   W_ij = dq_i.M dv_j - dv_i.M dq_j,   sum_j W_ij S_j = dq_i
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from vibrom.latent.polynomial import exponents, least_squares, monomials


@dataclass(frozen=True)
class Polynomials:
    """Several of the same monomials."""

    coefficients: np.ndarray  # (k, l)
    powers: np.ndarray  # (l, 2d), the constant first

    def slope(self, y: np.ndarray, axis: int) -> np.ndarray:
        """Derivative (m, k) along one coordinate at y (m, 2d)."""
        lower = self.powers.copy()
        lower[:, axis] = np.maximum(lower[:, axis] - 1, 0)
        return (self.powers[:, axis] * monomials(y, lower)) @ self.coefficients.T


def weights(y: np.ndarray, amplitude_power: float) -> np.ndarray:
    """(m,) A sample at rest says nothing, and must not weigh infinitely."""
    size = np.linalg.norm(y, axis=1)
    return np.maximum(size / size.max(), 1e-6) ** amplitude_power


def fitted(
    y: np.ndarray,
    weight: np.ndarray,
    target: np.ndarray,
    order: int,
    *,
    constant: bool = False,
    linear: np.ndarray | None = None,
) -> Polynomials:
    """Those nearest to `target` (m, k) at y (m, 2d): zero at y = 0 unless they may have a
    `constant`, and with this linear part (k, 2d) where it is known.
    """
    powers = exponents(y.shape[1], 0, order)
    found = np.zeros((target.shape[1], len(powers)))
    first = 0 if constant else 1
    if linear is not None:
        first = 1 + y.shape[1]
        found[:, 1:first] = linear
        target = target - y @ linear.T
    library = monomials(y, powers[first:])
    found[:, first:] = least_squares(weight[:, None] * library, weight[:, None] * target)
    return Polynomials(found, powers)


def symplectic_push(
    shape: Polynomials, velocity: Polynomials, mass: csr_matrix, basis: np.ndarray, y: np.ndarray
) -> np.ndarray:
    """S B (m, 2d, k): dy/dt per unit of B'p, at y (m, 2d); the basis B (n, k) is orthonormal."""
    inner = basis.T @ (mass @ basis)
    dq, dv = (
        np.stack([part.slope(y, axis) for axis in range(y.shape[1])], axis=1)
        for part in (shape, velocity)
    )
    half = np.einsum("mik,kl,mjl->mij", dq, inner, dv, optimize=True)
    return np.linalg.solve(half - half.transpose(0, 2, 1), dq)
