"""Displacements of a reduced motion: at once where few, else decoded where they are sliced.

q = decode(z)
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
