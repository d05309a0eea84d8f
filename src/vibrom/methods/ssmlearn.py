"""SSMLearn: a spectral submanifold as a graph over its modal coordinates, with known linear
dynamics.

    z = W0 x,    x = V0 z + v(z),    dz/dt = R0 z + r(z),
    W0 = diag(phi' M, phi' M),  V0 = diag(phi, phi)

v and r hold the monomials of degree 2 and up of (z, z'), by least squares; R0 is the modal
projection of the linear operators. Source: Cenedese, Axas, Bauerlein, Avila, Haller, Nature
Communications 13 (2022) 872; thesis, section 2.2.4.
"""

from dataclasses import dataclass

import numpy as np

from vibrom.config.kinds import Count, Order
from vibrom.latent.coordinates import linear_dynamics
from vibrom.latent.polynomial import exponents
from vibrom.latent.polynomial_rom import PolynomialRom, fit_remainder
from vibrom.models.method import Method
from vibrom.models.training import Training


@dataclass(frozen=True)
class SsmLearn(Method):
    """See the module."""

    modes: Count = 1
    order_decoder: Order = 3
    order_dynamics: Order = 3

    def fit(self, training: Training) -> PolynomialRom:
        """See Method."""
        structure, monitor = training.require_structure("ssmlearn"), training.monitor
        phi = structure.leading(self.modes)
        encoder, (d, n) = (structure.mass @ phi.T).T, phi.shape
        x = training.joined("state")
        z = np.concatenate([x[:, :n] @ encoder.T, x[:, n:] @ encoder.T], axis=1)
        reach = np.abs(z).max(axis=0)
        with monitor.phase("mapping"):
            linear = np.zeros((2 * n, 2 * d))
            linear[:n, :d] = linear[n:, d:] = phi.T
            decoder, decoder_powers = fit_remainder(
                z, reach, exponents(2 * d, 2, self.order_decoder), x, linear
            )
        with monitor.phase("dynamics"):
            rate = np.concatenate([z[:, d:], training.joined("acceleration") @ encoder.T], axis=1)
            known = np.vstack([np.eye(2 * d)[d:], linear_dynamics(structure, d)])
            dynamics, powers = fit_remainder(
                z, reach, exponents(2 * d, 2, self.order_dynamics), rate, known
            )
        return PolynomialRom(reach, encoder, reach, decoder, decoder_powers, dynamics, powers, phi)
