"""The reduced model of an autoencoder, in arrays only.

    c = B' q / s,   z = w(c),   z' = w'(c) c';      q = s B v(z),   q' = s B v'(z) z'
    second order:  z'' = f^2 Xi Phi(z, z'/f);       first order:  (z, z'/f)' = f Xi Phi(z, z'/f)
    a load adds a(z) u to z'', by one of the `force_rules`

z is dimensionless, z' in 1/s. With `decoder_beyond: tangent` the decoder is extrapolated along its
tangent where a position leaves the training range |z_i| <= Z_i:

    v(z) -> v(c) + v'(c) (z - c),   v'(z) -> v'(c),   c_i = min(max(z_i, -Z_i), Z_i)

Without data a network may bend anywhere. One position has v'(c) for its tangent exactly; with
several, its change along the edge is left out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.sparse import csr_matrix

from vibrom.latent.coordinates import Coordinates
from vibrom.latent.dissipative import fit_dissipative
from vibrom.latent.extrapolation import library
from vibrom.latent.force_rules import ForceRule, Push, projected, push
from vibrom.latent.networks import Activation, Network, layers
from vibrom.latent.polynomial import exponents
from vibrom.models.rollout import LIMIT
from vibrom.models.rom import Extrapolation, Guards, Rom, of_width, stored, stored_operator
from vibrom.models.training import Training, Unsupported

if TYPE_CHECKING:
    from vibrom.solvers.reduced.field import VectorField

DecoderBeyond = Literal["network", "tangent"]


@dataclass(frozen=True)
class AutoencoderRom(Rom):
    """An encoder of layers `sizes`, the decoder that mirrors it, and polynomial dynamics."""

    sizes: np.ndarray = stored("1", "units of each layer of the encoder, input to latent", "layer")
    weights: np.ndarray = stored(
        "1", "weights of the encoder, then of the decoder, layer by layer, rows first", "weight"
    )
    encoder_linear: np.ndarray = stored(  # (d, k)
        "1", "linear part beside the encoder", "latent", "reduced"
    )
    decoder_linear: np.ndarray = stored(  # (k, d)
        "1", "linear part beside the decoder", "reduced", "latent"
    )
    basis: np.ndarray | None = stored(  # B (n, k); None: the displacements themselves
        "1", "orthonormal directions of displacement", "dof", "reduced"
    )
    scale: float = stored("m", "displacement of one unit of the network")
    frequency: float = stored("s-1", "frequency that scales the time")
    coefficients: np.ndarray = stored(  # Xi (d, l), or (2d, l) of first order
        "1",
        "coefficients of the monomials in (z, z'/frequency), in scaled time",
        "equation",
        "monomial",
    )
    mass: csr_matrix | None = stored_operator("kg", "mass matrix")  # None: loads are Unsupported
    order: int  # of the monomials
    activation: Activation
    force_rule: ForceRule
    extrapolation: Extrapolation = "none"
    decoder_beyond: DecoderBeyond = "network"

    @cached_property
    def latent(self) -> int:
        """Number of positions d."""
        return int(self.sizes[-1])

    @cached_property
    def coordinates(self) -> Coordinates:
        """Units of the networks."""
        return Coordinates(self.basis, self.scale, self.frequency)

    @cached_property
    def encoder(self) -> Network:
        """Positions z = w(c)."""
        return Network(self._layers[0], self.encoder_linear, self.activation)

    @cached_property
    def decoder(self) -> Network:
        """Coordinates c = v(z), without extrapolation."""
        return Network(self._layers[1], self.decoder_linear, self.activation)

    @cached_property
    def _layers(self) -> tuple[list[np.ndarray], list[np.ndarray]]:
        return layers(self.sizes, self.weights)

    @cached_property
    def _edge(self) -> np.ndarray:
        """Training range Z (d,); infinite where the decoder is the network everywhere."""
        tangent = self.decoder_beyond == "tangent"
        return self.reach[: self.latent] if tangent else np.full(self.latent, np.inf)

    @cached_property
    def _size(self) -> int:
        """Number of free displacements n."""
        return len(self.decoder_linear) if self.basis is None else len(self.basis)

    def _decoded(self, position: np.ndarray, *along: np.ndarray) -> np.ndarray:
        """v(z) and v'(z) times each of `along` (channel, *batch, k), in network units; positions
        and directions are (*batch, d).
        """
        if self.decoder_beyond == "network":
            return self.decoder.along(np.stack([position, *along]))
        c = np.clip(position, -self._edge, self._edge)
        found = self.decoder.along(np.stack([c, *along, position - c]))
        found[0] += found[-1]
        return found[:-1]

    def encode(self, x: np.ndarray) -> np.ndarray:
        """See Rom."""
        q, v = np.split(of_width(x, 2 * self._size, "x"), 2, axis=-1)
        reduced = np.stack([self.coordinates.reduce(part) for part in (q, v)])
        return np.concatenate([*self.encoder.along(reduced)], axis=-1)

    def decode(self, z: np.ndarray) -> np.ndarray:
        """See Rom."""
        motion = self._decoded(*np.split(z, 2, axis=-1))
        return np.concatenate([self.coordinates.expand(part) for part in motion], axis=-1)

    def displacement(self, z: np.ndarray, dofs: np.ndarray | None = None) -> np.ndarray:
        """See Rom."""
        c = self._decoded(z[..., : self.latent])[0]
        if dofs is None:
            return self.coordinates.expand(c)
        return (c[..., dofs] if self.basis is None else c @ self.basis[dofs].T) * self.scale

    @cached_property
    def _polynomial(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray | None]:
        """Scale (2d,), exponents (l, 2d) and coefficients (2d, l) of dz/dt in physical time, and
        the range beyond which they are extrapolated linearly.
        """
        d, coefficients = self.latent, self.coefficients
        powers = exponents(2 * d, 1, self.order)
        if len(coefficients) == d:  # dz/dt = z' is a row of its own
            kinematic = (powers == np.eye(2 * d, dtype=int)[d:, None]).all(axis=2)
            coefficients = np.concatenate([kinematic, coefficients])
        scale = np.repeat([1.0, self.frequency], d)
        edge = None if self.extrapolation == "none" else self.reach
        return scale, powers, coefficients * (self.frequency * scale)[:, None], edge

    def drift(self, z: np.ndarray) -> np.ndarray:
        """See Rom."""
        scale, powers, coefficients, edge = self._polynomial
        return library(z, scale, powers, edge) @ coefficients.T

    def _push(self, p: np.ndarray) -> Push:
        if self.mass is None:
            raise Unsupported(
                "this model was fitted without a mass matrix, so a load cannot act on it; fit it "
                "in a scene with operators"
            )
        return push(self.force_rule, self.mass, self.coordinates, of_width(p, self._size, "p"))

    def force_map(self, z: np.ndarray, p: np.ndarray) -> np.ndarray:
        """See Rom."""
        given, position = self._push(p), z[..., : self.latent]
        axes = np.eye(self.latent)
        c, *tangents = self._decoded(
            position, *(np.broadcast_to(axis, position.shape) for axis in axes)
        )
        if self.force_rule == "encoder":
            a = self.encoder.along(np.stack([c, np.broadcast_to(given.load, c.shape)]))[1]
        else:
            v = np.stack(tangents)
            a = projected(v if given.weight is None else v @ given.weight.T, given.load)
        return np.concatenate([np.zeros_like(a), a], axis=-1)

    def field(self, p: np.ndarray | None) -> VectorField:
        """See Rom."""
        from vibrom.latent.decoder_kernel import force_kernel
        from vibrom.latent.polynomial_kernel import polynomial_kernel
        from vibrom.latent.table_kernel import tabulated
        from vibrom.solvers.reduced.field import VectorField

        drift = polynomial_kernel(*self._polynomial)
        if p is None:
            return VectorField(drift)
        encoder = self.encoder if self.force_rule == "encoder" else None
        force = force_kernel(self.decoder, encoder, self._push(p), self._edge)
        if self.latent == 1:
            # Beyond its edge a tangent is the same everywhere.
            constant = self.force_rule != "encoder" and np.isfinite(self._edge[0])
            force = tabulated(force, self.reach[0] * (1.0 if constant else LIMIT))
        return VectorField(drift, force, self._edge if np.isfinite(self._edge).all() else None)

    def encoded(self, training: Training) -> np.ndarray:
        """Positions z, dz/dtau and d2z/dtau2 (3, samples, d) of all training data."""
        return self.encoder.motion(self.coordinates.stack(training.trajectories))

    def guarded(self, guards: Guards, training: Training) -> AutoencoderRom:
        """See Rom."""
        if not guards.dissipative:
            return replace(self, extrapolation=guards.extrapolation)
        reach = self.reach / np.repeat([1.0, self.frequency], self.latent)
        row = fit_dissipative(self.encoded(training), reach, np.ones(2), guards.dissipative)
        return replace(
            self, coefficients=row[None], order=guards.dissipative, extrapolation="linear"
        )
