"""What a periodic motion is a fixed point of:  x = H(x, Omega, amplitude).

H carries a point x over a period of the forcing amplitude sin(Omega t), or over half of one where a
symmetry of the body turns the second half into the first. Its derivative along x has the Floquet
multipliers for eigenvalues (of half a period: their roots).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np


@dataclass(frozen=True)
class Return:
    """A point, a period later."""

    end: np.ndarray  # (m,) H(x)
    ok: bool  # did the motion last?
    rough: bool = False  # is it good for a correction only?
    by_start: np.ndarray | None = None  # (m, m) dH/dx
    by_frequency: np.ndarray | None = None  # (m,) dH/dOmega, s
    by_amplitude: np.ndarray | None = None  # (m,) dH/damplitude
    # s = 2/T int p'q sin(Omega t) dt [N m] of the displacement q from rest: what of its first
    # harmonic is in phase with the load; and its derivative (m + 2,) along x, Omega and amplitude
    in_phase: float | None = None
    in_phase_by: np.ndarray | None = None

    @cached_property
    def multipliers(self) -> np.ndarray:
        """Eigenvalues (m,) of dH/dx; NaN where there is none."""
        if self.by_start is None or not np.isfinite(self.by_start).all():
            return np.full(len(self.end), np.nan)
        return np.linalg.eigvals(self.by_start)


@dataclass(frozen=True)
class Swing:
    """The motion over a whole period of the forcing."""

    displacement: np.ndarray  # (k, samples) m, at the probes
    range_ratio: float  # largest coordinate over the largest in training; NaN without a training


@dataclass(frozen=True)
class Opinion:
    """What harmonic balance says of a motion that another way found, with its phase held."""

    displacement: np.ndarray  # (k, samples) m, at the probes
    frequency: float  # rad/s
    harmonics: int  # the highest that is balanced
    # what the first correction with half as many harmonics more changes, to the motion's size
    missed: float


class Equation(Protocol):
    """What the periodic motions of one model under its load solve, H(x, Omega, amplitude) = x."""

    @property
    def size(self) -> int:
        """m, of a point."""
        ...

    @property
    def parts(self) -> int:
        """Maps to a period: 2 where half a period is enough."""
        ...

    @property
    def whole(self) -> Equation:
        """The same with one map to a period, which asymmetric motions need."""
        ...

    @property
    def free(self) -> bool:
        """Does the derivative cost no more than the value?"""
        ...

    def __call__(
        self,
        x: np.ndarray,
        frequency: float,
        amplitude: float,
        derivative: bool = True,
        phase: bool = False,
    ) -> Return:
        """H of x (m,), and, if they are wanted, the derivative, and what is in phase."""
        ...

    def swings(self, x: np.ndarray, frequency: np.ndarray, amplitude: np.ndarray) -> list[Swing]:
        """The motions of points (b, m), each with its frequency (b,) and amplitude (b,)."""
        ...


class ReturnMap(Equation, Protocol):
    """The map over a period."""

    @property
    def frequency(self) -> float:
        """A scale of Omega [rad/s]."""
        ...

    @property
    def load(self) -> np.ndarray:
        """p (n,) [N] per unit of the amplitude."""
        ...

    def of_state(self, state: np.ndarray) -> np.ndarray:
        """The point x (m,) of a state (2n,) [m, m/s] at the beginning of a period."""
        ...

    def state(self, x: np.ndarray) -> np.ndarray:
        """The state (2n,) [m, m/s] of a point x (m,)."""
        ...

    def states(self, x: np.ndarray, frequency: float, amplitude: float) -> np.ndarray:
        """Displacement from rest and velocity (samples, 2n) over a whole period from x (m,)."""
        ...

    def after(self, x: np.ndarray, frequency: float, amplitude: float, periods: int) -> np.ndarray:
        """Where x (m,) is after so many periods; NaN where the motion does not last."""
        ...

    def opinion(
        self, x: np.ndarray, frequency: float, amplitude: float, harmonics: int
    ) -> Opinion | None:
        """A second one of the motion of a point x (m,); None where there is none."""
        ...
