"""The linear part of a recorded motion, from the data alone.

    z'' = -omega^2 z - 2 zeta omega z' + (terms of degree 2 and 3 of z, z'),    z = phi'q

by least squares, phi the first proper orthogonal direction of the training displacements. A sample
weighs the inverse of its amplitude, so that small motions count as much as large ones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vibrom.artefacts.files import DataError
from vibrom.latent.coordinates import principal
from vibrom.latent.polynomial import exponents, least_squares, monomials
from vibrom.models.training import Trajectory, Underdetermined

DEGREE = 3
SMALLEST = 0.05  # of the largest amplitude: below, samples weigh no more


@dataclass(frozen=True)
class Linear:
    """Small motions about rest, in one mode."""

    shape: np.ndarray  # (n,) phi, of unit length
    frequency: float  # omega, rad/s
    damping_ratio: float  # zeta


def linear_part(motions: list[Trajectory]) -> Linear:
    """Of decays of one slow mode."""
    q, v, a = (
        np.concatenate([getattr(item, name) for item in motions])
        for name in ("displacement", "velocity", "acceleration")
    )
    shape = principal([q], 1)[:, 0]
    z, speed, rate = q @ shape, v @ shape, a @ shape
    scale = np.array([np.abs(z).max(), np.abs(speed).max()])
    y = np.stack([z, speed], axis=1) / scale
    weight = 1.0 / np.maximum(np.linalg.norm(y, axis=1), SMALLEST)
    library = monomials(y, exponents(2, 1, DEGREE))
    try:
        row = least_squares(weight[:, None] * library, (weight * rate)[:, None])[0]
    except Underdetermined as error:
        raise DataError(
            "the recordings do not determine a linear motion; name the `channels` that vibrate, or "
            "give a decay over more amplitudes"
        ) from error
    stiffness, damping = -row[:2] / scale
    if stiffness <= 0.0:
        raise DataError(
            "the recorded motion does not oscillate about its rest; set preparation.rest, start "
            "or frequency"
        )
    frequency = float(np.sqrt(stiffness))
    return Linear(shape, frequency, float(damping / (2.0 * frequency)))
