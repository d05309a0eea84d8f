"""Tables of numbers in text: columns apart by commas, semicolons, tabs or blanks, with decimal
points or commas, below whatever a device writes first.

The columns begin with the first line of numbers. The line above it has their names if it has as
many words, and a line of units in between belongs to them: `Time`, `(ms)` is `Time (ms)`.
"""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from vibrom.config.recorded import METRES, SECONDS

SEPARATORS = (";", "\t", ",", None)  # None: any number of blanks
LOOKED_AT = 20  # last lines, that tell how columns are apart
WIDE = (b"\xff\xfe", b"\xfe\xff")  # the first bytes of UTF-16
COMMENT = "#%"
BRACKETS = re.compile(r"[\[(].*[\])]")


@dataclass(frozen=True)
class Layout:
    """How the columns of a text are apart."""

    separator: str | None
    comma: bool  # decimal commas

    def words(self, line: str) -> list[str]:
        """Of one line, without quotes; what ends in a separator has no word after it."""
        words = [word.strip().strip('"') for word in line.lstrip(COMMENT).split(self.separator)]
        return words[:-1] if words and not words[-1] else words

    def numbers(self, line: str) -> int:
        """How many words of a line there are if all that are there are numbers, else none."""
        words = self.words(line)
        there = [word.replace(",", ".") if self.comma else word for word in words if word]
        return len(words) if there and all(map(_is_number, there)) else 0


def table(path: Path) -> dict[str, np.ndarray]:
    """Columns by name; `column_1` and so on where they have none."""
    raw = path.read_bytes()
    text = raw.decode("utf-16" if raw[:2] in WIDE else "utf-8-sig", errors="replace")
    lines = [line.strip(" ") for line in text.splitlines() if line.strip()]
    data = [place for place, line in enumerate(lines) if line[0] not in COMMENT]
    last = [lines[place] for place in data[-LOOKED_AT:]]
    layout = max(LAYOUTS, key=lambda one: sum(map(one.numbers, last)))
    columns = max(map(layout.numbers, last), default=0)
    first = next((place for place in data if layout.numbers(lines[place]) == columns), 0)
    if not columns:
        return {}
    frame = pd.read_csv(
        io.StringIO("\n".join(lines[place] for place in data if place >= first)),
        sep=layout.separator or r"\s+",
        header=None,
        index_col=False,
        names=list(range(columns)),
        decimal="," if layout.comma else ".",
        skipinitialspace=True,
    )
    frame = frame.apply(pd.to_numeric, errors="coerce").dropna(axis="columns", how="all")
    names = _names(layout, lines[:first], columns)
    return {names[place]: frame[place].to_numpy(float) for place in frame}


def _names(layout: Layout, above: list[str], columns: int) -> list[str]:
    """Of the columns, from the lines above them."""
    rows = [layout.words(line) for line in above[-2:]]
    rows = [row if len(row) == columns else [] for row in rows]
    found = [f"column_{place + 1}" for place in range(columns)]
    if rows and rows[-1]:
        found = rows[-1]
        if len(rows) == 2 and rows[0] and all(map(_is_unit, found)):
            found = [f"{name} ({unit.strip('()[]')})" for name, unit in zip(*rows)]
    return [
        name if name and name not in found[:place] else f"{name or 'column'}_{place + 1}"
        for place, name in enumerate(found)
    ]


def _is_unit(word: str) -> bool:
    return not word or word in SECONDS or word in METRES or bool(BRACKETS.fullmatch(word))


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


LAYOUTS = [Layout(separator, comma) for comma in (False, True) for separator in SEPARATORS]
