"""The reduced model of an autoencoder, in arrays only.

    c = B' q / s,   z = w(c),   z' = w'(c) c';      q = s B v(z),   q' = s B v'(z) z'
    second order:  z'' = f^2 Xi Phi(z, z'/f);       first order:  (z, z'/f)' = f Xi Phi(z, z'/f)
    z'' + alpha(z) M^-1 p u,   alpha = (V'V)^-1 V',   V = s B v'(z)
    (thesis, equation 2.16)

z is dimensionless, z' in 1/s. The force enters by `force_rule`: `decoder` as above; `decoder_mass`
with (V'MV)^-1 V' p, the virtual work of the load; `encoder` with w'(q) M^-1 p at q = v(z).

With `decoder_beyond: tangent` the decoder goes on along its tangent where a position leaves the
training range |z_i| <= Z_i:

    v(z) -> v(c) + v'(c) (z - c),   v'(z) -> v'(c),   c_i = min(max(z_i, -Z_i), Z_i)

Without data a network may bend anywhere. One position has v'(c) for its tangent exactly; with
several, its change along the edge is left out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from vibrom.latent.dissipative import fit_dissipative
from vibrom.latent.extrapolation import continued
from vibrom.latent.polynomial import exponents, monomials
from vibrom.models.rom import Guards, Rom, array_field
from vibrom.models.training import MethodError, Training

if TYPE_CHECKING:
    from vibrom.solvers.reduced.field import Field

RULES = ("decoder", "decoder_mass", "encoder")
BEYOND = ("network", "tangent")


def activate(name: str, a: np.ndarray, order: int) -> tuple[np.ndarray, ...]:
    """s, s' and s'' of a, up to this derivative."""
    if name == "tanh":
        t = np.tanh(a)
        first = 1.0 - t * t
        return (t, first, -2.0 * t * first)[: order + 1]
    if name == "elu":
        bent = np.exp(np.minimum(a, 0.0))
        return (np.where(a > 0.0, a, bent - 1.0), bent, np.where(a > 0.0, 0.0, bent))[: order + 1]
    s = 0.5 + 0.5 * np.tanh(0.5 * a)  # the logistic function, without overflow
    if name == "softplus":
        return (np.logaddexp(0.0, a) - np.log(2.0), s, s * (1.0 - s))[: order + 1]
    r = s * (1.0 - s)
    return (a * s, s + a * r, r * (2.0 + a * (1.0 - 2.0 * s)) if order > 1 else r)[: order + 1]


def network(
    weights: list[np.ndarray], linear: np.ndarray, name: str, y: np.ndarray, curved: bool = False
) -> np.ndarray:
    """N(y) + L y of a stack (channel, *batch, n): a value and first derivatives along it; `curved`:
    value, first and second derivative.
    """
    straight = y @ linear.T
    for weight in weights[:-1]:
        a = y @ weight.T
        slopes = activate(name, a[0], 2 if curved else 1)
        y = np.empty_like(a)
        y[0] = slopes[0]
        np.multiply(slopes[1], a[1:], out=y[1:])
        if curved:
            y[2] += slopes[2] * a[1] ** 2
    return y @ weights[-1].T + straight


def slope_at_rest(weights: list[np.ndarray], name: str) -> np.ndarray:
    """N'(0)."""
    product, slope = weights[0], float(activate(name, np.zeros(()), 1)[1])
    for weight in weights[1:]:
        product = slope * (weight @ product)
    return product


@dataclass(frozen=True)
class AutoencoderRom(Rom):
    """z = w(c), z' with d coordinates each; `basis` None stands for the identity, the mass is
    absent for data without operators.
    """

    sizes: np.ndarray = array_field(
        "1", "units of each layer of the encoder, input to latent", ("layer",)
    )
    weights: np.ndarray = array_field(
        "1", "weights of the encoder, then of the decoder, layer by layer, rows first", ("weight",)
    )
    encoder_linear: np.ndarray = array_field(
        "1", "linear part beside the encoder", ("latent", "reduced")
    )
    decoder_linear: np.ndarray = array_field(
        "1", "linear part beside the decoder", ("reduced", "latent")
    )
    basis: np.ndarray | None = array_field(
        "1", "orthonormal directions of displacement", ("dof", "reduced")
    )
    scale: np.ndarray = array_field("m", "displacement of one unit of the network", ())
    rate: np.ndarray = array_field("s-1", "rate of the scaled time", ())
    coefficients: np.ndarray = array_field(
        "1",
        "coefficients of the monomials in (z, z'/rate), in scaled time",
        ("equation", "monomial"),
    )
    order: int
    activation: str
    force_rule: str
    mass_row: np.ndarray | None = array_field(
        "1", "row of each entry of the mass matrix", ("entry",)
    )
    mass_column: np.ndarray | None = array_field(
        "1", "column of each entry of the mass matrix", ("entry",)
    )
    mass_value: np.ndarray | None = array_field("kg", "entries of the mass matrix", ("entry",))
    extrapolation: str = "none"
    decoder_beyond: str = "network"

    @cached_property
    def latent(self) -> int:
        return int(self.sizes[-1])

    @cached_property
    def _layers(self) -> tuple[list[np.ndarray], list[np.ndarray]]:
        sizes = [int(size) for size in self.sizes]
        shapes = list(zip(sizes[1:], sizes[:-1]))
        shapes += [(columns, rows) for rows, columns in reversed(shapes)]
        ends = np.cumsum([rows * columns for rows, columns in shapes])
        layers = [
            part.reshape(shape) for part, shape in zip(np.split(self.weights, ends[:-1]), shapes)
        ]
        return layers[: len(sizes) - 1], layers[len(sizes) - 1 :]

    @cached_property
    def _powers(self) -> np.ndarray:
        return exponents(2 * self.latent, 1, int(self.order))

    @cached_property
    def _mass(self) -> csc_matrix:
        if self.mass_value is None:
            raise MethodError(
                "this model was fitted without a mass matrix, so a load cannot act on it; fit it in a scene with operators"
            )
        rows, columns = np.asarray(self.mass_row, int), np.asarray(self.mass_column, int)
        return csc_matrix(
            (self.mass_value, (rows, columns)), shape=(rows.max() + 1, rows.max() + 1)
        )

    @cached_property
    def _mass_factor(self):
        return splu(self._mass)

    @cached_property
    def _reduced_mass(self) -> np.ndarray:
        """s^2 B'MB (k, k)."""
        mass = (
            self._mass.toarray() if self.basis is None else self.basis.T @ (self._mass @ self.basis)
        )
        return mass * float(self.scale) ** 2

    @cached_property
    def _loads(self) -> dict[tuple[str, bytes], np.ndarray]:
        return {}

    def reduce(self, q: np.ndarray) -> np.ndarray:
        return (q if self.basis is None else q @ self.basis) / float(self.scale)

    def encode_motion(self, *motion: np.ndarray) -> np.ndarray:
        """z, z' and, with accelerations, z'' (channel, *batch, d) of displacement, velocity and
        acceleration (*batch, n).
        """
        return network(
            self._layers[0],
            self.encoder_linear,
            self.activation,
            np.stack([self.reduce(part) for part in motion]),
            len(motion) > 2,
        )

    @cached_property
    def _edge(self) -> np.ndarray:
        """Z (d,); infinite where the decoder is the network everywhere."""
        return (
            self.reach[: self.latent]
            if self.decoder_beyond == "tangent"
            else np.full(self.latent, np.inf)
        )

    def _decoder(self, position: np.ndarray, *along: np.ndarray) -> np.ndarray:
        """v(z) and v'(z) times each of `along` (channel, *batch, k), in network units; positions
        and directions are (*batch, d).
        """
        if self.decoder_beyond == "network":
            return network(
                self._layers[1], self.decoder_linear, self.activation, np.stack([position, *along])
            )
        c = np.clip(position, -self._edge, self._edge)
        found = network(
            self._layers[1],
            self.decoder_linear,
            self.activation,
            np.stack([c, *along, position - c]),
        )
        found[0] += found[-1]
        return found[:-1]

    def encode(self, x: np.ndarray) -> np.ndarray:
        q, v = np.split(np.asarray(x), 2, axis=-1)
        return np.concatenate([*self.encode_motion(q, v)], axis=-1)

    def decode(self, z: np.ndarray) -> np.ndarray:
        motion = self._decoder(*np.split(z, 2, axis=-1))
        return np.concatenate(
            [
                (item if self.basis is None else item @ self.basis.T) * float(self.scale)
                for item in motion
            ],
            axis=-1,
        )

    def displacement(self, z: np.ndarray, dofs: np.ndarray | None = None) -> np.ndarray:
        q = self._decoder(z[..., : self.latent])[0] * float(self.scale)
        if self.basis is None:
            return q if dofs is None else q[..., dofs]
        return q @ (self.basis if dofs is None else self.basis[dofs]).T

    def drift(self, z: np.ndarray) -> np.ndarray:
        d, rate = self.latent, float(self.rate)
        scale = np.repeat([1.0, rate], d)
        library = (
            monomials(z / scale, self._powers)
            if self.extrapolation == "none"
            else continued(z, scale, self.reach, self._powers)
        )
        value = library @ self.coefficients.T
        if len(self.coefficients) == d:
            return np.concatenate([z[..., d:], rate**2 * value], axis=-1)
        value[..., :d] *= rate
        value[..., d:] *= rate**2
        return value

    def _load(self, p: np.ndarray) -> np.ndarray:
        """What the rule needs of a load, in network units: B'M^-1 p / s, or the work s B'p. Kept,
        since a run has one load.
        """
        key = (self.force_rule, p.tobytes())
        if key not in self._loads:
            work = self.force_rule == "decoder_mass"
            value = p if work else self._mass_factor.solve(np.asarray(p, float))
            self._loads[key] = self.reduce(value) * (float(self.scale) ** 2 if work else 1.0)
        return self._loads[key]

    def force_map(self, z: np.ndarray, p: np.ndarray) -> np.ndarray:
        d, load = self.latent, self._load(p)
        position = z[..., :d]
        back = self._decoder(
            position, *(np.broadcast_to(direction, position.shape) for direction in np.eye(d))
        )
        tangents = back[1:]
        if self.force_rule == "encoder":
            along = np.stack([back[0], np.broadcast_to(load, back[0].shape)])
            value = network(self._layers[0], self.encoder_linear, self.activation, along)[1]
        else:
            weighted = (
                tangents @ self._reduced_mass if self.force_rule == "decoder_mass" else tangents
            )
            if d == 1:
                value = ((tangents[0] @ load) / (weighted[0] * tangents[0]).sum(axis=-1))[..., None]
            else:
                gram = np.einsum("i...k,j...k->...ij", weighted, tangents)
                value = np.linalg.solve(gram, np.moveaxis(tangents @ load, 0, -1)[..., None])[
                    ..., 0
                ]
        return np.concatenate([np.zeros_like(value), value], axis=-1)

    def field(self, p: np.ndarray | None) -> Field:
        from vibrom.latent.decoder_kernel import force_kernel
        from vibrom.latent.polynomial_kernel import polynomial_kernel
        from vibrom.solvers.reduced.field import Field

        d, rate, powers, coefficients = (
            self.latent,
            float(self.rate),
            self._powers,
            self.coefficients,
        )
        if len(coefficients) == d:  # z' = z' is a row of its own
            kinematic = (powers == np.eye(2 * d, dtype=int)[d:, None]).all(axis=2)
            coefficients = np.concatenate([kinematic, coefficients])
        scale = np.repeat([1.0, rate], d)
        drift = polynomial_kernel(
            scale,
            powers,
            coefficients * (rate * scale)[:, None],
            None if self.extrapolation == "none" else self.reach,
        )
        if p is None:
            return Field(drift)
        load, mass = (
            self._load(p),
            self._reduced_mass if self.force_rule == "decoder_mass" else None,
        )
        return Field(
            drift,
            force_kernel(
                *self._layers,
                self.encoder_linear,
                self.decoder_linear,
                self.activation,
                load,
                self.force_rule,
                mass,
                self._edge,
            ),
        )

    def guarded(self, guards: Guards, training: Training) -> AutoencoderRom:
        if not guards.dissipative:
            return replace(self, extrapolation=guards.extrapolation)
        motion, rate = (
            self.encode_motion(
                *(training.joined(what) for what in ("displacement", "velocity", "acceleration"))
            ),
            float(self.rate),
        )
        row = fit_dissipative(tuple(motion), self.reach, np.array([1.0, rate]), guards.dissipative)
        return replace(
            self, coefficients=row[None] / rate**2, order=guards.dissipative, extrapolation="linear"
        )
