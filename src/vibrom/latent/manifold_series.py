"""From the series of an invariant manifold to a reduced model."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vibrom.latent.manifold_rom import ManifoldRom
from vibrom.solvers.manifold.canonical import convergence_radius, convergence_scale
from vibrom.solvers.manifold.pade import numerator, of_circle, robust_denominator
from vibrom.solvers.manifold.parametrisation import Manifold
from vibrom.solvers.manifold.real import RealCoordinates

ASIDE = 1e-4  # weight of what is beside the manifold, a small part of the displacement
DIRECTIONS = 1e-9  # relative size below which a direction of displacement is left out


def spanning(rows: np.ndarray) -> np.ndarray:
    """Orthonormal directions (n, k) of the rows (m, n) that are longer than DIRECTIONS.

    The squares of lengths tell them, at a tenth of the cost of singular values, but no finer than
    the root of the precision: the small ones are told once the large ones are taken out.
    """
    found, largest = np.zeros((rows.shape[1], 0)), 0.0
    for least in (np.sqrt(DIRECTIONS), DIRECTIONS):
        rest = rows - (rows @ found) @ found.T
        squares, mixes = np.linalg.eigh(rest @ rest.T)
        largest = max(largest, squares[-1])
        kept = squares > least**2 * largest
        found = np.linalg.qr(
            np.hstack([found, rest.T @ (mixes[:, kept] / np.sqrt(squares[kept]))])
        )[0]
    return found


@dataclass(frozen=True)
class ManifoldSeries:
    """Shape, dynamics and force map of a manifold in complex coordinates."""

    manifold: Manifold
    push: np.ndarray  # S (2d, 1 + l, n), the constant first
    load: np.ndarray | None = None  # (n,) of which is known ..
    beside: np.ndarray | None = None  # .. the displacement beside the manifold, (1 + l', n)

    @cached_property
    def coordinates(self) -> RealCoordinates:
        """The real coordinates of the model."""
        return RealCoordinates(self.manifold.monomials, self.manifold.masters.eigenvalues)

    @property
    def of_circles(self) -> bool:
        """Is there one pair of complex eigenvalues, so that |z|^2 = z_1 z_2?"""
        return self.manifold.masters.mirror == (1, 0)

    @cached_property
    def radius(self) -> float:
        """|z| at which the series are of order one."""
        return convergence_scale(self.manifold)

    @cached_property
    def reach(self) -> np.ndarray:
        """(2d,) of a motion of that amplitude."""
        values = self.manifold.masters.eigenvalues
        rates = np.abs(values[: len(values) // 2])
        return 2.0 * self.radius * np.concatenate([np.ones(len(rates)), rates])

    @cached_property
    def basis(self) -> np.ndarray:
        """(n, k) orthonormal directions that hold all coefficients."""
        manifold, degrees = self.manifold, self.manifold.monomials.degrees[:, None]
        # Velocities are combinations of displacements, V = DW R, and at most so much larger.
        kept = (manifold.displacement * self.radius**degrees * degrees)[manifold.monomials.kept]
        stacked = [kept.real, kept.imag]
        if self.beside is not None:
            of_added = np.append(0, manifold.monomials.degrees)[: len(self.beside), None]
            added = self.beside * self.radius**of_added
            added *= ASIDE * np.abs(kept).max() / max(np.abs(added).max(), 1e-300)
            stacked += [added.real, added.imag]
        return spanning(np.vstack(stacked))

    @cached_property
    def parts(self) -> tuple[tuple[np.ndarray, int], ...]:
        """Complex series (1 + l, columns) of shape, dynamics and force map, each with the degree
        to which it is known.
        """
        manifold, forward = self.manifold, self.coordinates.forward
        order = manifold.monomials.order
        shapes = [part @ self.basis for part in (manifold.displacement, manifold.velocity)]
        pushed = np.tensordot(forward, self.push @ self.basis, 1)
        rows = np.hstack(shapes), manifold.dynamics.T @ forward.T
        return (
            *((np.vstack([np.zeros(part.shape[1]), part]), order) for part in rows),
            (np.concatenate(pushed, axis=1), order - 1),
        )

    def _beside(self, degree: int) -> dict[str, np.ndarray | None]:
        """The fields of what a load adds."""
        if self.beside is None:
            return dict.fromkeys(("load", "beside_terms", "below_beside"))
        monomials, known = self.manifold.monomials, len(self.beside)
        series = np.zeros((1 + len(monomials), self.basis.shape[1]), complex)
        series[:known] = self.beside @ self.basis
        top = int(monomials.degrees[known - 2]) - 1
        below = robust_denominator(monomials, series, top, degree, self.radius**2)
        change = self.coordinates.change
        above = (change @ numerator(monomials, series, top, below)).T * self._weight
        return {
            "load": self.load,
            "beside_terms": np.stack([above.real, above.imag]).copy(),
            "below_beside": self.coordinates.real(of_circle(monomials, below)) * self._weight,
        }

    @cached_property
    def _weight(self) -> np.ndarray:
        """(1 + l,) of a coefficient in y, in units of the reach."""
        return np.prod(self.reach**self.coordinates.powers, axis=1)

    def _ratio(self, part: int, degree: int) -> tuple[np.ndarray, np.ndarray]:
        """Numerators (columns, 1 + l) and denominator (1 + l,) of a part in real coordinates."""
        (series, top), monomials, change = (
            self.parts[part],
            self.manifold.monomials,
            self.coordinates,
        )
        below = robust_denominator(monomials, series, top, degree, self.radius**2)
        above = change.real(numerator(monomials, series, top, below)).T
        return np.ascontiguousarray(above * self._weight), change.real(
            of_circle(monomials, below)
        ) * self._weight

    def model(self, degree: int, aside: int | None = None) -> ManifoldRom:
        """With denominators of at most this degree in |z|^2, or `aside` of what a load adds."""
        (shape, below), (rate, below_rate), (push, below_push) = (
            self._ratio(part, degree) for part in range(3)
        )
        k = self.basis.shape[1]
        return ManifoldRom(
            reach=self.reach,
            scale=self.reach,
            powers=self.coordinates.powers,
            basis=self.basis,
            displacement_terms=shape[:k],
            velocity_terms=shape[k:],
            below=below,
            dynamics=rate,
            below_dynamics=below_rate,
            push=push.reshape(len(self.reach), k, -1),
            below_push=below_push,
            **self._beside(degree if aside is None else aside),
            radius=2.0 * convergence_radius(self.manifold),
            trust_displacement=None,
            trust_error=None,
        )
