"""What a method learns from: recorded motion, the structure behind it, and callbacks of a fit."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.sparse import csr_matrix, identity

from vibrom.models.samples import Samples

if TYPE_CHECKING:
    from vibrom.term import Term


class MethodError(ValueError):
    """A method that cannot be fitted to what it was given; the message names the cure."""


class Unsupported(MethodError):
    """A fitted model has no such guard, integrator or force map: an answer is missing, no error."""


class Underdetermined(MethodError):
    """The data do not determine what is fitted to them; the message has the numbers."""


class TrainingDiverged(RuntimeError):
    """The loss became non-finite; says at which epoch."""


BOTH = {"state": ("displacement", "velocity"), "rate": ("velocity", "acceleration")}


@dataclass(frozen=True)
class Trajectory:
    """One decaying motion: arrays, or variables of a file that are read where they are sliced."""

    time: np.ndarray  # (m,) s
    displacement: Any  # (m, n) m
    velocity: Any  # (m, n) m/s
    acceleration: Any  # (m, n) m/s^2

    def part(self, samples: slice) -> Trajectory:
        """Some of the samples."""
        return Trajectory(
            self.time[samples],
            self.displacement[samples],
            self.velocity[samples],
            self.acceleration[samples],
        )

    def columns(self, what: str) -> tuple[Any, ...]:
        """What stands side by side: one of displacement, velocity and acceleration, or both of a
        `state` or a `rate`.
        """
        return tuple(getattr(self, name) for name in BOTH.get(what, (what,)))

    @property
    def state(self) -> np.ndarray:
        """Displacement, then velocity (m, 2n)."""
        return np.concatenate(self.columns("state"), axis=-1)

    @property
    def rate(self) -> np.ndarray:
        """Velocity, then acceleration (m, 2n)."""
        return np.concatenate(self.columns("rate"), axis=-1)


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


class Monitor(ABC):
    """The clock of a fit, and callbacks while it runs."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}  # wall time of each phase that has ended
        self._began: dict[str, float] = {}  # instant at which a running phase began

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Adds to the time of a phase: `mapping` or `dynamics`, which a method marks, or `total`,
        which `Method.learn` marks.
        """
        self._began[name] = perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.spent(name)
            del self._began[name]

    def spent(self, name: str) -> float:
        """Seconds of a phase until now."""
        running = perf_counter() - self._began[name] if name in self._began else 0.0
        return self.seconds.get(name, 0.0) + running

    @abstractmethod
    def epoch(self, epoch: int, epochs: int, losses: dict[str, float]) -> None:
        """One row of the loss history."""

    @abstractmethod
    def restore(self) -> dict[str, Any] | None:
        """The last state given to `checkpoint`, if a fit was interrupted."""

    @abstractmethod
    def checkpoint(self, state: dict[str, Any]) -> None:
        """Keep `state` (arrays, numbers, strings) in case the fit is interrupted."""


class Clock(Monitor):
    """Times the phases and does nothing else."""

    def epoch(self, epoch: int, epochs: int, losses: dict[str, float]) -> None:
        """See Monitor."""

    def restore(self) -> None:
        """See Monitor."""

    def checkpoint(self, state: dict[str, Any]) -> None:
        """See Monitor."""


@dataclass(frozen=True)
class Training:
    """All that a method may learn from; it holds no test data."""

    trajectories: tuple[Trajectory, ...]
    structure: Structure | None = None  # None: data without operators
    seed: int | None = None
    device: str = "cpu"
    start: object = None  # the fitted Rom of the method that this one starts from
    monitor: Monitor = field(default_factory=Clock)
    term: Term | None = None  # the equations of motion, for methods that ask for them

    def __post_init__(self) -> None:
        if self.term is not None and not self.trajectories:
            return
        if self.joined("displacement").all(lambda block: block == 0.0):
            raise MethodError(
                "the training data hold no motion: every displacement is zero; release the body "
                "away from rest, or list an effect that brings a load"
            )
        if not self.joined("acceleration").all(np.isfinite):
            raise MethodError("the training data are not finite; leave out what is not")

    def joined(self, what: str) -> Samples:
        """`displacement`, `velocity`, `acceleration`, `state` or `rate` of all trajectories, one
        after the other.
        """
        return Samples(tuple(item.columns(what) for item in self.trajectories))

    @property
    def mass(self) -> csr_matrix:
        """M (n, n); one where it is not known, and loads are accelerations."""
        if self.structure is not None:
            return self.structure.mass
        return identity(self.joined("displacement").shape[1], format="csr")

    def require_structure(self, method: str) -> Structure:
        """The structure; Unsupported, with the name of the method, where there is none."""
        if self.structure is None:
            raise Unsupported(
                f"{method} needs mass, damping, stiffness and modes, and this training set has "
                "none; use a method that does not"
            )
        return self.structure
