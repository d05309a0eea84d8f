"""SPLIT: autoencoder and dynamics together, with the linear part known.

    min |q - v(z)|^2 + l1 |G (q'' - d2/dt2 v(z))|^2 + l2 |z'' - f(z, z')|^2,
    f = R0 (z, z') + Xi Theta(z, z'),    z = w(q)

R0 = (-phi' K phi, -phi' C phi) of the first d modes; Theta holds the monomials 2..p; l2 =
acceleration_reduced |q|^2/|q''|^2. `acceleration_norm` says in what G measures accelerations:
`static` by the displacement that their inertia makes, G = K^-1 M and l1 = acceleration_full;
`plain` as they are, G = 1 and l1 = acceleration_full |q|^2/|q''|^2. Of a mode of frequency w the
static norm sees 1/w^2: the vibration of higher modes, which one coordinate cannot follow, dominates
accelerations but contributes negligibly to the displacement.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from vibrom.config.kinds import NonNegative, Positive
from vibrom.latent.autoencoder_method import AutoencoderMethod, Learnt, Problem
from vibrom.latent.coordinates import Coordinates, linear_dynamics, static_norm
from vibrom.latent.polynomial import exponents
from vibrom.models.training import Training

if TYPE_CHECKING:
    from vibrom.latent.learner import Dynamics


@dataclass(frozen=True)
class Split(AutoencoderMethod):
    """See the module."""

    linear: Literal["none", "pod", "modes"] = "modes"
    shift: Positive = 0.1
    # the network itself flattens out where there are no data
    decoder_beyond: Literal["network", "tangent"] = "tangent"
    acceleration_norm: Literal["static", "plain"] = "static"
    # weight of the acceleration error; plain: times |q|^2/|q''|^2
    acceleration_full: NonNegative = 0.1
    acceleration_reduced: NonNegative = 0.3  # the same in reduced coordinates, times |q|^2/|q''|^2
    first_coefficient: float = 0.0  # of every monomial, before training
    coefficient_gain: Positive = 1.0  # learning rate of the coefficients over that of the weights

    def dynamics(self, training: Training, chosen: Coordinates, stack: np.ndarray) -> Dynamics:
        """See AutoencoderMethod."""
        from vibrom.latent.learner import Dynamics

        structure, static = training.require_structure("split"), self.acceleration_norm == "static"
        balance = float(np.sum(stack[0] ** 2) / np.sum(stack[2] ** 2))
        return Dynamics(
            linear_dynamics(structure, self.latent, chosen.frequency),
            exponents(2 * self.latent, 2, self.order),
            self.first_coefficient,
            self.coefficient_gain,
            self.acceleration_full * (1.0 if static else balance),
            self.acceleration_reduced * balance,
            norm=static_norm(structure, chosen) if static else None,
        )

    def coefficients(self, learnt: Learnt, problem: Problem, training: Training) -> np.ndarray:
        """See AutoencoderMethod."""
        structure, frequency = training.require_structure("split"), problem.coordinates.frequency
        return np.hstack([linear_dynamics(structure, self.latent, frequency), learnt.xi])
