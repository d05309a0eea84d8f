"""A bias-free autoencoder that carries time derivatives with its values (Taylor mode), for training.

    w(q) = E q + N_w(q),    v(z) = D z + N_v(z) [- N_v'(0) z],    N(y) = W_l s(W_l-1 s(... W_1 y))

A motion is a stack (channel, sample, dof) of value, first and second time derivative. Through a layer a = W y, and through s(a)

    y = s(a),    y' = s'(a) a',    y'' = s''(a) a'^2 + s'(a) a''

so derivatives cost two more forward passes and no nested differentiation. Without biases rest maps to rest. E and D are an optional known
linear part; subtracting the network's own tangent makes D the exact tangent of the decoder at rest.
"""

from dataclasses import dataclass
from math import log, sqrt

import numpy as np
import torch

Stack = torch.Tensor  # (channel, sample, dof)


def _elu(a):
    bent = torch.exp(a.clamp(max=0.0))
    second = torch.where(a > 0.0, torch.zeros_like(a), bent)
    return torch.where(a > 0.0, a, bent - 1.0), bent, second, second


def _silu(a):
    s = torch.sigmoid(a)
    r, u = s * (1.0 - s), 1.0 - 2.0 * s
    return a * s, s + a * r, r * (2.0 + a * u), r * (3.0 * u + a * (u * u - 2.0 * r))


def _tanh(a):
    t = torch.tanh(a)
    first = 1.0 - t * t
    return t, first, -2.0 * t * first, first * (6.0 * t * t - 2.0)


def _softplus(a):
    s = torch.sigmoid(a)
    r = s * (1.0 - s)
    return torch.nn.functional.softplus(a) - log(2.0), s, r, r * (1.0 - 2.0 * s)


# name -> function of a that gives s, s', s'', s'''; every s(0) = 0.
ACTIVATIONS = {"elu": _elu, "silu": _silu, "tanh": _tanh, "softplus": _softplus}
SLOPE_AT_REST = {"elu": 1.0, "silu": 0.5, "tanh": 1.0, "softplus": 0.5}


class _Activate(torch.autograd.Function):
    """s of a stack with one to three channels. Written out, because recording each product costs three times as much."""

    @staticmethod
    def forward(ctx, a: Stack, name: str) -> Stack:
        value, first, second, third = ACTIVATIONS[name](a[0])
        y = torch.empty_like(a)
        y[0] = value
        if len(a) > 1:
            torch.mul(first, a[1], out=y[1])
        if len(a) > 2:
            torch.mul(first, a[2], out=y[2])
            y[2].addcmul_(second * a[1], a[1])
        ctx.save_for_backward(a, first, second, third)
        return y

    @staticmethod
    def backward(ctx, gradient: Stack):
        a, first, second, third = ctx.saved_tensors
        back = gradient * first
        if len(a) > 1:
            bend = second * a[1]
            back[0].addcmul_(gradient[1], bend)
        if len(a) > 2:
            back[0].addcmul_(gradient[2], (third * a[1]).mul_(a[1]).addcmul_(second, a[2]))
            back[1].addcmul_(gradient[2], bend, value=2.0)
        return back, None


def network(y: Stack, weights: list[torch.Tensor], activation: str) -> Stack:
    """N and its time derivatives, for a stack of one to three channels."""
    for weight in weights[:-1]:
        y = _Activate.apply(y @ weight.T, activation)
    return y @ weights[-1].T


def tangent(weights: list[torch.Tensor], activation: str) -> torch.Tensor:
    """N'(0)."""
    product = weights[0]
    for weight in weights[1:]:
        product = SLOPE_AT_REST[activation] * (weight @ product)
    return product


@dataclass(frozen=True)
class Autoencoder:
    """The shape of the networks; weights travel separately, so that all that is learnt is one vector.

    `sizes` of the encoder, input to latent; the decoder mirrors them. encoder_linear E (d, n), decoder_linear D (n, d) or None.
    """

    sizes: tuple[int, ...]
    activation: str
    encoder_linear: torch.Tensor | None = None
    decoder_linear: torch.Tensor | None = None
    fixed_tangent: bool = False

    @property
    def shapes(self) -> list[tuple[int, int]]:
        """Of all weights: encoder, then decoder."""
        encoder = [(rows, columns) for columns, rows in zip(self.sizes, self.sizes[1:])]
        return encoder + [(columns, rows) for rows, columns in reversed(encoder)]

    def initial(self, generator: torch.Generator) -> list[torch.Tensor]:
        """Xavier: uniform within sqrt(6 / (inputs + outputs)). Drawn on the CPU in float64, so every device starts alike."""
        return [(2.0 * torch.rand(shape, generator=generator, dtype=torch.float64) - 1.0) * sqrt(6.0 / sum(shape)) for shape in self.shapes]

    def encode(self, q: Stack, weights: list[torch.Tensor]) -> Stack:
        z = network(q, weights[: len(self.sizes) - 1], self.activation)
        return z if self.encoder_linear is None else z + q @ self.encoder_linear.T

    def linear_decoder(self, weights: list[torch.Tensor]) -> torch.Tensor | None:
        """What multiplies z beside the network: D, less N_v'(0) where the tangent is fixed."""
        if self.decoder_linear is None or not self.fixed_tangent:
            return self.decoder_linear
        return self.decoder_linear - tangent(weights[len(self.sizes) - 1:], self.activation)

    def decode(self, z: Stack, weights: list[torch.Tensor]) -> Stack:
        q = network(z, weights[len(self.sizes) - 1:], self.activation)
        linear = self.linear_decoder(weights)
        return q if linear is None else q + z @ linear.T


def monomials(y: torch.Tensor, powers: np.ndarray) -> torch.Tensor:
    """(sample, l) values of the monomials with exponents `powers` (l, variable) at y (sample, variable)."""
    columns = []
    for row in powers:
        factors = [y[:, axis] for axis, power in enumerate(row) for _ in range(power)]
        product = factors[0]
        for factor in factors[1:]:
            product = product * factor
        columns.append(product)
    return torch.stack(columns, dim=-1)
