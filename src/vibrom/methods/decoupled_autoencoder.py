"""Autoencoder first, dynamics afterwards.

    min |q - v(w(q))|^2,    then    d/dt (z, z') = R Phi(z, z')    by least squares

with all monomials 1..p of the encoded positions z = w(q) and velocities z' = w'(q) q'. Needs no
operators.
"""

from dataclasses import dataclass

import numpy as np

from vibrom.latent.autoencoder_method import AutoencoderMethod, fit_first_order
from vibrom.models.training import Training


@dataclass(frozen=True)
class DecoupledAutoencoder(AutoencoderMethod):
    epochs: int = 350
    amplitude_power: float = -0.25  # of a sample's weight in the least squares

    def coefficients(
        self,
        motion: tuple[np.ndarray, ...],
        learnt: np.ndarray | None,
        training: Training,
        rate: float,
    ) -> np.ndarray:
        return fit_first_order(motion, self.order, None, self.amplitude_power)
