"""Coordinates in which training is well conditioned.

    c = B' q / s,    tau = f t

B (n, k) orthonormal directions: the known modes first, if asked, then the proper orthogonal
directions of what they leave of the training displacements; s [m] the root mean square displacement
vector; f [1/s] the first angular frequency. Lengths in c are lengths in q, over s.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import splu

from vibrom.models.training import MethodError, Structure, Training, Trajectory


@dataclass(frozen=True)
class Coordinates:
    """basis (n, k) or None for the displacements themselves, scale [m], rate [1/s]."""

    basis: np.ndarray | None
    scale: float
    rate: float

    def reduce(self, q: np.ndarray) -> np.ndarray:
        """C (*batch, k) of q (*batch, n)."""
        return (q if self.basis is None else q @ self.basis) / self.scale

    def stack(self, trajectories: tuple[Trajectory, ...], every: int) -> np.ndarray:
        """(3, samples, k): c, dc/dtau, d2c/dtau2 of every k-th sample of each trajectory, one after
        the other.
        """
        motions = [
            (
                item.displacement[::every],
                item.velocity[::every] / self.rate,
                item.acceleration[::every] / self.rate**2,
            )
            for item in trajectories
        ]
        return np.stack(
            [
                np.concatenate([self.reduce(motion[channel]) for motion in motions])
                for channel in range(3)
            ]
        )


def choose(
    training: Training, *, rank: int, modes: int, scaled: bool, time_scale: str
) -> Coordinates:
    """Coordinates for this training set; rank 0 keeps the displacements, `modes` directions come
    from the structure.
    """
    q = training.joined("displacement")
    scale = float(np.sqrt(np.mean(np.sum(q**2, axis=1)))) if scaled else 1.0
    return Coordinates(
        _basis(q, rank, known(training, modes)) if rank else None,
        scale,
        _rate(training, time_scale),
    )


def known(training: Training, modes: int) -> np.ndarray:
    """The first `modes` mode shapes (n, modes)."""
    return (
        training.require_structure("linear: modes").leading(modes, "latent").T
        if modes
        else np.zeros((training.joined("displacement").shape[1], 0))
    )


def _basis(q: np.ndarray, rank: int, first: np.ndarray) -> np.ndarray:
    rank = min(rank, *q.shape)
    first = np.linalg.qr(first)[0]
    rest = q - (q @ first) @ first.T
    return np.linalg.qr(np.hstack([first, principal(rest, rank - first.shape[1])]))[0]


def principal(q: np.ndarray, count: int) -> np.ndarray:
    """The first proper orthogonal directions (n, count) of samples (m, n)."""
    directions = np.linalg.svd(q, full_matrices=False)[2][:count]
    # The sign of a singular vector is the library's choice; the largest entry is made positive.
    return (
        directions
        * np.sign(directions[np.arange(len(directions)), np.abs(directions).argmax(axis=1)])[
            :, None
        ]
    ).T


def linear_parts(
    training: Training, chosen: Coordinates, c: np.ndarray, linear: str, latent: int
) -> tuple[np.ndarray, np.ndarray]:
    """E (d, k) and D (k, d) of z = E c, c = D z, such that z reaches 1 in c (m, k): zero (`none`),
    the first directions (`pod`), or E = phi' M, D = phi of the first `modes`.
    """
    if linear == "none":
        return np.zeros((latent, c.shape[1])), np.zeros((c.shape[1], latent))
    if linear == "modes":
        modes = known(training, latent)
        columns = chosen.reduce(modes.T).T
        rows = chosen.reduce((training.structure.mass @ modes).T) * chosen.scale**2
    else:
        columns = principal(c, latent)
        rows = columns.T
    reach = np.abs(c @ rows.T).max(axis=0)
    return rows / reach[:, None], columns * reach


def _rate(training: Training, time_scale: str) -> float:
    if time_scale == "none":
        return 1.0
    if time_scale != "first_frequency":
        raise MethodError(f"time_scale is {time_scale!r}; give first_frequency or none")
    if training.structure is not None:
        return float(training.structure.frequencies[0])
    # Without modes: |v| / |q|, which is the frequency for a vibration in one mode.
    return float(
        np.linalg.norm(training.joined("velocity"))
        / np.linalg.norm(training.joined("displacement"))
    )


def linear_dynamics(structure: Structure, latent: int, rate: float = 1.0) -> np.ndarray:
    """R0 (d, 2d) of d2z/dtau2 = R0 (z, dz/dtau) for z in the first d modes: (-phi' K phi / rate^2,
    -phi' C phi / rate).
    """
    phi = structure.leading(latent, "latent").T
    return np.hstack(
        [
            -(phi.T @ (structure.stiffness @ phi)) / rate**2,
            -(phi.T @ (structure.damping @ phi)) / rate,
        ]
    )


def static_norm(structure: Structure, chosen: Coordinates) -> np.ndarray:
    """G (k, k) = f^2 B' K^-1 M B: the displacement in c that the inertia of an acceleration
    d2c/dtau2 makes at rest, 1 for the first mode.
    """
    basis = np.eye(structure.mass.shape[0]) if chosen.basis is None else chosen.basis
    return (
        chosen.rate**2 * basis.T @ splu(structure.stiffness.tocsc()).solve(structure.mass @ basis)
    )
