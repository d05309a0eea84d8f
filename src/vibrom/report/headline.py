"""The numbers to look at first: errors beside the thesis's, what they cost, and where everything lies."""

import io

import pandas as pd
from rich.console import Console
from rich.table import Table

from vibrom.report import thesis
from vibrom.report.collection import FULL_ORDER
from vibrom.report.presentation import GONE, number

OFFLINE = ["generate_training_data_s", "obtain_mapping_s", "obtain_dynamics_s"]


def errors(table: pd.DataFrame) -> pd.DataFrame:
    """One row a model, one column a case: `median (thesis)`, or the outcome where the median seed failed."""
    ours = table[table["method"] != FULL_ORDER]
    cells = {}
    for _, row in ours.iterrows():
        printed = row["thesis_outcome"]
        verdict = printed if isinstance(printed, str) and printed else number(row["thesis_percent"], 3)
        ended = str(row["outcome"]).replace("_", " ")
        value = number(row["nmte_percent"], 3) if pd.notna(row["nmte_percent"]) else ended
        cells[(row["method"], row["case"])] = value if verdict == GONE else f"{value} ({verdict})"
    return grid(ours, cells)


def costs(table: pd.DataFrame) -> pd.DataFrame:
    """One row a model, one column a case: offline seconds (data, mapping, dynamics), and the speed-up of one decay."""
    full = table[table["method"] == FULL_ORDER].set_index("case")["decay_s"]
    ours = table[table["method"] != FULL_ORDER]
    cells = {}
    for _, row in ours.iterrows():
        offline = row[OFFLINE].astype(float)
        speed = float(full.get(row["case"], float("nan"))) / row["decay_s"] if row["decay_s"] else float("nan")
        cells[(row["method"], row["case"])] = (
            f"{number(float(offline.sum()), 3) if offline.notna().any() else GONE} s, "
            f"{number(float(speed), 2) if pd.notna(speed) else GONE} x"
        )
    return grid(ours, cells)


def grid(ours: pd.DataFrame, cells: dict) -> pd.DataFrame:
    cases, methods = list(dict.fromkeys(ours["case"])), list(dict.fromkeys(ours["method"]))
    rows = [[thesis.label(method), *(cells.get((method, case), GONE) for case in cases)] for method in methods]
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
    for what, where in places.items():
        console.print(f"{what:<10}{where}", highlight=False, soft_wrap=True)


def text(tables: dict[str, pd.DataFrame], places: dict[str, str]) -> str:
    """The same without colours, 100 columns wide."""
    out = io.StringIO()
    show(tables, places, Console(file=out, width=100, color_system=None))
    return "\n".join(line.rstrip() for line in out.getvalue().splitlines()) + "\n"
