"""Artefacts larger than memory: their rows are written as they are made.

The file is laid out as `save_dataset` would lay it out, and so is the digest of its content, which
is taken of what was written.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import netCDF4
import numpy as np
import xarray as xr

from vibrom.artefacts import identity
from vibrom.artefacts.data import check
from vibrom.artefacts.files import replacing


class Growing:
    """An artefact whose first dimension is `time` in the variables that are written row by row."""

    def __init__(self, path: Path, sizes: Mapping[str, int], kind: str):
        self.path, self.kind = path, np.dtype(kind)
        self.file = netCDF4.Dataset(path, "w")
        self.file.set_fill_off()  # every row is written
        for name, size in sizes.items():
            self.file.createDimension(name, size)
        self.rounded: dict[str, list[float]] = {}  # largest rounding error, largest value

    def add(self, name: str, units: str, long_name: str) -> None:
        """A variable (time, dof) without rows yet."""
        made = self.file.createVariable(name, self.kind, ("time", "dof"), fill_value=np.nan)
        made.set_auto_mask(False)
        made.units, made.long_name = units, long_name
        self.rounded[name] = [0.0, 0.0]

    def write(self, name: str, first: int, rows: np.ndarray) -> None:
        """`rows` (m, n) from the row `first` on."""
        if not len(rows):
            return
        stored = rows.astype(self.kind, copy=False)
        self.file[name][first : first + len(rows)] = stored
        if self.kind != np.float64:
            largest = np.nanmax(np.abs(stored - rows)), np.nanmax(np.abs(rows))
            self.rounded[name] = [*np.fmax(self.rounded[name], largest)]

    def read(self, name: str, first: int, count: int) -> np.ndarray:
        """Rows (count, n) that were written."""
        return np.asarray(self.file[name][first : first + count], float)

    def finish(self, rest: xr.Dataset, provenance: Mapping[str, str]) -> None:
        """With the other variables and the attributes of the artefact."""
        for name, (error, largest) in self.rounded.items():
            if self.kind != np.float64:
                share = error / largest if largest else 0.0
                self.file[name].rounding = f"{self.kind} stores it to {share:.1e} of its largest"
        self.file.close()
        rest = rest.assign_attrs(provenance)
        encoding = {
            name: {"_FillValue": None}
            for name, array in rest.variables.items()
            if name in rest.coords or array.dtype.kind in "iu"
        }
        rest.to_netcdf(self.path, mode="a", engine="netcdf4", encoding=encoding)
        with xr.open_dataset(self.path, engine="netcdf4", cache=False) as whole:
            check(whole, str(whole.attrs.get("kind")), str(self.path))
            content = identity.content(whole)
        with netCDF4.Dataset(self.path, "a") as file:
            file.content = content


@contextmanager
def growing(path: str | Path, sizes: Mapping[str, int], kind: str, count: int) -> Iterator[Growing]:
    """A file for `count` variables of these sizes that takes its place at `path` once it is
    finished; `kind` is that of its numbers in the file.
    """
    size = count * np.dtype(kind).itemsize * int(np.prod(list(sizes.values())))
    with replacing(path, size) as partial:
        made = Growing(partial, sizes, kind)
        try:
            yield made
        finally:
            if made.file.isopen():
                made.file.close()
