"""Linear encoder, polynomial decoder, polynomial dynamics.

    z = (W q, W v),    x = D Psi(z / s),    dz/dt = R Phi(z / s) + (0, F p) u

s scales the monomials to order one, which keeps high orders well conditioned. F = phi' for modal
coordinates. Guards extrapolate Psi as well as Phi linearly beyond `reach`: a motion that stays
finite far out would otherwise be decoded by a polynomial of high degree there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from vibrom.latent.dissipative import fit_dissipative
from vibrom.latent.extrapolation import library
from vibrom.latent.polynomial import exponents, least_squares, monomials
from vibrom.models.rom import Extrapolation, Guards, Rom, of_width, stored
from vibrom.models.samples import Samples
from vibrom.models.training import Training, Unsupported

if TYPE_CHECKING:
    from vibrom.solvers.reduced.field import VectorField


@dataclass(frozen=True)
class PolynomialRom(Rom):
    """W, s, the coefficients D and R with the exponents of their monomials, and F."""

    encoder: np.ndarray = stored(  # W (d, n)
        "kg^(1/2)", "projection of displacement and of velocity", "mode", "dof"
    )
    scale: np.ndarray = stored(  # s (2d,), in the unit of each coordinate
        "1", "scale of the reduced coordinates in the monomials, in their own units", "coordinate"
    )
    decoder: np.ndarray = stored(  # D (2n, k)
        "1", "coefficients of the decoder, in the unit of the state", "state", "decoder_term"
    )
    decoder_powers: np.ndarray = stored(  # (k, 2d)
        "1", "exponents of the decoder's monomials", "decoder_term", "coordinate"
    )
    dynamics: np.ndarray = stored(  # R (2d, l)
        "1", "coefficients of the dynamics, in the unit of the rate", "coordinate", "dynamics_term"
    )
    dynamics_powers: np.ndarray = stored(  # (l, 2d)
        "1", "exponents of the dynamics' monomials", "dynamics_term", "coordinate"
    )
    force: np.ndarray | None = stored(  # F (d, n); None: loads are Unsupported
        "kg^(-1/2)", "projection of the load", "mode", "dof"
    )
    extrapolation: Extrapolation = "none"

    @property
    def _edge(self) -> np.ndarray | None:
        return None if self.extrapolation == "none" else self.reach

    def encode(self, x: np.ndarray) -> np.ndarray:
        """See Rom."""
        n = self.encoder.shape[1]
        x = of_width(x, 2 * n, "x")
        return np.concatenate([x[..., :n] @ self.encoder.T, x[..., n:] @ self.encoder.T], axis=-1)

    def _decoded(self, z: np.ndarray, rows: np.ndarray) -> np.ndarray:
        return library(z, self.scale, self.decoder_powers, self._edge) @ rows.T

    def decode(self, z: np.ndarray) -> np.ndarray:
        """See Rom."""
        return self._decoded(z, self.decoder)

    def displacement(self, z: np.ndarray, dofs: np.ndarray | None = None) -> np.ndarray:
        """See Rom."""
        half = self.decoder[: len(self.decoder) // 2]
        return self._decoded(z, half if dofs is None else half[dofs])

    def drift(self, z: np.ndarray) -> np.ndarray:
        """See Rom."""
        return library(z, self.scale, self.dynamics_powers, self._edge) @ self.dynamics.T

    def _push(self, p: np.ndarray) -> np.ndarray:
        if self.force is None:
            raise Unsupported(
                "this model was fitted without operators and knows no force map; fit it in a scene "
                "with mass and modes"
            )
        modal = self.force @ of_width(p, self.force.shape[1], "p")
        return np.concatenate([np.zeros_like(modal), modal])

    def force_map(self, z: np.ndarray, p: np.ndarray) -> np.ndarray:
        """See Rom."""
        return np.broadcast_to(self._push(p), z.shape)

    def field(self, p: np.ndarray | None) -> VectorField:
        """See Rom."""
        from vibrom.latent.polynomial_kernel import constant_kernel, polynomial_kernel
        from vibrom.solvers.reduced.field import VectorField

        drift = polynomial_kernel(self.scale, self.dynamics_powers, self.dynamics, self._edge)
        return VectorField(drift, None if p is None else constant_kernel(self._push(p)))

    def guarded(self, guards: Guards, training: Training) -> PolynomialRom:
        """See Rom."""
        if not guards.dissipative:
            return replace(self, extrapolation=guards.extrapolation)
        motion = np.stack(
            [
                training.joined(what) @ self.encoder.T
                for what in ("displacement", "velocity", "acceleration")
            ]
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
    z: np.ndarray,
    scale: np.ndarray,
    powers: np.ndarray,
    target: np.ndarray | Samples,
    linear: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """(coefficients, exponents) of  target = linear z + sum_k R_k Phi_k(z / s), the linear part (m,
    r) kept, R by least squares.
    """
    known = np.eye(len(scale), dtype=np.int64)
    library = monomials(z / scale, powers)
    columns = target.columns() if isinstance(target, Samples) else [(slice(None), target)]
    remainder = np.concatenate(
        [least_squares(library, block - z @ linear[some].T) for some, block in columns]
    )
    return np.concatenate([linear * scale, remainder], axis=1), np.concatenate([known, powers])
