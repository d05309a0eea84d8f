"""SPLIT: autoencoder and dynamics together, with the linear part known.

    min |q - v(z)|^2 + l1 |G (q'' - d2/dt2 v(z))|^2 + l2 |z'' - f(z, z')|^2,    f = R0 (z, z') + Xi
    Theta(z, z'),    z = w(q)

R0 = (-phi' K phi, -phi' C phi) of the first d modes; Theta holds the monomials 2..p; l2 =
acceleration_reduced |q|^2/|q''|^2. `acceleration_norm` says in what G measures accelerations:
`static` by the displacement that their inertia makes, G = K^-1 M and l1 = acceleration_full;
`plain` as they are, G = 1 and l1 = acceleration_full |q|^2/|q''|^2. Of a mode of frequency w the
static norm sees 1/w^2: the vibration of higher modes, which one coordinate cannot follow, dominates
accelerations and is next to nothing as a displacement.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vibrom.latent.autoencoder_method import AutoencoderMethod
from vibrom.latent.autoencoder_rom import AutoencoderRom
from vibrom.latent.coordinates import Coordinates, linear_dynamics, static_norm
from vibrom.latent.polynomial import exponents
from vibrom.models.training import MethodError, Training

if TYPE_CHECKING:
    from vibrom.latent.training import Dynamics


@dataclass(frozen=True)
class Split(AutoencoderMethod):
    linear: str = "modes"
    decoder_beyond: str = "tangent"
    acceleration_norm: str = "static"
    acceleration_full: float = 0.1
    acceleration_reduced: float = 0.3
    first_coefficient: float = 0.0  # of every monomial, before training
    coefficient_gain: float = 1.0  # learning rate of the coefficients over that of the weights

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.acceleration_norm not in ("static", "plain"):
            raise MethodError(
                f"acceleration_norm is {self.acceleration_norm!r}; give static or plain"
            )

    def fit(self, training: Training) -> AutoencoderRom:
        training.require_structure("split")
        return super().fit(training)

    def dynamics(self, training: Training, chosen: Coordinates, stack: np.ndarray) -> Dynamics:
        from vibrom.latent.training import Dynamics

        linear = linear_dynamics(training.structure, self.latent, chosen.rate)
        balance = float(np.sum(stack[0] ** 2) / np.sum(stack[2] ** 2))
        norm = (
            static_norm(training.structure, chosen) if self.acceleration_norm == "static" else None
        )
        return Dynamics(
            linear,
            exponents(2 * self.latent, 2, self.order),
            self.first_coefficient,
            self.coefficient_gain,
            self.acceleration_full * (1.0 if norm is not None else balance),
            self.acceleration_reduced * balance,
            0.0,
            norm,
        )

    def coefficients(
        self,
        motion: tuple[np.ndarray, ...],
        learnt: np.ndarray | None,
        training: Training,
        rate: float,
    ) -> np.ndarray:
        return np.hstack([linear_dynamics(training.structure, self.latent, rate), learnt])
