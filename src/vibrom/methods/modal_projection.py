"""Modal projection:  q = phi z,  z = phi' M q, and first-order polynomial dynamics by ordinary
least squares.

    d/dt (z, z') = R Phi(z, z'),    R = argmin sum_j |d/dt (z, z')_j - R Phi_j|^2

Source: thesis, section 2.2.1.
"""

from dataclasses import dataclass

import numpy as np

from vibrom.latent.polynomial import exponents, least_squares, monomials
from vibrom.latent.polynomial_rom import PolynomialRom
from vibrom.models.method import Method
from vibrom.models.training import Training


@dataclass(frozen=True)
class ModalProjection(Method):
    modes: int = 1
    order: int = 3

    def fit(self, training: Training) -> PolynomialRom:
        structure, monitor = training.require_structure("modal_projection"), training.monitor
        with monitor.phase("mapping"):
            phi = structure.leading(self.modes)
            encoder = (structure.mass @ phi.T).T
            n, d = phi.shape[1], self.modes
            z = np.concatenate(
                [
                    training.joined("displacement") @ encoder.T,
                    training.joined("velocity") @ encoder.T,
                ],
                axis=1,
            )
            rate = np.concatenate([z[:, d:], training.joined("acceleration") @ encoder.T], axis=1)
            decoder = np.zeros((2 * n, 2 * d))
            decoder[:n, :d] = decoder[n:, d:] = phi.T
        with monitor.phase("dynamics"):
            reach = np.abs(z).max(axis=0)
            powers = exponents(2 * d, 1, self.order)
            dynamics = least_squares(monomials(z / reach, powers), rate)
        return PolynomialRom(
            reach,
            encoder,
            reach,
            decoder * reach,
            np.eye(2 * d, dtype=np.int64),
            dynamics,
            powers,
            phi,
        )
