"""A table as it is written: the rows of the .csv, and the same for reading, as HTML and LaTeX."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import NamedTuple

import pandas as pd
from jinja2 import Environment, FunctionLoader
from markupsafe import Markup, escape

from vibrom.artefacts.outcome import Outcome, Severity, Tally
from vibrom.report.collection import FULL_ORDER
from vibrom.report.columns import GONE, Column, Row, as_given, missing

FAILED, REFERENCE = "failed", "reference"  # marks of rows, classes of the style sheet
IDENTITY = ("case", "method", "outcome")


class Printed(NamedTuple):
    """A table for reading, all text."""

    head: list[str]
    lines: list[list[str]]
    marks: list[str]  # of each line: failed, reference or none

    @property
    def frame(self) -> pd.DataFrame:
        """The same without marks."""
        return pd.DataFrame(self.lines, columns=self.head)


@dataclass(frozen=True)
class Table:
    """Rows with numbers as numbers and outcomes as outcomes."""

    name: str
    columns: tuple[Column, ...]
    rows: Sequence[Row]
    printed: Printed

    @property
    def frame(self) -> pd.DataFrame:
        """What the .csv holds."""
        return pd.DataFrame(
            {
                name: pd.array([row.get(name) for row in self.rows], dtype="Int64")
                if column.whole
                else [row.get(name) for row in self.rows]
                for column in self.columns
                for name in column.names
            }
        )


def table(
    name: str,
    columns: Sequence[Column],
    rows: Sequence[Row],
    shown: Callable[[Sequence[Row], Sequence[Column]], Printed],
) -> Table:
    """A table of these rows; every value has a column, and every row all of them."""
    kept = tuple(
        column
        for column in columns
        if not column.optional or any(not missing(row.get(column.name)) for row in rows)
    )
    names = [name for column in columns for name in column.names]
    unknown = sorted({key for row in rows for key in row} - set(names))
    if unknown or len(set(names)) < len(names):
        raise ValueError(f"table {name}: each of {', '.join(unknown or names)} needs one column")
    full = [dict.fromkeys(names, float("nan")) | dict(row) for row in rows]
    return Table(name, kept, full, shown(full, kept))


def mark(row: Row) -> str:
    """A row is marked where something failed, and where it is that of the full order."""
    ended = row.get("outcome")
    if not missing(ended) and failed(ended if isinstance(ended, Tally) else Tally([ended])):
        return FAILED
    return REFERENCE if row.get("method") == FULL_ORDER else ""


def failed(tally: Tally) -> bool:
    """Is there a failure among these endings?"""
    return any(outcome.severity is Severity.FAILURE for outcome in map(Outcome, tally))


def printed(
    rows: Sequence[Row], columns: Sequence[Column], marked: Callable[[Row], str] = mark
) -> Printed:
    """The columns that are shown."""
    shown = [column for column in columns if column.shown(rows)]
    return Printed(
        [column.heading for column in shown],
        [[column.cell(row) for column in shown] for row in rows],
        [marked(row) for row in rows],
    )


def on_its_side(rows: Sequence[Row], columns: Sequence[Column]) -> Printed:
    """Properties down, cases across."""
    shown = [column for column in columns if column.heading and column.name not in IDENTITY]
    lines = [
        [column.heading, *(as_given(row[column.name]).replace("_", " ") for row in rows)]
        for column in shown
    ]
    return Printed(["Property", *(str(row["case"]) for row in rows)], lines, [""] * len(lines))


def to_csv(table: Table, digest: str = "") -> str:
    """All columns at full precision."""
    return table.frame.to_csv(index=False, lineterminator="\n")


def to_html(table: Table) -> Markup:
    """A `<table>` and nothing around it; long words may be broken behind an underscore."""

    def line(cells: list[str], mark: str) -> str:
        flag = f' class="{mark}"' if mark else ""
        first, *others = (escape(cell).replace("_", Markup("_<wbr>")) for cell in cells)
        rest = "".join(f"<td>{cell}</td>" for cell in others)
        return f'<tr{flag}><th scope="row">{first}</th>{rest}</tr>'

    names = "".join(f'<th scope="col">{escape(cell)}</th>' for cell in table.printed.head)
    lines = [line(*row) for row in zip(table.printed.lines, table.printed.marks)]
    start = f'<table class="data" data-name="{escape(table.name)}">'
    title = f"<caption>{escape(table.name.replace('_', ' '))}, {len(lines)} rows</caption>"
    head = [title, f"<thead><tr>{names}</tr></thead>", "<tbody>"]
    return Markup("\n".join([start, *head, *lines, "</tbody>", "</table>"]) + "\n")


def to_page(table: Table, digest: str) -> str:
    """A page of its own."""
    return render(
        "table.html.j2", title=f"vibrom: {table.name}", table=to_html(table), digest=digest
    )


def to_tex(table: Table, digest: str) -> str:
    """A booktabs `tabular`."""
    text = table.printed.frame
    style = (
        text.style.hide(axis="index").format(escape="latex").format_index(escape="latex", axis=1)
    )
    tex = style.to_latex(hrules=True, column_format="l" * len(text.columns))
    signs = {
        "ω": r"$\omega$",
        "γ": r"$\gamma$",
        "³": r"\textsuperscript{3}",
        "µ": r"\textmu{}",
        GONE: "--",
    }
    for sign, command in signs.items():
        tex = tex.replace(sign, command)
    return f"% vibrom table {table.name}, source digest {digest}\n{tex}"


def resource(name: str) -> str:
    """A template, script or style sheet."""
    return (files("vibrom.report") / "templates" / name).read_text(encoding="utf-8")


def render(template: str, **values) -> str:
    """A page made from a template."""
    environment = Environment(
        autoescape=True, trim_blocks=True, lstrip_blocks=True, loader=FunctionLoader(resource)
    )
    return environment.get_template(template).render(css=Markup(resource("page.css")), **values)
