"""The artefacts of every experiment -> scores.csv, which all that shows a whole run reads."""

from vibrom.artefacts.files import write
from vibrom.report.collection import Collection
from vibrom.report.scores import Scores


def run(*, predictions: list[str], scores: str, provenance: dict) -> None:
    """One row for each score of each model."""
    write(scores, Scores.of(Collection.at(predictions)).to_csv())
