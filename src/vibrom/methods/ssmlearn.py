"""SSMLearn: a spectral submanifold as a graph over its modal coordinates.

    z = W0 x,    x = V0 z + v(z),    dz/dt = R0 z + r(z),
    W0 = diag(w', w'),  V0 = diag(phi, phi)

v and r hold the monomials of degree 2 and up of (z, z'), by least squares. Where the tangent space
is known, phi are modes, w = M phi, and R0 is the modal projection of the linear operators. Where it
is not, w are the first proper orthogonal directions of the displacements, and V0 and R0 are fitted
with the rest. Source: Cenedese, Axas, Bauerlein, Avila, Haller, Nature Communications 13 (2022)
872; thesis, section 2.2.4.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.sparse.linalg import splu

from vibrom.config.kinds import Count, Order
from vibrom.latent.coordinates import linear_dynamics, principal
from vibrom.latent.polynomial import exponents, least_squares, monomials
from vibrom.latent.polynomial_rom import PolynomialRom, fit_remainder
from vibrom.models.method import Method
from vibrom.models.training import Structure, Training


@dataclass(frozen=True)
class SsmLearn(Method):
    """See the module."""

    modes: Count = 1
    order_decoder: Order = 3
    order_dynamics: Order = 3
    # tangent space and linear part at rest: of the modes, or of the data; known: of the modes where
    # there are some
    tangent: Literal["known", "modes", "data"] = "known"

    def fit(self, training: Training) -> PolynomialRom:
        """See Method."""
        of_data = training.structure is None if self.tangent == "known" else self.tangent == "data"
        if of_data:
            return self._of_data(training)
        return self._of_modes(training, training.require_structure("ssmlearn"))

    def _of_modes(self, training: Training, structure: Structure) -> PolynomialRom:
        monitor, phi = training.monitor, structure.leading(self.modes)
        encoder, (d, n) = (structure.mass @ phi.T).T, phi.shape
        x = training.joined("state")
        z = x.map(
            lambda rows: np.concatenate([rows[:, :n] @ encoder.T, rows[:, n:] @ encoder.T], axis=1)
        )
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

    def _of_data(self, training: Training) -> PolynomialRom:
        monitor, q = training.monitor, training.joined("displacement")
        with monitor.phase("mapping"):
            encoder = principal(q.blocks(), self.modes).T
            motion = [
                training.joined(what) @ encoder.T
                for what in ("displacement", "velocity", "acceleration")
            ]
            z, rate = (np.concatenate(pair, axis=1) for pair in (motion[:2], motion[1:]))
            reach, d = np.abs(z).max(axis=0), len(encoder)
            decoder_powers, powers = (
                exponents(2 * d, 1, order) for order in (self.order_decoder, self.order_dynamics)
            )
            decoder = least_squares(monomials(z / reach, decoder_powers), training.joined("state"))
        with monitor.phase("dynamics"):
            dynamics = least_squares(monomials(z / reach, powers), rate)
            dynamics[:d] = np.eye(len(powers))[d : 2 * d] * reach[d:, None]
        # A load p is the acceleration M^-1 p; without a mass p is one already.
        force = encoder
        if training.structure is not None:
            force = splu(training.structure.mass.tocsc()).solve(encoder.T).T
        return PolynomialRom(
            reach, encoder, reach, decoder, decoder_powers, dynamics, powers, force
        )
