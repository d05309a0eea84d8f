"""Autoencoder first, dynamics afterwards.

    min |q - v(w(q))|^2,    then    d/dt (z, z') = R Phi(z, z')    by least squares

with all monomials 1..p of the encoded positions z = w(q) and velocities z' = w'(q) q'. Needs no
operators.
"""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from vibrom.config.kinds import Count
from vibrom.latent.autoencoder_method import AutoencoderMethod, Learnt, Problem
from vibrom.latent.coefficients import fit_first_order
from vibrom.latent.coordinates import Coordinates
from vibrom.models.training import Training


@dataclass(frozen=True)
class DecoupledAutoencoder(AutoencoderMethod):
    """See the module."""

    # more reconstruct better still, but leave response curves too low beyond the training range
    epochs: Count = 450
    # a sample of the least squares weighs |(z, z')| to this power: -1 every amplitude alike, 0
    # every sample alike
    amplitude_power: float = -0.25
    # without it one point of the folding response curve diverges with some seeds
    extrapolation: Literal["none", "linear"] = field(default="linear", kw_only=True)

    def dynamics(self, training: Training, chosen: Coordinates, stack: np.ndarray) -> None:
        """See AutoencoderMethod: nothing."""

    def coefficients(self, learnt: Learnt, problem: Problem, training: Training) -> np.ndarray:
        """See AutoencoderMethod."""
        return fit_first_order(learnt.motion, self.order, None, self.amplitude_power)
