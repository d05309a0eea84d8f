"""Autoencoder and dynamics together, nothing known beforehand.

    min |q - v(z)|^2 + l1 |q'' - d2/dt2 v(z)|^2 + l2 |z'' - Xi Theta(z, z')|^2 + l3 |Xi|_1,
    z = w(q)

Theta holds all monomials 1..p and no constant; l1 = acceleration_full |q|^2/|q''|^2, and so l2 and
`acceleration_reduced`. Needs no operators. The weights are small: one coordinate follows the
accelerations far less closely than the displacements.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np

from vibrom.config.kinds import NonNegative, Positive
from vibrom.latent.autoencoder_method import AutoencoderMethod, Learnt, Problem
from vibrom.latent.coefficients import least_loss
from vibrom.latent.coordinates import Coordinates
from vibrom.latent.polynomial import exponents
from vibrom.models.training import Training

if TYPE_CHECKING:
    from vibrom.latent.learner import Dynamics


@dataclass(frozen=True)
class SindyAutoencoder(AutoencoderMethod):
    """See the module."""

    shift: Positive = 3.0
    acceleration_full: NonNegative = 0.01  # times |q|^2/|q''|^2: weight of the acceleration error
    acceleration_reduced: NonNegative = 0.1  # the same in reduced coordinates
    sparsity: NonNegative = 0.0  # weight of the sum of the coefficients' sizes
    first_coefficient: float = 0.0  # of every monomial, before training
    # learning rate of the coefficients over that of the weights: the linear ones have the longest
    # way to go
    coefficient_gain: Positive = 10.0
    # the coefficients minimise the loss of the trained networks exactly; false, or with sparsity:
    # they stay as the optimiser leaves them
    refit: bool = True
    # without it the folding response curve of some seeds has folds beyond the training range that
    # the full order's has not
    extrapolation: Literal["none", "linear"] = field(default="linear", kw_only=True)

    def dynamics(self, training: Training, chosen: Coordinates, stack: np.ndarray) -> Dynamics:
        """See AutoencoderMethod."""
        from vibrom.latent.learner import Dynamics

        balance = float(np.sum(stack[0] ** 2) / np.sum(stack[2] ** 2))
        return Dynamics(
            None,
            exponents(2 * self.latent, 1, self.order),
            self.first_coefficient,
            self.coefficient_gain,
            self.acceleration_full * balance,
            self.acceleration_reduced * balance,
            self.sparsity,
        )

    def coefficients(self, learnt: Learnt, problem: Problem, training: Training) -> np.ndarray:
        """See AutoencoderMethod."""
        if self.refit and not self.sparsity:
            dynamics = self.dynamics(training, problem.coordinates, problem.train)
            return least_loss(dynamics, learnt.encoder, learnt.decoder, problem.train)
        return learnt.xi
