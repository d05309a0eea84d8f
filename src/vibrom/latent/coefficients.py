"""Coefficients of polynomial dynamics by least squares, from the encoded motion z, dz/dtau,
d2z/dtau2.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vibrom.latent.networks import Network
from vibrom.latent.polynomial import exponents, least_squares, monomials

if TYPE_CHECKING:
    from vibrom.latent.learner import Dynamics


def fit_first_order(
    motion: np.ndarray, order: int, linear: np.ndarray | None, amplitude_power: float
) -> np.ndarray:
    """R (2d, l) of d/dtau (z, z') = R Phi(z, z'), from z, z', z'' (3, m, d); `linear` R0 (d, 2d)
    keeps the second row's linear part fixed.

    A sample weighs |(z, z')|^amplitude_power. What one coordinate leaves of the motion, the
    vibration of other modes, decays with it: errors are in proportion to the amplitude, and the
    power -1 makes them alike (generalised least squares; Aitken, Proc. R. Soc. Edinb. 55 (1936)
    42).
    """
    z, first, second = motion
    y, d = np.hstack([z, first]), z.shape[1]
    target = np.hstack([first, second])
    size = np.linalg.norm(y, axis=1)
    # A sample at rest says nothing, and must not weigh infinitely.
    weight = (np.maximum(size / size.max(), 1e-6) ** amplitude_power)[:, None]
    if linear is None:
        return least_squares(weight * monomials(y, exponents(2 * d, 1, order)), weight * target)
    fixed = np.vstack([np.eye(2 * d)[d:], linear])
    rest = weight * monomials(y, exponents(2 * d, 2, order))
    return np.hstack([fixed, least_squares(rest, weight * (target - y @ fixed.T))])


def least_loss(dynamics: Dynamics, encoder: Network, decoder: Network, c: np.ndarray) -> np.ndarray:
    """The Xi (d, l) with the smallest loss for these networks, on samples c (3, m, k).

        min  l1 |G (c'' - v''[z', z'] - V f)|^2 + l2 |z'' - f|^2,    f = R0 y + Xi Theta(y)

    which is quadratic in f, sample by sample: f' S f - 2 f' b with S = l1 V'G'G V + l2 1 = L L'.
    So |L' f - L^-1 b|^2 is least. An optimiser that moves Xi and the networks together stops some
    way off. For a loss without the term |Xi|_1.
    """
    z, first, second = encoder.motion(c)
    axes = (np.broadcast_to(axis, z.shape) for axis in np.eye(z.shape[1]))
    tangents = np.moveaxis(decoder.along(np.stack([z, *axes]))[1:], 0, -1)  # V (m, k, d)
    bend = decoder.motion(np.stack([z, first, np.zeros_like(z)]))[2]
    y, d = np.hstack([z, first]), z.shape[1]
    known = np.zeros_like(z) if dynamics.linear is None else y @ dynamics.linear.T
    residual = c[2] - bend - np.einsum("mki,mi->mk", tangents, known)
    if dynamics.norm is not None:
        tangents = np.einsum("hk,mki->mhi", dynamics.norm, tangents)
        residual = residual @ dynamics.norm.T
    square = np.einsum("mki,mkj->mij", tangents, tangents)
    root = np.linalg.cholesky(dynamics.full * square + dynamics.reduced * np.eye(d))  # L (m, d, d)
    pull = np.einsum("mki,mk->mi", tangents, residual)
    b = dynamics.full * pull + dynamics.reduced * (second - known)
    theta = monomials(y, dynamics.powers)
    library = np.einsum("mia,ml->mail", root, theta).reshape(len(z) * d, -1)
    target = np.linalg.solve(root, b[..., None]).reshape(-1, 1)
    return least_squares(library, target).reshape(d, -1)
