"""The loss of an autoencoder with its dynamics, and its gradient.

    L = |c - v(z)|^2 + l1 |G (c'' - d2/dtau2 v(z))|^2 + l2 |z'' - f|^2 + l3 |Xi|_1
    z = w(c),    f = R0 y + Xi Theta(y),    y = (z, z')

means over samples of squared norms; the second term takes z'' = f. Without dynamics only the first
term is left; without a norm G is one. All that is learnt is one vector: the weights, then Xi over
its gain. The gradient is written out, as in `autoencoder`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vibrom.latent.autoencoder import Autoencoder, Polynomial
from vibrom.latent.backend import torch


@dataclass(frozen=True)
class Dynamics:
    """What is learnt together with the autoencoder, and how much it counts."""

    linear: np.ndarray | None  # R0 (d, 2d); None: zero
    powers: np.ndarray  # exponents (l, 2d) of Theta
    initial: float  # of every entry of Xi
    gain: float  # learning rate of Xi over that of the weights
    full: float  # l1
    reduced: float  # l2
    sparsity: float = 0.0  # l3
    norm: np.ndarray | None = None  # G (k, k); None: one


class Learner:
    """An autoencoder, its dynamics, and the vector of all that is learnt."""

    def __init__(
        self,
        autoencoder: Autoencoder,
        dynamics: Dynamics | None,
        dtype: torch.dtype,
        device: torch.device,
        generator: torch.Generator,
    ):
        self.autoencoder, self.dynamics = autoencoder, dynamics
        parts = autoencoder.initial(generator)
        self.terms: tuple[str, ...] = ("total", "reconstruction")
        if dynamics:
            self.terms += ("acceleration_full", "acceleration_reduced")
            shape = (autoencoder.sizes[-1], len(dynamics.powers))
            start = dynamics.initial / dynamics.gain
            parts.append(torch.full(shape, start, dtype=torch.float64))
            self.linear, self.norm = (
                None if given is None else torch.tensor(given, dtype=dtype, device=device)
                for given in (dynamics.linear, dynamics.norm)
            )
            self.polynomial = Polynomial(dynamics.powers, device)
        self.shapes = [part.shape for part in parts]
        self.vector = torch.cat([part.flatten() for part in parts]).to(dtype=dtype, device=device)
        self.gradient = torch.zeros_like(self.vector)
        # Of each part a view: what is learnt, and the gradient with respect to it.
        self.parts, self.slopes = self._views(self.vector), self._views(self.gradient)

    def _views(self, vector: torch.Tensor) -> list[torch.Tensor]:
        parts = vector.split([shape.numel() for shape in self.shapes])
        return [part.view(shape) for part, shape in zip(parts, self.shapes)]

    def learnt(self) -> tuple[list[np.ndarray], np.ndarray]:
        """The weights, layer by layer, and Xi (d, l); l is 0 without dynamics."""
        parts = [part.cpu().double().numpy().copy() for part in self.parts]
        if self.dynamics is None:
            return parts, np.zeros((self.autoencoder.sizes[-1], 0))
        return parts[:-1], self.dynamics.gain * parts[-1]

    def losses(self, c: torch.Tensor) -> torch.Tensor:
        """The `terms` of the loss of c (3, sample, k); the gradient of their total is left in
        `gradient`.
        """
        if self.dynamics is None:
            return self._reconstruction(c[:1])
        return self._with_dynamics(c, self.dynamics)

    def _reconstruction(self, c: torch.Tensor) -> torch.Tensor:
        z, encoded = self.autoencoder.encode(c, self.parts)
        v, decoded = self.autoencoder.decode(z, self.parts)
        error = v.sub_(c)
        mean = mean_square(error[0])
        dv = error.mul_(2.0 / c.shape[1])
        dz = self.autoencoder.decode_backward(dv, z, self.parts, decoded, self.slopes)
        self.autoencoder.encode_backward(dz, self.parts, encoded, self.slopes)
        return torch.stack([mean, mean])

    def _with_dynamics(self, c: torch.Tensor, dynamics: Dynamics) -> torch.Tensor:
        xi, two_over_m = dynamics.gain * self.parts[-1], 2.0 / c.shape[1]
        z, encoded = self.autoencoder.encode(c, self.parts)
        y = torch.cat([z[0], z[1]], dim=-1)
        theta, dtheta_dy = self.polynomial.monomials(y)
        f = theta @ xi.T
        if self.linear is not None:
            f.addmm_(y, self.linear.T)
        motion = torch.stack([z[0], z[1], f])
        v, decoded = self.autoencoder.decode(motion, self.parts)
        error, reduced_error = v.sub_(c), z[2] - f
        if self.norm is not None:
            error[2] = error[2] @ self.norm.T
        means = torch.stack([mean_square(part) for part in (error[0], error[2], reduced_error)])
        total = means[0] + dynamics.full * means[1] + dynamics.reduced * means[2]
        if dynamics.sparsity:
            total = total + dynamics.sparsity * xi.abs().sum()
        # Backwards: dq is the gradient of the total with respect to q.
        dv = error
        dv[0].mul_(two_over_m)
        dv[1].zero_()  # velocities are in no term
        dv[2].mul_(two_over_m * dynamics.full)
        if self.norm is not None:
            dv[2] = dv[2] @ self.norm
        dz = self.autoencoder.decode_backward(dv, motion, self.parts, decoded, self.slopes)
        dz2 = reduced_error.mul_(two_over_m * dynamics.reduced)
        df = dz[2] - dz2
        self._to_xi(df, theta, xi)
        dy = ((df @ xi) * dtheta_dy).sum(dim=-1).T
        if self.linear is not None:
            dy = dy + df @ self.linear
        dz[:2].add_(torch.stack(dy.chunk(2, dim=-1)))
        dz[2] = dz2
        self.autoencoder.encode_backward(dz, self.parts, encoded, self.slopes)
        return torch.cat([total[None], means])

    def _to_xi(self, df: torch.Tensor, theta: torch.Tensor, xi: torch.Tensor) -> None:
        """The gradient with respect to Xi over its gain, from that with respect to f."""
        slope, sparsity = self.slopes[-1], self.dynamics.sparsity if self.dynamics else 0.0
        torch.mm(df.T, theta, out=slope)
        if sparsity:
            slope.add_(xi.sign(), alpha=sparsity)
        slope.mul_(self.dynamics.gain if self.dynamics else 1.0)


def mean_square(residual: torch.Tensor) -> torch.Tensor:
    """The mean over samples of the squared norms of (sample, k)."""
    flat = residual.flatten()
    return flat.dot(flat) / len(residual)
