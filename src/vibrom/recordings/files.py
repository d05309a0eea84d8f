"""Files of numbers by the names that they use: text, NumPy, MATLAB and netCDF.

A name is a column's or a variable's; `xData{1,2}` is an entry of a MATLAB cell, counted from one,
and `a.b` a field. A `.npy` file holds one array, called `array`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr
from scipy.io import loadmat
from scipy.sparse import csc_matrix, issparse

from vibrom.artefacts.files import DataError
from vibrom.config.errors import closest
from vibrom.recordings.text import table

# s, of dates in netCDF: `milliseconds since 2024-01-01`
SINCE = {
    "nanoseconds": 1e-9,
    "microseconds": 1e-6,
    "milliseconds": 1e-3,
    "minutes": 60.0,
    "hours": 3600.0,
    "days": 86400.0,
}
DEEPEST = 4  # cells and fields in one another
CELLS = "#refs#"  # where MATLAB 7.3 keeps what is in cells
Arrays = dict[str, np.ndarray]


def read(path: str | Path) -> Arrays:
    """Every array of numbers in a file, by name."""
    path = Path(path)
    if not path.is_file():
        raise DataError(f"{path}: no such file (looked in {Path.cwd()}); correct the path")
    if path.suffix.lower() not in READERS:
        known = ", ".join(READERS)
        raise DataError(f"{path}: files of this kind are not read; save it as one of {known}")
    return _read(path, path.stat().st_mtime_ns)


@cache
def _read(path: Path, changed: int) -> Arrays:
    try:
        found = READERS[path.suffix.lower()](path)
    except DataError:
        raise
    except Exception as error:  # readers of torn files raise whatever they meet
        why = " ".join(str(error).split())[:120]
        raise DataError(f"{path}: cannot be read ({why}); check or save the file again") from error
    if not found:
        raise DataError(f"{path}: holds no numbers; give a file with recorded motion")
    return found


def array(path: str | Path, name: str) -> np.ndarray:
    """The array of this name."""
    found = read(path)
    if name not in found:
        raise DataError(f"{path}: holds no {name!r}; {closest(name, found)}")
    return found[name]


def units(path: str | Path) -> list[str]:
    """Those that a netCDF file gives its variables, in brackets as columns have them."""
    if Path(path).suffix.lower() != ".nc":
        return []
    with xr.open_dataset(path, decode_times=False) as data:
        return [f"({item.attrs.get('units', '')})" for item in data.variables.values()]


def _numpy(path: Path) -> Arrays:
    loaded = np.load(path, allow_pickle=False)
    if isinstance(loaded, np.ndarray):
        return _numbers("array", loaded)
    with loaded:
        parts = [_numbers(name, loaded[name]) for name in loaded.files]
    return {name: value for part in parts for name, value in part.items()}


def _matlab(path: Path) -> Arrays:
    found: Arrays = {}
    try:
        content = loadmat(path)
    except NotImplementedError:  # version 7.3, which is HDF5
        with netCDF4.Dataset(path) as data:
            return _hdf5(data, path)
    for name, value in content.items():
        if not name.startswith("__"):
            found |= _numbers(name, value)
    return found


def _hdf5(group: netCDF4.Dataset, path: Path, prefix: str = "") -> Arrays:
    """Of a MATLAB file of version 7.3: arrays, which it holds transposed, and fields of structures.

    Its cells refer to arrays that have no names, by a type which netCDF does not know.
    """
    found: Arrays = {}
    for name, variable in group.variables.items():
        about = {key: variable.getncattr(key) for key in variable.ncattrs()}
        if about.get("MATLAB_class") != "char" and "MATLAB_empty" not in about:
            found |= _numbers(prefix + name, np.asarray(variable[...]).T)
    for name, part in group.groups.items():
        if name == CELLS and _hdf5(part, path):
            raise DataError(
                f"{path}: holds cells, which are not read from MATLAB 7.3; save it with -v7, or "
                "save the arrays themselves"
            )
        if "MATLAB_sparse" in part.ncattrs():
            entries, row, starts = (part[what][...] for what in ("data", "ir", "jc"))
            shape = (int(part.getncattr("MATLAB_sparse")), len(starts) - 1)
            found[prefix + name] = csc_matrix((entries, row, starts), shape).toarray()
        elif name != CELLS:
            found |= _hdf5(part, path, f"{prefix}{name}.")
    return found


def _netcdf(path: Path) -> Arrays:
    found: Arrays = {}
    with xr.open_dataset(path, decode_times=False) as data:
        for name in data.variables:
            unit, since, _ = str(data[name].attrs.get("units", "")).partition(" since ")
            values = data[name].values * SINCE.get(unit, 1.0) if since else data[name].values
            found |= _numbers(str(name), values)
    return found


def _numbers(name: str, value: Any, depth: int = 0) -> Arrays:
    """The arrays of numbers in a value: itself, or what its cells and fields hold."""
    if issparse(value):
        value = value.toarray()
    if depth > DEEPEST or not isinstance(value, np.ndarray):
        return {}
    found: Arrays = {}
    if value.dtype.names:
        for field in value.dtype.names:
            for place in np.ndindex(value.shape):
                entry = name if value.size == 1 else _entry(name, place)
                found |= _numbers(f"{entry}.{field}", value[field][place], depth + 1)
    elif value.dtype == object:
        for place in np.ndindex(value.shape):
            found |= _numbers(_entry(name, place), value[place], depth + 1)
    elif value.dtype.kind in "fiu" and value.size:
        found[name] = np.asarray(value, float)
    return found


def _entry(name: str, place: tuple[int, ...]) -> str:
    return f"{name}{{{','.join(str(index + 1) for index in place)}}}"


READERS: dict[str, Callable[[Path], Arrays]] = {
    ".csv": table,
    ".tsv": table,
    ".txt": table,
    ".dat": table,
    ".npy": _numpy,
    ".npz": _numpy,
    ".mat": _matlab,
    ".nc": _netcdf,
}
