"""What an integration keeps, and what it returns."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from vibrom.artefacts.hardware import check_memory
from vibrom.artefacts.outcome import Outcome


class Sink(Protocol):
    """Takes whole states while they are integrated, so that they need not be kept."""

    def see(
        self, steps: np.ndarray, where: slice, q: np.ndarray, v: np.ndarray, a: np.ndarray
    ) -> None:
        """Displacement, velocity and acceleration (m, n, states) of these steps (m,), of the states
        `where` of the motion; each step once, in order.
        """


class Observer(Sink, Protocol):
    """Says itself which steps it sees."""

    @property
    def apart(self) -> int:
        """Steps between two that it sees, step 0 among them."""


@dataclass(frozen=True)
class Record:
    """What to keep: all displacements at some steps, some displacements at all of them."""

    every: int = 1  # keep the whole state at every n-th step,
    start: int = 0  # from this step on
    # (k,) free displacements that are kept at every step,
    probes: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))
    probe_start: int = 0  # from this step on
    observer: Observer | None = None
    sink: Sink | None = None  # sees the kept states, and the motion then holds none

    def check(self, n: int) -> None:
        """Raises ValueError where it asks for what a body of n displacements has not."""
        if min(self.every, self.start + 1, self.probe_start + 1) < 1:
            raise ValueError(
                f"record: every = {self.every}, start = {self.start}, probe_start = "
                f"{self.probe_start}; needed are every >= 1 and starts >= 0"
            )
        outside = [int(dof) for dof in self.probes if not 0 <= dof < n]
        if outside:
            raise ValueError(f"record.probes has {outside[0]}; needed are dofs from 0 to {n - 1}")

    def count(self, steps: int) -> int:
        """Whole states that are kept of so many steps."""
        return len(range(self.start, steps + 1, self.every))

    def allocate(self, n: int, states: int, steps: int) -> Motion:
        """A motion without values yet."""
        kept = np.arange(self.start, steps + 1, self.every)
        count = len(kept) if self.sink is None else 0
        watched = max(steps + 1 - self.probe_start, 0)
        check_memory(
            8.0 * states * (3 * count * n + len(self.probes) * watched),
            f"the motion of {states} x {n} displacements over {steps} steps",
            "lower periods, steps_per_period or body.cells",
        )
        displacement, velocity, acceleration = np.full((3, states, count, n), np.nan)
        return Motion(
            kept=kept,
            displacement=displacement,
            velocity=velocity,
            acceleration=acceleration,
            probes=np.full((states, len(self.probes), watched), np.nan),
            failed_at=np.full(states, np.nan),
        )


@dataclass
class Motion:
    """The motion of several states side by side; all is NaN from a failure on."""

    kept: np.ndarray  # (m,) numbers of the steps at which whole states are kept
    displacement: np.ndarray  # (states, m, n) m
    velocity: np.ndarray  # (states, m, n) m/s
    acceleration: np.ndarray  # (states, m, n) m/s^2
    probes: np.ndarray  # (states, k, steps + 1 - probe_start) m
    failed_at: np.ndarray  # (states,) s, where Newton's iteration did not converge; NaN: nowhere
    # wall time of the steps, without compilation and what sinks and observers take
    seconds: float = 0.0
    iterations: int = 0  # of Newton, all batches added up
    factorisations: int = 0  # likewise

    @property
    def outcomes(self) -> list[Outcome]:
        """How each state ended."""
        failed = ~np.isnan(self.failed_at)
        return [Outcome.NO_CONVERGENCE if it else Outcome.OK for it in failed]
