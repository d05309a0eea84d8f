"""The artefacts of every experiment -> scores.csv, a row a number: scene, method, seed, experiment,
metric, value, unit, seconds, outcome.
"""

import pandas as pd

from vibrom.artefacts.files import write
from vibrom.report.collection import Collection
from vibrom.report.scores import Score, Scores


def run(*, predictions: list[str], scores: str, provenance: dict) -> None:
    """One row for each score of each model."""
    rows = Scores.of(Collection.at(predictions)).rows
    named = [row._replace(seed="unseeded" if row.seed is None else row.seed) for row in rows]
    frame = pd.DataFrame(named, columns=list(Score._fields))
    write(scores, frame.to_csv(index=False, float_format="%.10g"))
