"""Bounded extrapolation: beyond its training range a polynomial is extrapolated linearly along the
radius.

    rho_i = |(z_i / Z_i, z'_i / Z'_i)|,   c_i = (z_i, z'_i) / max(1, rho_i),   f(z) -> f(c) + Df(c)
    (z - c)

Z and Z' are the largest position and velocity of the training data. A decay fills the ellipse rho
<= 1 of each oscillator, not the box around it: in the corners of the box a polynomial extrapolates
already. Inside nothing changes; across the ellipse f and its gradient are continuous, and outside f
grows no faster than its first derivatives at the edge of the data, where a polynomial of degree p
grows like rho^p and runs away.
"""

import numpy as np

from vibrom.latent.polynomial import monomials, slopes


def library(
    z: np.ndarray, scale: np.ndarray, powers: np.ndarray, reach: np.ndarray | None
) -> np.ndarray:
    """(*batch, l): the monomials Phi(z / s), extrapolated linearly beyond `reach` where one is
    given.
    """
    return monomials(z / scale, powers) if reach is None else continued(z, scale, reach, powers)


def drawn_back(z: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """The c (*batch, 2d) of z (*batch, 2d): positions, then velocities; reach (2d,)."""
    d = len(reach) // 2
    square = ((z / reach) ** 2).reshape(*z.shape[:-1], 2, d).sum(axis=-2)
    # Not by a division of the radius by itself: inside, c is z to the last bit.
    shrink = np.where(square > 1.0, 1.0 / np.sqrt(np.maximum(square, 1.0)), 1.0)
    return z * np.concatenate([shrink, shrink], axis=-1)


def continued(
    z: np.ndarray, scale: np.ndarray, reach: np.ndarray, powers: np.ndarray
) -> np.ndarray:
    """(*batch, l): the monomials Phi(z / s), extrapolated linearly along the radius."""
    c = drawn_back(z, reach)
    return monomials(c / scale, powers) + slopes(c / scale, powers, (z - c) / scale)
