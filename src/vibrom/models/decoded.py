"""Displacements of a reduced motion: in memory where few, else on a scratch file.

    q = decode(z),    driven: q = decode(z) + sum_kw beside_w(z, p_k) u_kw

u_k1 is the signal of the load p_k, and u_k2 that of a quarter of a period earlier.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from vibrom.models import samples
from vibrom.models.scratch import room


class Decoder(Protocol):
    """The part of a model that is needed."""

    @property
    def size(self) -> int:
        """n, free displacements."""
        ...

    def decoded(self, coordinates: np.ndarray, dofs: np.ndarray | None = None) -> np.ndarray:
        """Displacements (m, n), or (m, k) at `dofs` [m], of coordinates (m, r)."""
        ...


class Rom(Protocol):
    """The part of a reduced model that is needed."""

    def beside(
        self, z: np.ndarray, p: np.ndarray, dofs: np.ndarray | None = None
    ) -> np.ndarray | None:
        """See `models.rom.Rom.beside`."""
        ...


@dataclass(frozen=True)
class Driven:
    """Displacements of z (m, r) beside which stand u_11, u_12, u_21 .. (m, k w)."""

    model: Decoder
    rom: Rom
    loads: np.ndarray  # (k, n) N per unit of the signal
    signals: int  # k w

    @property
    def size(self) -> int:
        """n, free displacements."""
        return self.model.size

    def decoded(self, coordinates: np.ndarray, dofs: np.ndarray | None = None) -> np.ndarray:
        """See `Decoder.decoded`."""
        r = coordinates.shape[1] - self.signals
        z, signals = coordinates[:, :r], coordinates[:, r:].T
        found = self.model.decoded(z, dofs)
        for load, waves in zip(self.loads, signals.reshape(len(self.loads), -1, len(z))):
            added = self.rom.beside(z, load, dofs)
            if added is not None:
                found = found + np.einsum("wm,wmk->mk", waves, added[: len(waves)])
        return found


def decoded(
    model: Decoder, coordinates: np.ndarray, dofs: np.ndarray | None = None
) -> tuple[Any, float]:
    """Displacements (b, m, n), or (b, m, k) at `dofs`, of coordinates (b, m, r), an array or a
    variable that is sliced; and the seconds that decoding took.
    """
    runs, m, _ = coordinates.shape
    scratch = room(runs, m, model.size) if dofs is None else None
    if scratch is None:
        began = time.perf_counter()
        found = model.decoded(coordinates.reshape(runs * m, -1), dofs)
        return found.reshape(runs, m, -1), time.perf_counter() - began
    seconds, count = 0.0, max(1, samples.BLOCK // (8 * model.size))
    for run in range(runs):
        for first in range(0, m, count):
            began = time.perf_counter()
            found = model.decoded(coordinates[run, first : first + count])
            seconds += time.perf_counter() - began
            scratch.append(run, found)
    return scratch.variable, seconds
