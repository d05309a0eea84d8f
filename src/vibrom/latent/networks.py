"""A bias-free network beside a linear part, in NumPy:  N(y) + L y,  N(y) = W_l s(... s(W_1 y)).

Derivatives along a motion are carried with the values (Taylor mode): through a layer a = W y, and
through s(a)

    y = s(a),    y' = s'(a) a',    y'' = s''(a) a'^2 + s'(a) a''
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

Activation = Literal["elu", "silu", "softplus", "tanh"]


def activate(name: str, a: np.ndarray, order: int) -> tuple[np.ndarray, ...]:
    """s, s' and s'' of a, up to this derivative; s(0) = 0."""
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


@dataclass(frozen=True)
class Network:
    """Weights of each layer, the linear part beside them, and the activation between layers."""

    weights: list[np.ndarray]  # of each layer (outputs, inputs)
    linear: np.ndarray  # L (outputs of the last layer, inputs of the first)
    activation: Activation

    def along(self, y: np.ndarray) -> np.ndarray:
        """The value, and first derivatives along each further channel of y (channel, *batch, n)."""
        straight = y @ self.linear.T
        for weight in self.weights[:-1]:
            a = y @ weight.T
            value, slope = activate(self.activation, a[0], 1)
            y = np.empty_like(a)
            y[0] = value
            np.multiply(slope, a[1:], out=y[1:])
        return y @ self.weights[-1].T + straight

    def motion(self, y: np.ndarray) -> np.ndarray:
        """The value and its first and second time derivative, from those of y (3, *batch, n)."""
        straight = y @ self.linear.T
        for weight in self.weights[:-1]:
            a = y @ weight.T
            value, slope, bend = activate(self.activation, a[0], 2)
            y = np.stack([value, slope * a[1], slope * a[2] + bend * a[1] ** 2])
        return y @ self.weights[-1].T + straight

    def slope_at_rest(self) -> np.ndarray:
        """N'(0), without the linear part."""
        product, slope = self.weights[0], float(activate(self.activation, np.zeros(()), 1)[1])
        for weight in self.weights[1:]:
            product = slope * (weight @ product)
        return product


def layers(sizes: np.ndarray, weights: np.ndarray) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """The layers of the encoder with these sizes, input to latent, and of the decoder that mirrors
    it, from the vector of all weights, rows first.
    """
    units = [int(size) for size in sizes]
    shapes = list(zip(units[1:], units[:-1]))
    shapes += [(columns, rows) for rows, columns in reversed(shapes)]
    ends = np.cumsum([rows * columns for rows, columns in shapes])
    parts = [part.reshape(shape) for part, shape in zip(np.split(weights, ends[:-1]), shapes)]
    return parts[: len(units) - 1], parts[len(units) - 1 :]
