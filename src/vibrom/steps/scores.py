"""The artefacts of every experiment -> scores.csv, which all that shows a whole run reads."""

from vibrom.report.collection import Collection
from vibrom.report.scores import Scores


def run(
    *, predictions: list[str], scores: str, provenance: dict, digest: str | None = None
) -> None:
    """One row for each score of each model; its `digest` lies beside the scores."""
    Scores.of(Collection.at(predictions)).write(scores)
