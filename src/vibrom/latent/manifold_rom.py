"""A nonlinear manifold of displacements and velocities, in rational functions.

    q = B N(z) / D(z),   v = B N'(z) / D(z),   dz/dt = R(z) / E(z) + S(z) B'p / F(z) u

N, N', R and S are polynomials of z / s, D, E and F scalar ones, constants where the model is
polynomial; B (n, k) are orthonormal directions. A known load p also adds a displacement beside the
manifold, of the same form and in proportion to u. A state is encoded as its nearest point of the
manifold,

    z = argmin |q - q(z)|^2 + |(v - v(z)) / f|^2,    f the frequency that s tells

found by Levenberg and Marquardt's method from what the linear part gives. The manifold may fold
over any linear coordinate of it. Polynomials may be extrapolated linearly beyond `reach`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from vibrom.latent.dissipative import fit_dissipative
from vibrom.latent.extrapolation import library as extrapolated
from vibrom.latent.polynomial import exponents, monomials
from vibrom.models.rom import Extrapolation, Guards, Rom, of_width, stored
from vibrom.models.training import Training, Unsupported

if TYPE_CHECKING:
    from vibrom.solvers.reduced.field import Kernel, VectorField

SAME = 1e-6  # relative difference up to which a load is a multiple of the known one
ITERATIONS, CLOSE = 60, 1e-12  # relative to the reach


@dataclass(frozen=True)
class ManifoldRom(Rom):
    """All polynomials share one list of monomials, whose coefficients are those of z / s."""

    scale: np.ndarray = stored(
        "1", "scale of the reduced coordinates in the monomials, in their own units", "coordinate"
    )
    powers: np.ndarray = stored(
        "1", "exponents of the monomials, the constant first", "term", "coordinate"
    )
    basis: np.ndarray = stored("1", "orthonormal directions of displacement", "dof", "direction")
    displacement_terms: np.ndarray = stored(
        "m", "coefficients of the displacement in the directions", "direction", "term"
    )
    velocity_terms: np.ndarray = stored(
        "m s-1", "coefficients of the velocity in the directions", "direction", "term"
    )
    below: np.ndarray = stored(
        "1", "coefficients of the denominator of displacement and velocity", "term"
    )
    dynamics: np.ndarray = stored(
        "1", "coefficients of the dynamics, in the unit of the rate", "coordinate", "term"
    )
    below_dynamics: np.ndarray = stored(
        "1", "coefficients of the denominator of the dynamics", "term"
    )
    push: np.ndarray = stored(
        "1",
        "coefficients of the force map, in the unit of the rate over N",
        "coordinate",
        "direction",
        "term",
    )
    below_push: np.ndarray = stored("1", "coefficients of the denominator of the force map", "term")
    load: np.ndarray | None = stored("N", "the load that is known beside", "dof")
    beside_terms: np.ndarray | None = stored(
        "m N-1",
        "coefficients of the displacement that this load adds, in phase and a quarter earlier",
        "wave",
        "direction",
        "term",
    )
    below_beside: np.ndarray | None = stored(
        "1", "coefficients of the denominator of that displacement", "term"
    )
    radius: float = stored(
        "1", "reduced position at which the series cease to converge, from their coefficients"
    )
    trust_displacement: np.ndarray | None = stored(
        "m", "largest displacement of a motion", "amplitude"
    )
    trust_error: np.ndarray | None = stored(
        "1",
        "relative residual of the equations of motion in that motion, as a displacement",
        "amplitude",
    )
    extrapolation: Extrapolation = "none"

    @property
    def _edge(self) -> np.ndarray | None:
        return None if self.extrapolation == "none" else self.reach

    def _library(self, z: np.ndarray) -> np.ndarray:
        return extrapolated(z, self.scale, self.powers, self._edge)

    def decode(self, z: np.ndarray) -> np.ndarray:
        """See Rom."""
        library = self._library(z)
        below = (library @ self.below)[..., None]
        parts = (self.displacement_terms, self.velocity_terms)
        return np.concatenate(
            [(library @ terms.T / below) @ self.basis.T for terms in parts], axis=-1
        )

    def displacement(self, z: np.ndarray, dofs: np.ndarray | None = None) -> np.ndarray:
        """See Rom."""
        library = self._library(z)
        below = (library @ self.below)[..., None]
        return self._seen(library, self.displacement_terms, dofs) / below

    def _seen(self, library: np.ndarray, terms: np.ndarray, dofs: np.ndarray | None) -> np.ndarray:
        """B C Phi (*batch, n) of monomials (*batch, l); of a few displacements, B C first."""
        if dofs is None:
            return (library @ terms.T) @ self.basis.T
        return library @ (self.basis[dofs] @ terms).T

    def drift(self, z: np.ndarray) -> np.ndarray:
        """See Rom."""
        library = self._library(z)
        return library @ self.dynamics.T / (library @ self.below_dynamics)[..., None]

    def force_map(self, z: np.ndarray, p: np.ndarray) -> np.ndarray:
        """See Rom."""
        library = self._library(z)
        return library @ self._pushed(p).T / (library @ self.below_push)[..., None]

    def _pushed(self, p: np.ndarray) -> np.ndarray:
        """(2d, l) coefficients of the force map of a load."""
        return np.tensordot(self.push, of_width(p, len(self.basis), "p") @ self.basis, ([1], [0]))

    def beside(
        self, z: np.ndarray, p: np.ndarray, dofs: np.ndarray | None = None
    ) -> np.ndarray | None:
        """See Rom."""
        if self.load is None:
            return None
        p = of_width(p, len(self.basis), "p")
        times = (self.load @ p) / (self.load @ self.load)
        if times == 0.0 or np.linalg.norm(p - times * self.load) > SAME * np.linalg.norm(p):
            return None  # another load
        library = self._library(z)
        below = (library @ self.below_beside)[..., None] / times
        return np.stack([self._seen(library, each, dofs) / below for each in self.beside_terms])

    def field(self, p: np.ndarray | None) -> VectorField:
        """See Rom."""
        from vibrom.solvers.reduced.field import VectorField

        drift = self._kernel(self.dynamics, self.below_dynamics)
        return VectorField(
            drift, None if p is None else self._kernel(self._pushed(p), self.below_push)
        )

    def _kernel(self, above: np.ndarray, below: np.ndarray) -> Kernel:
        from vibrom.latent.polynomial_kernel import polynomial_kernel
        from vibrom.latent.ratio_kernel import ratio_kernel

        if self._edge is None:
            return ratio_kernel(self.scale, self.powers, above, below)
        return polynomial_kernel(self.scale, self.powers, above, self._edge)

    @property
    def _polynomial(self) -> bool:
        return not any(
            np.any(part[1:]) for part in (self.below, self.below_dynamics, self.below_push)
        )

    def guarded(self, guards: Guards, training: Training) -> ManifoldRom:
        """See Rom."""
        if guards == Guards():
            return self
        if not self._polynomial or not training.trajectories:
            raise Unsupported(
                "these guards are for polynomials that were fitted to data; set "
                "extrapolation: none and dissipative: 0"
            )
        if not guards.dissipative:
            return replace(self, extrapolation=guards.extrapolation)
        return self._dissipative(training, guards.dissipative)

    def _dissipative(self, training: Training, order: int) -> ManifoldRom:
        """With dynamics of this order that cannot gain energy."""
        d = len(self.reach) // 2
        z, rates = training.joined("state").map(self.encode), []
        for block in training.joined("rate").blocks():
            done = sum(map(len, rates))
            rates.append(self._rate(z[done : done + len(block)], block)[:, d:])
        motion = np.stack([z[:, :d], z[:, d:], np.concatenate(rates)])
        row = fit_dissipative(motion, self.reach, self.scale, order)
        powers = exponents(2, 0, max(order, int(self.powers.sum(axis=1).max())))
        parts = {
            name: _longer(getattr(self, name), len(powers))
            for name in ("displacement_terms", "velocity_terms", "below", "push", "below_push")
        }
        dynamics = np.zeros((2, len(powers)))
        dynamics[0, (powers == [0, 1]).all(axis=1)] = self.scale[1]
        dynamics[1, 1 : 1 + len(row)] = row
        return replace(
            self,
            powers=powers,
            dynamics=dynamics,
            below_dynamics=_longer(np.ones(1), len(powers)),
            extrapolation="linear",
            **parts,
        )

    def _rate(self, z: np.ndarray, rate: np.ndarray) -> np.ndarray:
        """dz/dt (m, 2d) of states on the manifold whose rates (m, 2n) are known."""
        velocity, acceleration = np.split(rate, 2, axis=1)
        target = np.hstack([velocity @ self.basis, acceleration @ self.basis / self._frequency])
        _, tangents = self._near(z / self.scale)
        gram = np.einsum("mik,mjk->mij", tangents, tangents)
        right = np.einsum("mik,mk->mi", tangents, target)
        return np.linalg.solve(gram, right[..., None])[..., 0] * self.scale

    @property
    def _frequency(self) -> float:
        """f [1/s]."""
        d = len(self.scale) // 2
        return float((self.scale[d:] / self.scale[:d]).max())

    @cached_property
    def _stacked(self) -> np.ndarray:
        """(1 + 2d, 2k + 1, l): displacement, velocity over the frequency and the denominator; then
        their derivatives along each coordinate over its scale.
        """
        d, rate = len(self.reach) // 2, self._frequency
        whole = np.vstack([self.displacement_terms, self.velocity_terms / rate, self.below])
        place = {tuple(power): k for k, power in enumerate(self.powers.tolist())}
        found = [whole]
        for axis in range(2 * d):
            slope = np.zeros_like(whole)
            for k, power in enumerate(self.powers.tolist()):
                if power[axis]:
                    lower = place[tuple(e - (i == axis) for i, e in enumerate(power))]
                    slope[:, lower] += power[axis] * whole[:, k]
            found.append(slope)
        return np.stack(found)

    def _near(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The point (m, 2k) and the tangents (m, 2d, 2k) at z = s y."""
        library = monomials(y, self.powers)
        value = np.einsum("ml,ckl->mck", library, self._stacked, optimize=True)
        below = value[:, :1, -1:]
        point = value[:, :1, :-1] / below
        tangents = (value[:, 1:, :-1] - point * value[:, 1:, -1:]) / below
        return point[:, 0], tangents

    def encode(self, x: np.ndarray) -> np.ndarray:
        """The nearest point of the manifold (*batch, 2d)."""
        d, rate = len(self.reach) // 2, self._frequency
        x = of_width(x, 2 * len(self.basis), "x")
        q, v = np.split(x.reshape(-1, x.shape[-1]), 2, axis=1)
        target = np.hstack([q @ self.basis, v @ self.basis / rate])
        _, linear = self._near(np.zeros((1, 2 * d)))
        y = np.linalg.lstsq(linear[0].T, target.T, rcond=None)[0].T
        y = nearest(self._near, target, y)
        return (y * self.scale).reshape(*x.shape[:-1], 2 * d)


def _longer(part: np.ndarray, length: int) -> np.ndarray:
    """Zero coefficients behind the last axis."""
    return np.pad(part, [(0, 0)] * (part.ndim - 1) + [(0, length - part.shape[-1])])


def nearest(near, target: np.ndarray, start: np.ndarray) -> np.ndarray:
    """The y (m, r) of least |target - point(y)| near `start`; `near` gives points (m, k) and their
    tangents (m, r, k), targets are (m, k).
    """
    y, (point, tangents) = start.copy(), near(start)
    error, damping = np.square(target - point).sum(axis=1), np.full(len(start), 1e-3)
    left = np.arange(len(start))
    for _ in range(ITERATIONS):
        gap = target[left] - point[left]
        gram = np.einsum("mik,mjk->mij", tangents[left], tangents[left])
        diagonal = np.einsum("mii->mi", gram)
        damped = gram + (damping[left, None] * diagonal)[:, :, None] * np.eye(y.shape[1])
        right = np.einsum("mik,mk->mi", tangents[left], gap)
        step = np.linalg.solve(damped, right[..., None])[..., 0]
        trial, trial_tangents = near(y[left] + step)
        found = np.square(target[left] - trial).sum(axis=1)
        better = found <= error[left]
        taken = left[better]
        y[taken] += step[better]
        point[taken], tangents[taken] = trial[better], trial_tangents[better]
        error[taken] = found[better]
        damping[left] *= np.where(better, 0.1, 10.0)
        moving = np.abs(step).max(axis=1) > CLOSE
        left = left[moving]
        if not len(left):
            break
    return y
