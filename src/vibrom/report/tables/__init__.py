"""One file a table, each with COLUMNS and `build(collection, scores) -> rows`.
`vibrom.report.outputs` says what else is in such a file.

A table is printed as its columns say. One that is printed otherwise has
`shown(rows, columns) -> Printed`.
"""

from importlib import import_module

from vibrom.report import outputs, score_table
from vibrom.report.collection import Collection
from vibrom.report.scores import Scores
from vibrom.report.table import Table, printed, table, to_csv, to_page, to_tex

WRITTEN = {"csv": to_csv, "html": to_page, "tex": to_tex}


def make(name: str, collection: Collection, scores: Scores) -> Table:
    """The table of this name; of an experiment's name, if there is none, its scores."""
    if not outputs.has_table(name):
        rows = score_table.build(name, collection, scores)
        return table(name, score_table.columns(name, scores), rows, printed)
    plug = import_module(f"{__name__}.{name}")
    shown = getattr(plug, "shown", printed)
    return table(name, plug.COLUMNS, plug.build(collection, scores), shown)


def render(made: Table, form: str, digest: str) -> bytes:
    """As csv, html or tex."""
    return WRITTEN[form](made, digest).encode()
