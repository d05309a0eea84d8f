"""Columns of tables: a name for the .csv, a heading with its unit, and how a cell is printed.

The .csv has every column at full precision. Printed are those with a heading: numbers with four
digits, median and range over seeds in one cell.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from vibrom.report.scores import Spread
from vibrom.thesis.labels import label

GONE = "–"
PUBLISHED = "thesis_"  # how the names of its numbers begin
Row = Mapping[str, Any]


@dataclass(frozen=True)
class Column:
    """One value of a row."""

    name: str  # in the .csv, with its unit
    heading: str = ""  # where it is printed, with its unit; empty: it is only in the .csv
    digits: int = 4
    whole: bool = False  # a whole number
    spread: bool = False  # a median over seeds: `<name>_min` and `<name>_max` stand beside it
    optional: bool = False  # left out of tables in which no row has it
    text: Callable[[Row], str] | None = None  # how the cell is printed; None: the number

    @property
    def names(self) -> list[str]:
        """In the .csv."""
        return [self.name, f"{self.name}_min", f"{self.name}_max"] if self.spread else [self.name]

    def shown(self, rows: Iterable[Row]) -> bool:
        """Is it printed? A number of the thesis is where some row has one."""
        known = not self.name.startswith(PUBLISHED) or any(self.cell(row) != GONE for row in rows)
        return bool(self.heading) and known

    def cell(self, row: Row) -> str:
        """As it is printed."""
        if self.text:
            return self.text(row)
        if self.spread:
            return over_seeds(Spread(*(row[name] for name in self.names)), self.digits)
        return number(row[self.name], self.digits)


def number(value, digits: int = 4) -> str:
    """Significant digits, without exponents where they are not needed; words as they are."""
    if missing(value):
        return GONE
    if isinstance(value, float | np.floating):
        size = abs(value)
        if value == 0:
            return "0"
        if size >= 1e6 or size < 1e-4:
            return f"{value:.{digits - 1}e}"
        return f"{value:.{max(0, digits - 1 - int(np.floor(np.log10(size))))}f}"
    return str(value)


def as_given(value) -> str:
    """A number with six digits at most, as people give it; words as they are."""
    if missing(value):
        return GONE
    return f"{value:.6g}" if isinstance(value, float | np.floating) else str(value)


def missing(value) -> bool:
    """Is there no value, or no finite number?"""
    return value is None or value is pd.NA or (isinstance(value, float) and np.isnan(value))


def over_seeds(values: Spread, digits: int = 4) -> str:
    """`median (min to max)`; the range only where seeds differ."""
    middle, low, high = values
    median = number(middle, digits)
    if missing(low) or low == high:
        return median
    top = "failed" if missing(high) else number(high, digits)
    return f"{median} ({number(low, digits)} to {top})"


def with_change(value: str, percent: float) -> str:
    """`0.3563 (+62 %)`; nothing beside a value that changes by less than 0.005 %."""
    if missing(percent) or abs(percent) < 0.005:
        return value
    return f"{value} ({percent:+.0f} %)" if abs(percent) >= 10 else f"{value} ({percent:+.2g} %)"


def published(name: str, heading: str) -> Column:
    """A number of the thesis, as it is printed there."""
    return Column(name, heading, text=lambda row: as_given(row[name]))


def hidden(*names: str) -> tuple[Column, ...]:
    """Columns of the .csv alone."""
    return tuple(Column(name) for name in names)


CASE = Column("case", "Case")
METHOD = Column("method", "Model", text=lambda row: label(row["method"]))
SEEDS = Column("seeds", "Seeds", whole=True)
OUTCOME = Column("outcome", "Outcome")
