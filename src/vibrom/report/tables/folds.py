"""Folds of the response curve, against the full order's

Of each model's response curve with all its branches: main folds; largest error of their
frequency and of their amplitude; errors of the highest point, and of the width of the frequencies
with two stable motions or more (with their sign); largest error of the amplitude along the stable
and along the unstable parts, compared at equal arclength between ends and folds; and at how many
frequencies of the full order's grid the number of stable motions is another. A model without the
full order's folds has none of the errors that need them: it counts as infinitely wrong. Where an
amplitude saturates about the true peak, so that more frequencies than in the full order's curve are
within a thousandth of the highest point, that point has no frequency of its own, and no error of
it: such seeds are left out there. A flat top that lies apart from the true peak is as wrong as its
highest point.

Medians over seeds, smallest and largest in parentheses. Alike are the seeds whose curve has as many
ends and folds on every branch as the full order's.
"""

import numpy as np

from vibrom.report import branches
from vibrom.report.branches import curve, scenes
from vibrom.report.collection import FULL_ORDER
from vibrom.report.columns import CASE, METHOD, OUTCOME, SEEDS, Column
from vibrom.report.scores import endings, spread

FAMILY = "models"
PLACE = 71
ASKED = "branches"  # where that is asked only
ERRORS = {
    "fold_frequency_error_percent": "Fold frequency [%]",
    "fold_amplitude_error_percent": "Fold amplitude [%]",
    "peak_frequency_error_percent": "Peak frequency [%]",
    "peak_error_percent": "Peak [%]",
    **branches.ERRORS,
}
COLUMNS = (
    CASE,
    METHOD,
    Column("folds", "Main folds [–]", digits=2, spread=True),
    Column("alike", "Alike", whole=True),
    *(Column(name, heading, digits=3, spread=True) for name, heading in ERRORS.items()),
    SEEDS,
    OUTCOME,
)


def build(collection, scores):
    """One row a case and model, of the cases whose full order was evaluated."""
    rows = []
    for scene, model in collection.models:
        if scene not in scenes(collection):
            continue
        row = {"case": scene, "method": model, "seeds": len(collection.seeds(scene, model))}
        if model == FULL_ORDER:
            found = curve(collection.find(scene, model, "branches"))
            count = [np.nan if found is None else float(len(found.folds))]
            rows.append(row | {"alike": 1} | spread(count, worst=False).columns("folds"))
            continue
        row |= scores.spread(scene, model, "branches", "folds", worst=False).columns("folds")
        for name in ERRORS:
            row |= spread(values(scores, scene, model, name), worst=True).columns(name)
        # Along branches only those are compared that have the same ends and folds.
        along = scores.of_experiment(scene, model, "branches", "stable_amplitude_error_percent")
        row["alike"] = sum(bool(np.isfinite(score.value)) for score in along)
        rows.append(row | {"outcome": endings(collection, scores, scene, model, "branches")})
    return rows


def values(scores, scene, model, name):
    """Of the seeds; without those whose highest point has a value, and no frequency."""
    found = scores.of_experiment(scene, model, "branches", name)
    if name != "peak_frequency_error_percent":
        return [score.value for score in found]
    peaks = [
        scores.value(scene, model, score.seed, "branches", "peak_error_percent") for score in found
    ]
    return [
        score.value
        for score, peak in zip(found, peaks)
        if np.isfinite(score.value) or not np.isfinite(peak)
    ]
