"""Variables that stay on disk until something is read of them.

Their file is open while it is read, and no longer: HDF5 (2.2.0, in netCDF4 1.7.5) follows a pointer
into freed memory when a file with text is opened once more after one of two of its openings was
closed. The element type of the text's fill value, which both share, then still names the file that
was closed (`H5D_get_create_plist`, `H5T__vlen_disk_isnull`). So no file of ours is open twice.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr
from xarray.backends import BackendArray
from xarray.core import indexing

LARGE = 2**25  # bytes; what is smaller is read at once


@dataclass(eq=False)
class OnDisk(BackendArray):
    """A variable of a file, without scale or offset."""

    path: str
    name: str
    shape: tuple[int, ...]
    dtype: np.dtype

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        """What xarray asks for."""
        outer = indexing.IndexingSupport.OUTER
        return indexing.explicit_indexing_adapter(key, self.shape, outer, self._read)

    def _read(self, key: tuple[Any, ...]) -> np.ndarray:
        with netCDF4.Dataset(self.path) as file:
            stored = file[self.name]
            stored.set_auto_maskandscale(False)
            return np.asarray(stored[key])


def large(dataset: xr.Dataset) -> list[str]:
    """Variables that are written a block of rows at a time: they may not be in memory."""
    return [
        str(name)
        for name, array in dataset.data_vars.items()
        if array.nbytes > LARGE and array.dtype.kind == "f" and not array.variable._in_memory
    ]


def add(path: str | Path, variables: Mapping[str, xr.Variable]) -> None:
    """Writes them into the file at `path`."""
    if not variables:
        return
    with netCDF4.Dataset(path, "a") as file:
        file.set_fill_off()  # every row is written
        for name, array in variables.items():
            for dimension, size in array.sizes.items():
                if dimension not in file.dimensions:
                    file.createDimension(dimension, size)
            made = file.createVariable(name, array.dtype, array.dims, fill_value=np.nan)
            made.setncatts(array.attrs)
            rows = max(1, LARGE * len(array) // array.nbytes)
            for first in range(0, len(array), rows):
                made[first : first + rows] = array[first : first + rows].values


def left(dataset: xr.Dataset, path: str | Path) -> xr.Dataset:
    """A dataset that is open at `path`, with its large variables left there and the others read."""
    whole = {
        name: array
        for name, array in dataset.variables.items()
        if array.nbytes <= LARGE or array.dtype.kind not in "iuf"
    }
    read = dataset[list(whole)].load()
    for name in dataset.variables.keys() - whole.keys():
        read[name] = _stored(path, name, dataset.variables[name])
    read.encoding = dataset.encoding
    return read


def let_go(dataset: xr.Dataset, path: str | Path, large: int) -> xr.Dataset:
    """A dataset that was read from `path`, with what is larger than so many bytes left there."""
    stored = {
        name: _stored(path, name, array)
        for name, array in dataset.variables.items()
        if array.nbytes > large and array.dtype.kind in "iuf" and name not in dataset.dims
    }
    return dataset.assign(stored) if stored else dataset


def _stored(path: str | Path, name: Hashable, array: xr.Variable) -> xr.Variable:
    lazy = indexing.LazilyIndexedArray(OnDisk(str(path), str(name), array.shape, array.dtype))
    return xr.Variable(array.dims, lazy, array.attrs, array.encoding, fastpath=True)
