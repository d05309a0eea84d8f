"""Linear encoder, polynomial decoder, polynomial dynamics.

    z = (W q, W v),    x = D Psi(z / s),    dz/dt = R Phi(z / s) + (0, F p) u

W (d, n) projects displacement and velocity, D (2n, k) and R (2d, l) are the coefficients of the
monomials Psi and Phi, and F (d, n) maps the load: phi' for modal coordinates. s scales the
monomials to order one, which keeps high orders well conditioned.

Guards continue Psi as well as Phi beyond `reach` (`extrapolation`): a motion that holds far out
would otherwise be decoded by a polynomial of high degree there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from vibrom.latent.dissipative import fit_dissipative
from vibrom.latent.extrapolation import continued
from vibrom.latent.polynomial import exponents, least_squares, monomials
from vibrom.models.rom import Guards, Rom, array_field
from vibrom.models.training import MethodError, Training

if TYPE_CHECKING:
    from vibrom.solvers.reduced.field import Field


@dataclass(frozen=True)
class PolynomialRom(Rom):
    encoder: np.ndarray = array_field(
        "kg0.5", "projection of displacement and of velocity", ("mode", "dof")
    )
    scale: np.ndarray = array_field(
        "1",
        "scale of the reduced coordinates in the monomials, in their own units",
        ("coordinate",),
    )
    decoder: np.ndarray = array_field(
        "1", "coefficients of the decoder, in the unit of the state", ("state", "decoder_term")
    )
    decoder_powers: np.ndarray = array_field(
        "1", "exponents of the decoder's monomials", ("decoder_term", "coordinate")
    )
    dynamics: np.ndarray = array_field(
        "1",
        "coefficients of the dynamics, in the unit of the rate",
        ("coordinate", "dynamics_term"),
    )
    dynamics_powers: np.ndarray = array_field(
        "1", "exponents of the dynamics' monomials", ("dynamics_term", "coordinate")
    )
    force: np.ndarray | None = array_field("kg-0.5", "projection of the load", ("mode", "dof"))
    extrapolation: str = "none"

    def encode(self, x: np.ndarray) -> np.ndarray:
        n = self.encoder.shape[1]
        return np.concatenate([x[..., :n] @ self.encoder.T, x[..., n:] @ self.encoder.T], axis=-1)

    def _monomials(self, z: np.ndarray, powers: np.ndarray) -> np.ndarray:
        return (
            monomials(z / self.scale, powers)
            if self.extrapolation == "none"
            else continued(z, self.scale, self.reach, powers)
        )

    def decode(self, z: np.ndarray) -> np.ndarray:
        return self._monomials(z, self.decoder_powers) @ self.decoder.T

    def displacement(self, z: np.ndarray, dofs: np.ndarray | None = None) -> np.ndarray:
        half = self.decoder[: len(self.decoder) // 2]
        return self._monomials(z, self.decoder_powers) @ (half if dofs is None else half[dofs]).T

    def drift(self, z: np.ndarray) -> np.ndarray:
        return self._monomials(z, self.dynamics_powers) @ self.dynamics.T

    def _push(self, p: np.ndarray) -> np.ndarray:
        if self.force is None:
            raise MethodError(
                "this model was fitted without operators and knows no force map; fit it on a scene with mass and modes"
            )
        modal = self.force @ p
        return np.concatenate([np.zeros_like(modal), modal])

    def force_map(self, z: np.ndarray, p: np.ndarray) -> np.ndarray:
        return np.broadcast_to(self._push(p), z.shape)

    def field(self, p: np.ndarray | None) -> Field:
        from vibrom.latent.polynomial_kernel import constant_kernel, polynomial_kernel
        from vibrom.solvers.reduced.field import Field

        drift = polynomial_kernel(
            self.scale,
            self.dynamics_powers,
            self.dynamics,
            None if self.extrapolation == "none" else self.reach,
        )
        return Field(drift, None if p is None else constant_kernel(self._push(p)))

    def guarded(self, guards: Guards, training: Training) -> PolynomialRom:
        if not guards.dissipative:
            return replace(self, extrapolation=guards.extrapolation)
        motion = tuple(
            training.joined(what) @ self.encoder.T
            for what in ("displacement", "velocity", "acceleration")
        )
        row = fit_dissipative(motion, self.reach, self.scale, guards.dissipative)
        powers = exponents(2, 1, guards.dissipative)
        kinematic = np.where((powers == [0, 1]).all(axis=1), self.scale[1], 0.0)
        return replace(
            self,
            dynamics=np.stack([kinematic, row]),
            dynamics_powers=powers,
            extrapolation="linear",
        )


def fit_remainder(
    z: np.ndarray, scale: np.ndarray, powers: np.ndarray, target: np.ndarray, linear: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(coefficients, exponents) of  target = linear z + sum_k R_k Phi_k(z / s), the linear part (m,
    r) kept, R by least squares.
    """
    known = np.eye(len(scale), dtype=np.int64)
    remainder = least_squares(monomials(z / scale, powers), target - z @ linear.T)
    return np.concatenate([linear * scale, remainder], axis=1), np.concatenate([known, powers])
