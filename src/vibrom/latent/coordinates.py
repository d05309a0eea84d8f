"""Coordinates in which training is well conditioned.

    q = s B c,    tau = f t

B (n, k) orthonormal directions: the known modes first, if wanted, then the proper orthogonal
directions of what they leave of the training displacements; s [m] the root mean square displacement
vector; f [1/s] the first angular frequency. Lengths in c are lengths in q, over s. A direction that
carries less than 5e-7 of the displacements is left out: what the data say of it is rounding.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.sparse.linalg import splu

from vibrom.models.samples import Samples, directions
from vibrom.models.training import Structure, Training, Trajectory

SMALLEST = 5e-7  # of the displacements: what a direction carries at least

Linear = Literal["none", "pod", "modes"]
TimeScale = Literal["first_frequency", "none"]


@dataclass(frozen=True)
class Coordinates:
    """Units of displacement and time."""

    basis: np.ndarray | None  # B (n, k); None: the displacements themselves
    scale: float  # s, m
    frequency: float  # f, 1/s

    def reduce(self, q: np.ndarray) -> np.ndarray:
        """Coordinates c = B'q/s (*batch, k) of q (*batch, n)."""
        return (q if self.basis is None else q @ self.basis) / self.scale

    def expand(self, c: np.ndarray) -> np.ndarray:
        """Displacements q = s B c (*batch, n) of c (*batch, k)."""
        return (c if self.basis is None else c @ self.basis.T) * self.scale

    def directions(self, n: int) -> np.ndarray:
        """Displacements s B (n, k) of one unit of each coordinate."""
        return self.scale * (np.eye(n) if self.basis is None else self.basis)

    def stack(self, trajectories: tuple[Trajectory, ...], every: int = 1) -> np.ndarray:
        """(3, samples, k): c, dc/dtau, d2c/dtau2 of every k-th sample of each trajectory, one after
        the other.
        """
        names = ("displacement", "velocity", "acceleration")
        return np.stack(
            [
                Samples(tuple(item.columns(name) for item in trajectories))
                .thinned(every)
                .map(lambda rows, power=power: self.reduce(rows / self.frequency**power))
                for power, name in enumerate(names)
            ]
        )


def choose(
    training: Training, *, rank: int, modes: int, scaled: bool, time_scale: TimeScale
) -> Coordinates:
    """Coordinates for this training set; rank 0 keeps the displacements, `modes` directions come
    from the structure.
    """
    q = training.joined("displacement")
    scale = float(np.sqrt(np.mean(q.map(lambda rows: np.sum(rows**2, axis=1))))) if scaled else 1.0
    basis = _basis(q, rank, known(training, modes)) if rank else None
    return Coordinates(basis, scale, _frequency(training, time_scale))


def known(training: Training, modes: int) -> np.ndarray:
    """The first `modes` mode shapes (n, modes)."""
    if not modes:
        return np.zeros((training.joined("displacement").shape[1], 0))
    return training.require_structure("linear: modes").leading(modes, "latent").T


def _basis(q: Samples, rank: int, first: np.ndarray) -> np.ndarray:
    rank = min(rank, *q.shape)
    first = np.linalg.qr(first)[0]
    rest = (rows - (rows @ first) @ first.T for rows in q.blocks())
    others = principal(rest, rank - first.shape[1], SMALLEST * q.norm())
    return np.linalg.qr(np.hstack([first, others]))[0]


def principal(q: Iterable[np.ndarray], count: int, smallest: float = 0.0) -> np.ndarray:
    """The first proper orthogonal directions (n, count) of samples (m, n), which come in blocks of
    rows, or as many as have a singular value of at least `smallest`.
    """
    values, vectors = directions(iter(q), count)
    vectors = vectors[:count][values[:count] >= smallest]
    # The sign of a singular vector is the library's choice; the largest entry is made positive.
    largest = np.abs(vectors).argmax(axis=1)
    signs = np.sign(vectors[np.arange(len(vectors)), largest])
    return (vectors * signs[:, None]).T


def linear_parts(
    training: Training, chosen: Coordinates, c: np.ndarray, linear: Linear, latent: int
) -> tuple[np.ndarray, np.ndarray]:
    """E (d, k) and D (k, d) of z = E c, c = D z, such that z reaches 1 in c (m, k): zero (`none`),
    the first directions (`pod`), or E = phi' M, D = phi of the first `modes`.
    """
    if linear == "none":
        return np.zeros((latent, c.shape[1])), np.zeros((c.shape[1], latent))
    if linear == "modes":
        modes, structure = known(training, latent), training.require_structure("linear: modes")
        columns = chosen.reduce(modes.T).T
        rows = chosen.reduce((structure.mass @ modes).T) * chosen.scale**2
    else:
        columns = principal([c], latent)
        rows = columns.T
    reach = np.abs(c @ rows.T).max(axis=0)
    return rows / reach[:, None], columns * reach


def _frequency(training: Training, time_scale: TimeScale) -> float:
    if time_scale == "none":
        return 1.0
    if training.structure is not None:
        return float(training.structure.frequencies[0])
    # Without modes: |v| / |q|, which is the frequency for a vibration in one mode.
    velocity, displacement = training.joined("velocity"), training.joined("displacement")
    return velocity.norm() / displacement.norm()


def linear_dynamics(structure: Structure, latent: int, frequency: float = 1.0) -> np.ndarray:
    """R0 (d, 2d) of d2z/dtau2 = R0 (z, dz/dtau) for z in the first d modes: (-phi' K phi / f^2,
    -phi' C phi / f).
    """
    phi = structure.leading(latent, "latent").T
    stiffness, damping = phi.T @ (structure.stiffness @ phi), phi.T @ (structure.damping @ phi)
    return np.hstack([-stiffness / frequency**2, -damping / frequency])


def static_norm(structure: Structure, chosen: Coordinates) -> np.ndarray:
    """G (k, k) = f^2 B' K^-1 M B: the displacement in c that the inertia of an acceleration
    d2c/dtau2 makes at rest, 1 for the first mode.
    """
    basis = np.eye(structure.mass.shape[0]) if chosen.basis is None else chosen.basis
    static = splu(structure.stiffness.tocsc()).solve(structure.mass @ basis)
    return chosen.frequency**2 * basis.T @ static
