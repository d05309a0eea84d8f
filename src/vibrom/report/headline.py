"""The numbers to look at first: errors beside the thesis's, what they cost, and where everything
lies.
"""

import io

import pandas as pd
from rich.console import Console
from rich.table import Table

from vibrom.report.collection import FULL_ORDER
from vibrom.report.presentation import GONE, number
from vibrom.thesis import published as thesis

FOOTNOTE = "* outside the range of its training data"
OFFLINE = ["generate_training_data_s", "obtain_mapping_s", "obtain_dynamics_s"]


def errors(table: pd.DataFrame) -> pd.DataFrame:
    """One row a model, one column a case: `median (thesis)`, or the outcome where the median seed
    failed.
    """
    ours = table[table["method"] != FULL_ORDER]
    cells = {}
    for _, row in ours.iterrows():
        printed = row["thesis_outcome"]
        verdict = (
            printed if isinstance(printed, str) and printed else number(row["thesis_percent"], 3)
        )
        value, star, mark = str(row["outcome"]).replace("_", " "), "", ""
        if pd.notna(row["nmte_percent"]):
            value, (star, mark) = number(row["nmte_percent"], 3), ending(str(row["outcome"]))
        printed = "" if verdict == GONE else f" ({verdict})"
        cells[(row["method"], row["case"])] = f"{value}{star}{printed}{mark}"
    return grid(ours, cells)


def ending(tally: str) -> tuple[str, str]:
    """A star where every seed with a value left its training range, and how many seeds ended
    otherwise than `ok`.
    """
    counts = {}
    for part in tally.split(", "):
        word, _, count = part.rpartition(" ")
        counts[word if count.isdigit() else part] = int(count) if count.isdigit() else 1
    total, left, well = sum(counts.values()), counts.pop("left_range", 0), counts.pop("ok", 0)
    marks = [f"{count} of {total} {word.replace('_', ' ')}" for word, count in counts.items()]
    marks += [f"{left} of {total}*"] if left and well else []
    return "*" if left and not well else "", f" {', '.join(marks)}" if marks else ""


def checks(table: pd.DataFrame) -> list[str]:
    """How many promises are kept, and the names of the others."""
    unmet = table[table["met"] != "yes"]
    named = [
        f"{row.case}, {thesis.label(row.method)}: {row.quantity} {number(row.value, 6)} (bound {row.bound})"
        for row in unmet.itertuples()
    ]
    return [
        f"{'Checks':<10}{len(table) - len(unmet)} of {len(table)} met",
        *(f"{'not met':<10}{name}" for name in named),
    ]


def costs(table: pd.DataFrame) -> pd.DataFrame:
    """One row a model, one column a case: offline seconds (data, mapping, dynamics), and the
    speed-up of one decay.
    """
    full = table[table["method"] == FULL_ORDER].set_index("case")["decay_s"]
    ours = table[table["method"] != FULL_ORDER]
    cells = {}
    for _, row in ours.iterrows():
        offline = row[OFFLINE].astype(float)
        speed = (
            float(full.get(row["case"], float("nan"))) / row["decay_s"]
            if row["decay_s"]
            else float("nan")
        )
        cells[(row["method"], row["case"])] = (
            f"{number(float(offline.sum()), 3) if offline.notna().any() else GONE} s, "
            f"{number(float(speed), 2) if pd.notna(speed) else GONE} x"
        )
    return grid(ours, cells)


def grid(ours: pd.DataFrame, cells: dict) -> pd.DataFrame:
    cases, methods = list(dict.fromkeys(ours["case"])), list(dict.fromkeys(ours["method"]))
    rows = [
        [thesis.label(method), *(cells.get((method, case), GONE) for case in cases)]
        for method in methods
    ]
    return pd.DataFrame(rows, columns=["Model", *cases])


def sections(tables: dict[str, pd.DataFrame]) -> dict[str, pd.DataFrame]:
    """Title -> table, of the tables that the run has."""
    made = {
        "Decay: NMTE in %, median over seeds (thesis)": ("decay", errors),
        "Forced run, last period: NMTE in %, median over seeds (thesis)": ("forced", errors),
        "Cost: offline seconds, speed-up of one decay over the full order": ("run_times", costs),
    }
    return {title: build(tables[name]) for title, (name, build) in made.items() if name in tables}


def show(tables: dict[str, pd.DataFrame], places: dict[str, str], console: Console) -> None:
    for title, frame in sections(tables).items():
        console.print(title, style="bold", highlight=False)
        table = Table(header_style="", pad_edge=False, show_edge=False)
        for index, column in enumerate(frame.columns):
            table.add_column(str(column), justify="left" if index == 0 else "right")
        for row in frame.itertuples(index=False):
            table.add_row(*row)
        console.print(table)
        console.print()
    if any(
        "*" in str(cell) for frame in sections(tables).values() for cell in frame.to_numpy().ravel()
    ):
        console.print(FOOTNOTE, "\n", sep="", highlight=False)
    for line in checks(tables["checks"]) if "checks" in tables else []:
        console.print(line, highlight=False, markup=False)
    for what, where in places.items():
        console.print(f"{what:<10}{where}", highlight=False, soft_wrap=True)


def text(tables: dict[str, pd.DataFrame], places: dict[str, str]) -> str:
    """The same without colours, 100 columns wide."""
    out = io.StringIO()
    show(tables, places, Console(file=out, width=100, color_system=None))
    return "\n".join(line.rstrip() for line in out.getvalue().splitlines()) + "\n"
