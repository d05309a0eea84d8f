"""SPLIT: autoencoder and dynamics together, with the linear part known.

    min |q - v(z)|^2 + l1 |q'' - d2/dt2 v(z)|^2 + l2 |z'' - f(z, z')|^2,    f = R0 (z, z') + Xi Theta(z, z'),    z = w(q)

R0 = (-phi' K phi, -phi' C phi) of the first d modes; Theta holds the monomials 2..p; l1 = acceleration_full |q|^2/|q''|^2, and so l2 and
`acceleration_reduced`. Both are small: one coordinate follows the accelerations far less closely than the displacements (folding beam, root mean
square: 6 % at best against 0.8 %), and larger weights pay for them with the motion.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vibrom.latent.autoencoder_method import AutoencoderMethod
from vibrom.latent.autoencoder_rom import AutoencoderRom
from vibrom.latent.coordinates import Coordinates, linear_dynamics
from vibrom.latent.polynomial import exponents
from vibrom.rom import Training

if TYPE_CHECKING:
    from vibrom.latent.training import Dynamics


@dataclass(frozen=True)
class Split(AutoencoderMethod):
    linear: str = "modes"
    acceleration_full: float = 0.03
    acceleration_reduced: float = 0.03
    first_coefficient: float = 0.0  # of every monomial, before training
    coefficient_gain: float = 1.0  # learning rate of the coefficients over that of the weights

    def fit(self, training: Training) -> AutoencoderRom:
        training.require_structure("split")
        return super().fit(training)

    def dynamics(self, training: Training, chosen: Coordinates, stack: np.ndarray) -> Dynamics:
        from vibrom.latent.training import Dynamics

        linear = linear_dynamics(training.structure, self.latent, chosen.rate)
        balance = float(np.sum(stack[0] ** 2) / np.sum(stack[2] ** 2))
        return Dynamics(linear, exponents(2 * self.latent, 2, self.order), self.first_coefficient, self.coefficient_gain,
                        self.acceleration_full * balance, self.acceleration_reduced * balance, 0.0)

    def coefficients(self, motion: tuple[np.ndarray, ...], learnt: np.ndarray | None, training: Training, rate: float) -> np.ndarray:
        return np.hstack([linear_dynamics(training.structure, self.latent, rate), learnt])
