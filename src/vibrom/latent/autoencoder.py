"""A bias-free autoencoder that carries time derivatives with its values (Taylor mode), for
training.

    w(q) = E q + N_w(q),    v(z) = D z + N_v(z) [- N_v'(0) z],    N(y) = W_l s(W_l-1 s(... W_1 y))

A motion is a stack (channel, sample, dof) of value, first and second time derivative. Through a
layer a = W y, and through s(a)

    y = s(a),    y' = s'(a) a',    y'' = s''(a) a'^2 + s'(a) a''

so derivatives cost two more forward passes and no nested differentiation. The gradient of a loss is
written out too: recording each product for automatic differentiation takes longer than these small
products themselves. Without biases rest maps to rest. E and D are an optional known linear part;
subtracting the network's own tangent makes D the exact tangent of the decoder at rest.
"""

from dataclasses import dataclass
from math import log, sqrt

import numpy as np

from vibrom.latent.backend import torch

Stack = torch.Tensor  # (channel, sample, dof)
Weights = list[torch.Tensor]  # of each layer (out, in), or their gradient
Tape = list[tuple]  # of each layer: its input, and of hidden ones s', s'' a', s''' a'^2 + s'' a''


def _elu(a: torch.Tensor, order: int) -> tuple[torch.Tensor, ...]:
    bent = torch.exp(a.clamp(max=0.0))
    low = torch.where(a > 0.0, a, bent - 1.0), bent
    if order == 1:
        return low
    second = torch.where(a > 0.0, 0.0, bent)
    return *low, second, second


def _silu(a: torch.Tensor, order: int) -> tuple[torch.Tensor, ...]:
    s = torch.sigmoid(a)
    r = torch.addcmul(s, s, s, value=-1.0)
    low = a * s, torch.addcmul(s, a, r)
    if order == 1:
        return low
    u = torch.rsub(s, 1.0, alpha=2.0)
    second = (a * u).add_(2.0).mul_(r)
    third = (u * u).sub_(r, alpha=2.0).mul_(a).add_(u, alpha=3.0).mul_(r)
    return *low, second, third


def _tanh(a: torch.Tensor, order: int) -> tuple[torch.Tensor, ...]:
    t = torch.tanh(a)
    first = 1.0 - t * t
    return (t, first, -2.0 * t * first, first * (6.0 * t * t - 2.0))[: order + 1]


def _softplus(a: torch.Tensor, order: int) -> tuple[torch.Tensor, ...]:
    s = torch.sigmoid(a)
    r = s * (1.0 - s)
    value = torch.nn.functional.softplus(a) - log(2.0)
    return (value, s, r, r * (1.0 - 2.0 * s))[: order + 1]


# name -> function of a and the order 1 or 3 that gives s, s', s'', s''' up to that derivative;
# every s(0) = 0.
ACTIVATIONS = {"elu": _elu, "silu": _silu, "tanh": _tanh, "softplus": _softplus}
SLOPE_AT_REST = {name: float(s(torch.zeros(()), 1)[1]) for name, s in ACTIVATIONS.items()}


def forward(y: Stack, weights: Weights, activation: str) -> tuple[Stack, Tape]:
    """N and its time derivatives, for a stack of one or three channels, and what `backward` needs
    of the way there.
    """
    tape = []
    for weight in weights[:-1]:
        a = y @ weight.T
        value, first, *higher = ACTIVATIONS[activation](a[0], len(y))
        out, bend, curl = value[None], None, None
        if higher:
            second, third = higher
            out = torch.empty_like(a)
            out[0] = value
            bend = second * a[1]
            torch.mul(a[1:], first, out=out[1:])
            out[2].addcmul_(bend, a[1])
            curl = (third * a[1]).mul_(a[1]).addcmul_(second, a[2])
        tape.append((y, first, bend, curl))
        y = out
    return y @ weights[-1].T, [*tape, (y,)]


def backward(
    g: Stack, weights: Weights, tape: Tape, slopes: Weights, inwards: bool
) -> Stack | None:
    """From the gradient g with respect to N: that with respect to each weight goes to `slopes`;
    that with respect to y is returned, if asked for.
    """
    for place in reversed(range(len(weights))):
        y, *bent = tape[place]
        if place < len(weights) - 1:
            first, bend, curl = bent
            back = g * first
            if bend is not None:
                back[0].addcmul_(g[1], bend).addcmul_(g[2], curl)
                back[1].addcmul_(g[2], bend, value=2.0)
            g = back
        flat = g.flatten(0, 1)
        torch.mm(flat.T, y.flatten(0, 1), out=slopes[place])
        if place or inwards:
            g = (flat @ weights[place]).view(*g.shape[:2], -1)
    return g if inwards else None


def tangent(weights: Weights, activation: str) -> torch.Tensor:
    """N'(0)."""
    product = weights[0]
    for weight in weights[1:]:
        product = SLOPE_AT_REST[activation] * (weight @ product)
    return product


def tangent_backward(g: torch.Tensor, weights: Weights, activation: str, slopes: Weights) -> None:
    """Adds to `slopes` what follows from the gradient g with respect to N'(0)."""
    before = [weights[0]]
    for weight in weights[1:-1]:
        before.append(SLOPE_AT_REST[activation] * (weight @ before[-1]))
    for place in reversed(range(1, len(weights))):
        g = SLOPE_AT_REST[activation] * g
        slopes[place].addmm_(g, before[place - 1].T)
        g = weights[place].T @ g
    slopes[0].add_(g)


@dataclass(frozen=True)
class Autoencoder:
    """The shape of the networks; weights travel separately, so that all that is learnt is one
    vector.

    `sizes` of the encoder, input to latent; the decoder mirrors them. encoder_linear E (d, n),
    decoder_linear D (n, d) or None.
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
        """Xavier: uniform within sqrt(6 / (inputs + outputs)). Drawn on the CPU in float64, so
        every device starts alike.
        """
        return [
            (2.0 * torch.rand(shape, generator=generator, dtype=torch.float64) - 1.0)
            * sqrt(6.0 / sum(shape))
            for shape in self.shapes
        ]

    def encode(self, q: Stack, weights: Weights) -> tuple[Stack, Tape]:
        """The motion of z = w(q), and what `encode_backward` needs."""
        z, tape = forward(q, self._encoder(weights), self.activation)
        return (z if self.encoder_linear is None else z.add_(q @ self.encoder_linear.T)), tape

    def encode_backward(self, g: Stack, weights: Weights, tape: Tape, slopes: Weights) -> None:
        """From the gradient with respect to z, that with respect to the encoder's weights."""
        backward(g, self._encoder(weights), tape, self._encoder(slopes), inwards=False)

    def linear_decoder(self, weights: Weights) -> torch.Tensor | None:
        """What multiplies z beside the network: D, less N_v'(0) where the tangent is fixed."""
        if self.decoder_linear is None or not self.fixed_tangent:
            return self.decoder_linear
        return self.decoder_linear - tangent(self._decoder(weights), self.activation)

    def decode(self, z: Stack, weights: Weights) -> tuple[Stack, Tape]:
        """The motion of q = v(z), and what `decode_backward` needs."""
        q, tape = forward(z, self._decoder(weights), self.activation)
        linear = self.linear_decoder(weights)
        return (q if linear is None else q.add_(z @ linear.T)), tape

    def decode_backward(
        self, g: Stack, z: Stack, weights: Weights, tape: Tape, slopes: Weights
    ) -> Stack:
        """From the gradient with respect to q, those with respect to the decoder's weights and to
        z.
        """
        decoder, found = self._decoder(weights), self._decoder(slopes)
        inner = backward(g, decoder, tape, found, inwards=True)
        if self.decoder_linear is None:
            return inner
        if self.fixed_tangent:
            tangent_backward(
                -(g.flatten(0, 1).T @ z.flatten(0, 1)), decoder, self.activation, found
            )
        return inner.add_(g @ self.linear_decoder(weights))

    def _encoder(self, weights: Weights) -> Weights:
        return weights[: len(self.sizes) - 1]

    def _decoder(self, weights: Weights) -> Weights:
        return weights[len(self.sizes) - 1 : 2 * len(self.sizes) - 2]


class Polynomial:
    """f(y) = C Phi(y) of y (sample, variable), with the monomials of the exponents `powers` (l,
    variable).
    """

    def __init__(self, powers: np.ndarray, device: torch.device):
        self.powers = torch.tensor(np.asarray(powers).T, device=device)  # (variable, l)
        self.lower = (self.powers - 1).clamp(min=0)
        self.top = int(np.max(powers, initial=0))  # none in linear dynamics that are known

    def monomials(self, y: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Phi (sample, l), and dPhi/dy (variable, sample, l)."""
        rows = [torch.ones_like(y)]
        for _ in range(self.top):
            rows.append(rows[-1] * y)
        table = torch.stack(rows, dim=-1)
        factors = [
            table[:, axis].index_select(-1, chosen) for axis, chosen in enumerate(self.powers)
        ]
        slopes = []
        for axis, chosen in enumerate(self.lower):
            slope = table[:, axis].index_select(-1, chosen) * self.powers[axis]
            for other, factor in enumerate(factors):
                if other != axis:
                    slope.mul_(factor)
            slopes.append(slope)
        value = factors[0]
        for factor in factors[1:]:
            value = value * factor
        return value, torch.stack(slopes)
