"""A manifold over an autoencoder's coordinates: shape, velocity, dynamics and force map as
polynomials in position and velocity, by least squares.

    q = N(z, z'),   v = N'(z, z'),   dz/dt = R(z, z') + S(z, z') p u

The coordinates z = w(q) are those of a fitted autoencoder, and nothing else of it is kept. They
tell the phases of a motion apart where linear ones may not; and unlike the autoencoder's own
decoder, the shape depends on the velocity too. See `latent.manifold_fit` for S. The linear part of
the dynamics of one position is that of the first mode, whatever the coordinate.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vibrom.config.kinds import Count
from vibrom.latent.autoencoder_rom import AutoencoderRom
from vibrom.latent.coordinates import linear_dynamics
from vibrom.latent.manifold_fit import Polynomials, fitted, symplectic_push, weights
from vibrom.latent.manifold_rom import ManifoldRom
from vibrom.latent.polynomial import exponents
from vibrom.models.method import Method
from vibrom.models.training import MethodError, Structure, Training


@dataclass(frozen=True)
class AutoencoderManifold(Method):
    """See the module."""

    order_decoder: Count = 11
    order_dynamics: Count = 11
    order_force: Count = 9
    # a sample of the least squares weighs |(z, z')| to this power: -1 every amplitude alike, as
    # errors grow with it; 0 every sample alike
    amplitude_power: float = -1.0

    def fit(self, training: Training) -> ManifoldRom:
        """See Method."""
        start, structure = training.start, training.require_structure("autoencoder_manifold")
        if not isinstance(start, AutoencoderRom):
            raise MethodError(
                "autoencoder_manifold starts from a fitted autoencoder, and was given "
                f"{type(start).__name__}; set starts_from: decoupled_autoencoder"
            )
        rate = np.repeat([1.0, start.frequency], start.latent)
        z, first, second = start.encoded(training)
        y = np.hstack([z, first]) * rate / start.reach
        dy = np.hstack([first, second]) * rate * start.frequency / start.reach
        weight = weights(y, self.amplitude_power)
        basis = np.eye(structure.mass.shape[0]) if start.basis is None else start.basis
        with training.monitor.phase("mapping"):
            shape, velocity = (
                fitted(y, weight, training.joined(what) @ basis, self.order_decoder)
                for what in ("displacement", "velocity")
            )
        with training.monitor.phase("dynamics"):
            known = linear_part(structure, start.reach)
            drift = fitted(y, weight, dy, self.order_dynamics, linear=known)
            push = symplectic_push(shape, velocity, structure.mass, basis, y)
            pushed = fitted(y, weight, push.reshape(len(y), -1), self.order_force, constant=True)
            rom = assembled(start.reach, basis, shape, velocity, drift, pushed)
            return replace(rom, reach=np.abs(training.joined("state").map(rom.encode)).max(axis=0))


def linear_part(structure: Structure, scale: np.ndarray) -> np.ndarray | None:
    """(2, 2) of dy/dt, y = z / scale, for one position; unknown for several, as their coordinates
    mix the modes.
    """
    if len(scale) > 2:
        return None
    rates = np.vstack([[0.0, 1.0], linear_dynamics(structure, 1)])
    return rates * scale / scale[:, None]


def assembled(
    scale: np.ndarray,
    basis: np.ndarray,
    shape: Polynomials,
    velocity: Polynomials,
    drift: Polynomials,
    push: Polynomials,
) -> ManifoldRom:
    """The model, in one list of monomials."""
    order = max(int(part.powers.sum(axis=1).max()) for part in (shape, drift, push))
    powers = exponents(len(scale), 0, order)
    one = np.eye(1, len(powers))[0]

    def whole(part: Polynomials) -> np.ndarray:
        return np.pad(part.coefficients, ((0, 0), (0, len(powers) - len(part.powers))))

    return ManifoldRom(
        reach=scale,
        scale=scale,
        powers=powers,
        basis=basis,
        displacement_terms=whole(shape),
        velocity_terms=whole(velocity),
        below=one,
        dynamics=whole(drift) * scale[:, None],
        below_dynamics=one,
        push=whole(push).reshape(len(scale), -1, len(powers)) * scale[:, None, None],
        below_push=one,
        load=None,
        beside_terms=None,
        below_beside=None,
        radius=float("inf"),  # of convergence: these are no series
        trust_displacement=None,
        trust_error=None,
    )
