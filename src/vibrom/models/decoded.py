"""Displacements of a reduced motion: at once where few, else decoded where they are sliced.

    q = decode(z),    driven: q = decode(z) + sum_kw beside_w(z, p_k) u_kw

u_k1 is the signal of the load p_k, and u_k2 that of a quarter of a period earlier.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import xarray as xr
from xarray.backends import BackendArray
from xarray.core import indexing

from vibrom.models import samples


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


@dataclass(eq=False)
class Decoded(BackendArray):
    """Displacements (m, n) [m] of coordinates (m, r)."""

    model: Decoder
    coordinates: np.ndarray  # (m, r)
    dtype = np.dtype(float)

    @property
    def shape(self) -> tuple[int, int]:
        """(m, n)."""
        return len(self.coordinates), self.model.size

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        """What xarray asks for."""
        outer = indexing.IndexingSupport.OUTER
        return indexing.explicit_indexing_adapter(key, self.shape, outer, self._decode)

    def _decode(self, key: tuple[Any, ...]) -> np.ndarray:
        rows, columns = key
        some = np.atleast_2d(self.coordinates[rows])
        every = isinstance(columns, slice) and columns == slice(0, self.shape[1], 1)
        dofs = None if every else np.atleast_1d(np.arange(self.shape[1])[columns])
        found = self.model.decoded(some, dofs)
        found = found[0] if isinstance(rows, int | np.integer) else found
        return found[..., 0] if isinstance(columns, int | np.integer) else found


def decoded(model: Decoder, coordinates: np.ndarray) -> Any:
    """Displacements (time, dof) of coordinates (m, r), an array or a variable that is sliced; all
    have been decoded once, so that the time it takes is that of an answer.
    """
    if 8 * len(coordinates) * model.size <= samples.BLOCK:
        return model.decoded(coordinates)
    lazy = indexing.LazilyIndexedArray(Decoded(model, coordinates))
    found = xr.Variable(("time", "dof"), lazy)
    for _ in samples.rows(found):
        pass
    return found
