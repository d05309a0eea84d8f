"""The eigenmodes that a manifold starts from.

    (lambda^2 M + lambda C + K) phi = 0,    psi' (lambda^2 M + lambda C + K) = 0,
    psi' (2 lambda M + C) phi = 1

Each undamped mode gives a pair of eigenvalues; where C does not couple it to others its shape is
the mode itself, else Newton's method leads from it to the damped one. A first-order state (q, v)
has  psi' [(C + lambda M) q + M v]  of each.
"""

from dataclasses import dataclass

import numpy as np

from vibrom.solvers.manifold.pencil import Border, Pencil
from vibrom.term import SceneError

STEPS, CLOSE = 20, 1e-13


@dataclass(frozen=True)
class Masters:
    """d pairs: the first of each pair, then their partners."""

    eigenvalues: np.ndarray  # lambda (2d,) 1/s
    shapes: np.ndarray  # phi (2d, n)
    left: np.ndarray  # psi (2d, n)
    mirror: tuple[int, ...]  # where the conjugate of each stands

    @property
    def pinned(self) -> np.ndarray:
        """(d,) displacements in which the shapes differ most, one for each pair."""
        shapes = self.shapes[: len(self.shapes) // 2].copy()
        chosen = []
        for row in range(len(shapes)):
            place = int(np.abs(shapes[row]).argmax())
            chosen.append(place)
            shapes -= np.outer(shapes[:, place] / shapes[row, place], shapes[row])
        return np.array(chosen)


def masters(pencil: Pencil, frequencies: np.ndarray, modes: np.ndarray) -> Masters:
    """Of the undamped modes (d, n) at these frequencies (d,) [rad/s]."""
    values, shapes, lefts = [], [], []
    for omega, phi in zip(frequencies, modes):
        c = phi @ (pencil.damping @ phi) / (phi @ (pencil.mass @ phi))
        root = np.sqrt(complex(0.25 * c * c - omega * omega))
        for sign in (1.0, -1.0):
            value, shape, left = _refined(pencil, -0.5 * c + sign * root, phi.astype(complex))
            values.append(value)
            shapes.append(shape)
            lefts.append(left)
    order = np.concatenate([np.arange(0, len(values), 2), np.arange(1, len(values), 2)])
    eigenvalues = np.array(values)[order]
    distance = np.abs(eigenvalues[:, None] - eigenvalues.conj())
    mirror = distance.argmin(axis=1)
    if sorted(mirror) != list(range(len(mirror))):
        raise SceneError("effects: two of the chosen modes are one; choose modes that differ")
    return Masters(
        eigenvalues, np.array(shapes)[order], np.array(lefts)[order], tuple(mirror.tolist())
    )


def _refined(
    pencil: Pencil, value: complex, shape: np.ndarray
) -> tuple[complex, np.ndarray, np.ndarray]:
    """The eigenvalue near `value`, its right and its left vector; phi of the length of `shape`."""
    pinned = np.array([int(np.abs(shape).argmax())])
    phi, row = shape, (shape / (shape @ shape))[None]
    for _ in range(STEPS):
        residual = pencil.at(value) @ phi
        scale = np.abs(pencil.stiffness) @ np.abs(phi)
        if np.linalg.norm(residual) <= CLOSE * np.linalg.norm(scale):
            break
        column = (pencil.derivative(value) @ phi)[None]
        border = Border(column, row, np.zeros((1, 1)), pinned)
        missing = 1.0 - row @ phi
        (change,), ((shift,),) = pencil.solve_bordered(
            value, -residual[None], missing[None], border
        )
        phi, value = phi + change, value + shift
    left = phi if pencil.symmetric else _left(pencil, value, shape)
    norm = left @ (pencil.derivative(value) @ phi)
    return value, phi, left / norm


def _left(pencil: Pencil, value: complex, shape: np.ndarray) -> np.ndarray:
    """The null vector of A(value)', by one bordered solve."""
    turned = Pencil(pencil.mass.T.tocsr(), pencil.damping.T.tocsr(), pencil.stiffness.T.tocsr())
    row = shape[None]
    pinned = np.array([int(np.abs(shape).argmax())])
    border = Border((pencil.mass @ shape)[None], row, np.zeros((1, 1)), pinned)
    return turned.solve_bordered(value, np.zeros(row.shape), np.ones((1, 1)), border)[0][0]
