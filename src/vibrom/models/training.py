"""What a method learns from: recorded motion, the structure behind it, and callbacks of a fit."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix


class MethodError(ValueError):
    """A method that cannot be fitted to what it was given; the message names the cure."""


class Unsupported(MethodError):
    """A fitted model has no such guard, integrator or force map: an answer is missing, no error."""


class TrainingDiverged(RuntimeError):
    """The loss became non-finite; says at which epoch."""


@dataclass(frozen=True)
class Trajectory:
    """One decaying motion."""

    time: np.ndarray  # (m,) s
    displacement: np.ndarray  # (m, n) m
    velocity: np.ndarray  # (m, n) m/s
    acceleration: np.ndarray  # (m, n) m/s^2

    @property
    def state(self) -> np.ndarray:
        """X (m, 2n)."""
        return np.concatenate([self.displacement, self.velocity], axis=-1)

    @property
    def rate(self) -> np.ndarray:
        """dx/dt (m, 2n)."""
        return np.concatenate([self.velocity, self.acceleration], axis=-1)


@dataclass(frozen=True)
class Structure:
    """What the scene knows of the body, linearised at rest."""

    mass: csr_matrix  # M (n, n) kg
    damping: csr_matrix  # C (n, n) kg/s
    stiffness: csr_matrix  # K (n, n) N/m
    modes: np.ndarray  # (k, n) kg^-1/2, mass-normalised
    frequencies: np.ndarray  # (k,) rad/s

    def leading(self, count: int, setting: str = "modes") -> np.ndarray:
        """The first `count` modes (count, n); a MethodError names the setting that wants more than
        there are.
        """
        if not 1 <= count <= len(self.modes):
            raise MethodError(
                f"{setting} = {count}: the structure holds {len(self.modes)} modes; "
                f"choose 1 to {len(self.modes)}"
            )
        return self.modes[:count]


class Monitor:
    """Callbacks of a fit; this one does nothing. Steps give one that shows progress and keeps
    checkpoints.
    """

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Marks the time spent on the `mapping` or on the `dynamics`."""
        yield

    def epoch(self, epoch: int, epochs: int, losses: dict[str, float]) -> None:
        """One row of the loss history."""

    def restore(self) -> dict[str, Any] | None:
        """The last state given to `checkpoint`, if a fit was interrupted."""
        return None

    def checkpoint(self, state: dict[str, Any]) -> None:
        """Keep `state` (arrays, numbers, strings) in case the fit is interrupted."""


@dataclass(frozen=True)
class Training:
    """All that a method may learn from; it holds no test data."""

    trajectories: tuple[Trajectory, ...]
    structure: Structure | None = None  # None: data without operators
    seed: int | None = None
    device: str = "cpu"
    start: object = None  # the fitted Rom of the method that this one starts from
    monitor: Monitor = field(default_factory=Monitor)

    def joined(self, what: str) -> np.ndarray:
        """`displacement`, `velocity`, `acceleration`, `state` or `rate` of all trajectories, one
        after the other.
        """
        return np.concatenate([getattr(item, what) for item in self.trajectories])

    def require_structure(self, method: str) -> Structure:
        """The structure, or a MethodError that names the method."""
        if self.structure is None:
            raise MethodError(
                f"{method} needs mass, damping, stiffness and modes, and this training set has "
                "none; use a method that does not"
            )
        return self.structure
