"""Modal projection:  q = phi z,  z = phi' M q, and first-order polynomial dynamics by ordinary
least squares.

    d/dt (z, z') = R Phi(z, z'),    R = argmin sum_j |d/dt (z, z')_j - R Phi_j|^2

Source: thesis, section 2.2.1.
"""

from dataclasses import dataclass

import numpy as np

from vibrom.config.kinds import Count, Order
from vibrom.latent.polynomial import exponents, least_squares, monomials
from vibrom.latent.polynomial_rom import PolynomialRom
from vibrom.models.method import Method
from vibrom.models.training import Training


@dataclass(frozen=True)
class ModalProjection(Method):
    """See the module."""

    modes: Count = 1
    order: Order = 3  # of the polynomial dynamics

    def fit(self, training: Training) -> PolynomialRom:
        """See Method."""
        structure, monitor = training.require_structure("modal_projection"), training.monitor
        with monitor.phase("mapping"):
            phi = structure.leading(self.modes)
            encoder = (structure.mass @ phi.T).T
            n, d = phi.shape[1], self.modes
            position, velocity, acceleration = (
                training.joined(what) @ encoder.T
                for what in ("displacement", "velocity", "acceleration")
            )
            z = np.concatenate([position, velocity], axis=1)
            decoder = np.zeros((2 * n, 2 * d))
            decoder[:n, :d] = decoder[n:, d:] = phi.T
        with monitor.phase("dynamics"):
            reach, powers = np.abs(z).max(axis=0), exponents(2 * d, 1, self.order)
            rate = np.concatenate([velocity, acceleration], axis=1)
            dynamics = least_squares(monomials(z / reach, powers), rate)
        one = np.eye(2 * d, dtype=np.int64)
        return PolynomialRom(reach, encoder, reach, decoder * reach, one, dynamics, powers, phi)
