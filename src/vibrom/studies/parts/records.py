"""Records of equal shape as variables of one dataset."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from vibrom.artefacts.data import variable


class Column(NamedTuple):
    """A variable with one entry a record."""

    units: str
    about: str
    dims: tuple[str, ...] = ()  # of each entry
    missing: Any = np.nan  # what a record has that lacks it; text makes a variable of text


def stacked(
    records: Iterable[Mapping[str, Any]],
    along: Mapping[str, int],
    columns: Mapping[str, Column],
    sizes: Mapping[str, int],
) -> dict[str, xr.Variable]:
    """Name -> variable: the records lie along these dimensions, the last one running fastest, and
    each entry fills its own, whose sizes are given.
    """
    records, found = list(records), {}
    for name, column in columns.items():
        shape = tuple(sizes[dim] for dim in column.dims)
        kind = object if isinstance(column.missing, str) else float
        values = np.empty((len(records), *shape), dtype=kind)
        for place, record in enumerate(records):
            values[place] = record.get(name, column.missing)
        values = values.reshape(*along.values(), *shape)
        if kind is object:  # the words of outcomes
            values = np.array(np.frompyfunc(str, 1, 1)(values), dtype=object)
        found[name] = variable((*along, *column.dims), values, column.units, column.about)
    return found


def text(dim: str, values: Sequence[Any], about: str) -> xr.Variable:
    """A coordinate or variable of words."""
    return variable(dim, np.array([str(value) for value in values], dtype=object), "1", about)
