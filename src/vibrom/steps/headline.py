"""Artefacts -> the short table at the end of a run, on the screen and in a file."""

from pathlib import Path

from rich.console import Console

from vibrom import tracking
from vibrom.artefacts.files import write
from vibrom.report import headline as numbers
from vibrom.report import tables
from vibrom.report.collection import Collection
from vibrom.report.scores import Scores


def run(
    *,
    artefacts: list[str],
    scores: str,
    report: str,
    store: str,
    crate: str,
    headline: str,
    provenance: dict,
) -> None:
    """It names the report, MLflow's store, what was made from what, and the folders beside them."""
    collection = Collection.at(artefacts)
    known = Scores.read(scores)
    made = {name: tables.make(name, collection, known) for name in numbers.TABLES}
    folder = Path(report).parent
    places = {
        "Report": report,
        "Tables": str(folder / "tables"),
        "Scores": scores,
        "MLflow": tracking.command(store),
        "Origin": crate,
    }
    write(headline, numbers.text(made, places))
    numbers.show(made, places, Console())
