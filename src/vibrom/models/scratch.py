"""Displacements of motions that are larger than memory: they go to a scratch file while they are
integrated or decoded, and are read where they are sliced.

The file has no name and goes with what reads it. It lies in the folder for such files, which
`TMPDIR` names.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from dataclasses import dataclass, field
from typing import IO, Any

import numpy as np
import xarray as xr
from xarray.backends import BackendArray
from xarray.core import indexing

from vibrom.artefacts.hardware import GIB, TooLarge
from vibrom.models import samples


@dataclass(eq=False)
class OnScratch(BackendArray):
    """Displacements (b, m, n) [m]; a `Sink` of those from `rest`."""

    shape: tuple[int, int, int]
    rest: np.ndarray | float  # (n,) m
    file: IO[bytes] = field(default_factory=tempfile.TemporaryFile)
    done: dict[int, int] = field(default_factory=dict)  # rows of each run
    dtype = np.dtype(float)

    def see(
        self, steps: np.ndarray, where: slice, q: np.ndarray, v: np.ndarray, a: np.ndarray
    ) -> None:
        """See `Sink`."""
        for run in range(where.start, where.stop):
            self.append(run, q[:, :, run - where.start] - self.rest)

    def append(self, run: int, rows: np.ndarray) -> None:
        """The next rows (k, n) of a run."""
        first = self.done.get(run, 0)
        self.file.seek(self._place(run, first))
        self.file.write(np.ascontiguousarray(rows).data)
        self.file.flush()
        self.done[run] = first + len(rows)

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        """What xarray asks for."""
        outer = indexing.IndexingSupport.OUTER
        return indexing.explicit_indexing_adapter(key, self.shape, outer, self._read)

    def _read(self, key: tuple[Any, ...]) -> np.ndarray:
        runs, rows, columns = key
        wanted = (np.arange(size)[part] for size, part in zip(self.shape, (runs, rows)))
        chosen, numbers = map(np.atleast_1d, wanted)
        found = np.stack([self._rows(run, numbers, columns) for run in chosen.tolist()])
        if isinstance(rows, int | np.integer):
            found = found[:, 0]
        return found[0] if isinstance(runs, int | np.integer) else found

    def _rows(self, run: int, numbers: np.ndarray, columns: Any) -> np.ndarray:
        """Some columns of the rows (k,) of a run, of which a few are in memory whole."""
        n, some = self.shape[2], max(1, samples.BLOCK // (8 * self.shape[2]))
        found = [np.empty((0, n))[:, columns]]
        near = np.split(numbers, 1 + np.flatnonzero(np.diff(numbers // some)))
        for part in near if len(numbers) else []:
            low, high = int(part.min()), int(part.max()) + 1
            # At its place, not at the file's own, which threads and forks share.
            read = os.pread(self.file.fileno(), 8 * n * (high - low), self._place(run, low))
            found.append(np.frombuffer(read).reshape(-1, n)[part - low][:, columns])
        return np.concatenate(found)

    def _place(self, run: int, row: int) -> int:
        return 8 * self.shape[2] * (run * self.shape[1] + row)

    @property
    def variable(self) -> xr.Variable:
        """As a variable that is sliced."""
        return xr.Variable(("run", "time", "dof"), indexing.LazilyIndexedArray(self))


def room(runs: int, count: int, n: int, rest: np.ndarray | float = 0.0) -> OnScratch | None:
    """For `count` rows of each of so many runs of n displacements; None where memory holds them
    easily.
    """
    size = 8 * runs * count * n
    if size <= samples.BLOCK:
        return None
    folder = tempfile.gettempdir()
    free = shutil.disk_usage(folder).free
    if size > free:
        raise TooLarge(
            f"the motion of {runs} x {n} displacements takes {size / GIB:.3g} GiB of a "
            f"scratch file, and {free / GIB:.3g} GiB are free in {folder}; set TMPDIR to a folder "
            "of a larger disk, or lower periods, steps_per_period or body.cells"
        )
    return OnScratch((runs, count, n), rest)
