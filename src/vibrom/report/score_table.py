"""The scores of an experiment that has no table of its own: a row a case and model, medians over
seeds.
"""

from vibrom.report.collection import FULL_ORDER, Collection
from vibrom.report.columns import CASE, METHOD, OUTCOME, SEEDS, Column, Row
from vibrom.report.scores import Scores, endings

UNITS = {"percent": "%", "1": "–"}


def columns(experiment: str, scores: Scores) -> tuple[Column, ...]:
    """One for each metric, in its unit."""
    rows = [row for row in scores.rows if row.experiment == experiment]
    found = {row.metric: row.unit for row in rows}
    metrics = [Column(metric, heading(metric, unit), spread=True) for metric, unit in found.items()]
    return CASE, METHOD, *metrics, SEEDS, OUTCOME


def heading(metric: str, unit: str) -> str:
    """`frequency error [%]`."""
    words = metric.removesuffix(f"_{unit}").replace("_", " ")
    return f"{words.capitalize()} [{UNITS.get(unit, unit)}]"


def build(experiment: str, collection: Collection, scores: Scores) -> list[Row]:
    """Of every model of the scenes that took part; the full order where it was evaluated too."""
    scenes, rows = {key.scene for key in collection.loaders if key.name == experiment}, []
    for scene, model in collection.models:
        if scene not in scenes:
            continue
        scored = scores.of_experiment(scene, model, experiment)
        if scored or model != FULL_ORDER:
            row = {"case": scene, "method": model, "seeds": len(collection.seeds(scene, model))}
            for metric in dict.fromkeys(score.metric for score in scored):
                row |= scores.spread(scene, model, experiment, metric, worst=False).columns(metric)
            rows.append(row | {"outcome": endings(collection, scores, scene, model, experiment)})
    return rows
