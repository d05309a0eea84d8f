"""What answers a question: a model, full or reduced.

    M a + C v + K q + sum f(q, v) = p u(t) + p_0,    u(t) = amplitude sin(frequency t)

or, of loads with signals of any kind, sum_k p_k u_k(t) in place of p u(t).

An experiment puts the same question to every model, in these words: where the motion starts, what
drives it, at which instants which displacements are wanted. Displacements are measured from the
rest state of the scene.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from vibrom.solvers.periodic.maps import ReturnMap


@dataclass(frozen=True)
class Drive:
    """The signal of the load, one entry for each of b runs."""

    amplitude: np.ndarray  # (b,) of the signal u, in units of the scene's load
    frequency: np.ndarray  # (b,) rad/s

    @property
    def period(self) -> np.ndarray:
        """(b,) [s]."""
        return 2.0 * np.pi / self.frequency


@dataclass(frozen=True)
class Signals:
    """Loads each with a signal of its own. Models take a signal as linear between their steps."""

    load: np.ndarray  # (k, n) N per unit of each signal
    value: Callable[[np.ndarray], np.ndarray]  # instants (m,) [s] -> u (b, k, m) of each run


Push = Drive | Signals | None  # None: left alone


@dataclass(frozen=True)
class Watch:
    """Displacements that are kept, and when."""

    instants: np.ndarray  # (m,) of every run, or (b, m) of each; s after the start, ascending
    dofs: np.ndarray | None = None  # (k,) free displacements; None: all of them


@dataclass(frozen=True)
class Motion:
    """b runs side by side; values after a failure are NaN."""

    # of each watch: (b, m, k) m; large ones of all displacements may be a variable that is decoded,
    # or read from a scratch file, where it is sliced
    displacement: tuple[Any, ...]
    reduced: tuple[np.ndarray, ...] | None  # of each watch: (b, m, r), of a reduced model
    outcome: np.ndarray  # (b,) how each run ended
    failed_at: np.ndarray  # (b,) s, when it failed or first left the training range; NaN: never
    range_ratio: np.ndarray  # (b,) largest reduced coordinate over the largest in the training data
    # (b,) relative error of energy, work and losses (`balance`); None: not known, NaN: not judged
    balance: np.ndarray | None
    seconds: float  # wall time; a first call loads and compiles too, so that jobs make a brief one


class Model(Protocol):
    """The full order and a fitted reduced model alike."""

    @property
    def size(self) -> int:
        """n, free displacements."""
        ...

    @property
    def probes(self) -> np.ndarray:
        """(k,) free displacement that each probe of the scene watches."""
        ...

    @property
    def frequency(self) -> float:
        """Damped first frequency of the scene [rad/s]."""
        ...

    @property
    def samples(self) -> int:
        """Instants of a period at which the model is known without extra cost."""
        ...

    def motion(self, start: np.ndarray, drive: Push, *watches: Watch) -> Motion:
        """From `start` (b, 2n) [m, m/s] at t = 0, driven or left alone."""
        ...

    def coordinates(self, state: np.ndarray) -> np.ndarray:
        """The model's own coordinates (m, r) of `state` (m, 2n) [m, m/s]."""
        ...

    def decoded(self, coordinates: np.ndarray, dofs: np.ndarray | None = None) -> np.ndarray:
        """Displacements (*batch, n), or (*batch, k) at `dofs` [m], of coordinates (*batch, r)."""
        ...

    def eigenvalues(self) -> np.ndarray:
        """Eigenvalues [1/s] of small motions about the rest state."""
        ...

    def return_map(self) -> ReturnMap:
        """What periodic motions under the scene's load are fixed points of."""
        ...
