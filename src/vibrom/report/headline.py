"""The numbers to look at first: errors beside the thesis's, what they cost, and where everything
lies.
"""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np
import pandas as pd
from rich.console import Console
from rich.table import Table as Grid

from vibrom.artefacts.outcome import Outcome, Tally
from vibrom.report.collection import FULL_ORDER
from vibrom.report.columns import GONE, Row, missing, number
from vibrom.report.scores import offline
from vibrom.report.table import Table
from vibrom.thesis.labels import label

FOOTNOTE = "* outside the range of its training data"
TABLES = ("decay", "forced", "folds", "run_times", "checks")  # that the headline is made of
WIDTH = 100


def grid(rows: Sequence[Row], cell: Callable[[Row], str]) -> pd.DataFrame:
    """One row a method, one column a case."""
    ours = [row for row in rows if row["method"] != FULL_ORDER]
    cells = {(row["method"], row["case"]): cell(row) for row in ours}
    cases, methods = (dict.fromkeys(row[name] for row in ours) for name in ("case", "method"))
    lines = [
        [label(method), *(cells.get((method, case), GONE) for case in cases)] for method in methods
    ]
    return pd.DataFrame(lines, columns=["Model", *cases])


def error(row: Row) -> str:
    """`median (thesis)`, or the outcome where the median seed failed."""
    if missing(row["nmte_percent"]):
        return str(row["outcome"]).replace("_", " ") + beside(row)
    star, note = ending(row["outcome"])
    return f"{number(row['nmte_percent'], 3)}{star}{beside(row)}{note}"


def beside(row: Row) -> str:
    """` (thesis)`; empty where it has no number."""
    thesis = row["thesis_outcome"] or number(row["thesis_percent"], 3)
    return "" if thesis == GONE else f" ({thesis})"


def ending(tally: Tally) -> tuple[str, str]:
    """A star where every seed with a value left its training range, and how many seeds ended
    otherwise than `ok`.
    """
    total, left, well = tally.total(), tally[Outcome.LEFT_RANGE], tally[Outcome.OK]
    others = [one for one in tally if one not in (Outcome.LEFT_RANGE, Outcome.OK)]
    notes = [f"{tally[one]} of {total} {one.replace('_', ' ')}" for one in others]
    notes += [f"{left} of {total}*"] if left and well else []
    return "*" if left and not well else "", f" {', '.join(notes)}" if notes else ""


def folds(row: Row) -> str:
    """How many seeds have the full order's folds, and the error of the highest point."""
    peak = number(row["peak_error_percent"], 3)
    return f"{row['alike']} of {row['seeds']}{'' if peak == GONE else f', {peak}'}"


def cost(rows: Sequence[Row]) -> Callable[[Row], str]:
    """Offline seconds (data, mapping, dynamics), and the speed-up of one decay."""
    full = {row["case"]: row["decay_s"] for row in rows if row["method"] == FULL_ORDER}

    def cell(row: Row) -> str:
        speed = full.get(row["case"], np.nan) / row["decay_s"] if row["decay_s"] else np.nan
        return f"{number(offline(row), 3)} s, {number(speed, 2)} x"

    return cell


def checks(rows: Iterable[Row]) -> list[str]:
    """How many promises are kept, and the names of the others."""
    met = Counter(row["met"] for row in rows)
    unmet = [row for row in rows if row["met"] == "no"]
    left = [
        (row["case"], row["method"], row["source"])
        for row in rows
        if row["met"] not in ("yes", "no")
    ]
    count = met["yes"] + met["no"]
    lines = [f"{met['yes']} of {count} met"] if count else []
    lines += [f"{case}, {label(method)}: not compared, {why}" for case, method, why in left]
    return [
        *(f"{'' if index else 'Checks':<10}{line}" for index, line in enumerate(lines)),
        *(
            f"{'not met':<10}{row['case']}, {label(row['method'])}: {row['quantity']} "
            f"{number(row['value'], 6)} (bound {row['bound']})"
            for row in unmet
        ),
    ]


def sections(tables: Mapping[str, Table]) -> dict[str, pd.DataFrame]:
    """Title -> table, of the tables that the run has and in which a method was asked something."""
    rows = {name: made.rows for name, made in tables.items()}
    known = any(beside(row) for name in ("decay", "forced") for row in rows.get(name, []))
    thesis = " (thesis)" if known else ""
    made = {
        f"Decay: NMTE in %, median over seeds{thesis}": ("decay", error),
        f"Forced run, last period: NMTE in %, median over seeds{thesis}": ("forced", error),
        "Response curve: seeds with the full order's folds, error of the peak in %": (
            "folds",
            folds,
        ),
        "Cost: offline seconds, speed-up of one decay over the full order": (
            "run_times",
            cost(rows.get("run_times", [])),
        ),
    }
    grids = {title: grid(rows.get(name, []), cell) for title, (name, cell) in made.items()}
    return {title: frame for title, frame in grids.items() if asked(frame)}


def asked(frame: pd.DataFrame) -> bool:
    """Does a cell say more than that there was nothing to say? A method that does not go with a
    scene is skipped there whatever is asked.
    """
    cells = frame.iloc[:, 1:].to_numpy(str).ravel()
    said = [cell for cell in cells if not cell.startswith(("not run", GONE))]
    return bool(said) and (len(said) == len(cells) or set(said) != {"skipped"})


def show(tables: Mapping[str, Table], places: dict[str, str], console: Console) -> None:
    """Print it."""
    made = sections(tables)
    for title, frame in made.items():
        console.print(title, style="bold", highlight=False)
        table = Grid(header_style="", pad_edge=False, show_edge=False)
        for index, column in enumerate(frame.columns):
            table.add_column(str(column), justify="left" if index == 0 else "right")
        for row in frame.itertuples(index=False):
            table.add_row(*row)
        console.print(table)
        console.print()
    if any("*" in cell for frame in made.values() for cell in frame.to_numpy().ravel()):
        console.print(FOOTNOTE, "\n", sep="", highlight=False)
    for line in checks(tables["checks"].rows) if "checks" in tables else []:
        console.print(line, highlight=False, markup=False)
    for what, where in places.items():
        console.print(f"{what:<10}{where}", highlight=False, soft_wrap=True)


def text(tables: Mapping[str, Table], places: dict[str, str]) -> str:
    """The same without colours."""
    out = io.StringIO()
    show(tables, places, Console(file=out, width=WIDTH, color_system=None))
    return "\n".join(line.rstrip() for line in out.getvalue().splitlines()) + "\n"
