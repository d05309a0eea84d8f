"""Folds in the forcing, at one frequency

Of each model's curve of motions against the amplitude of the forcing: main folds; the forcing at
which the small motion ends as the forcing grows (upper fold), and the one at which the large one
ends as it shrinks (lower fold), times the scene's load. Against the full order's curve: largest
error of the forcing and of the amplitude at the folds; error of the width over which two motions
are stable (with its sign); largest error of the amplitude along the stable and along the unstable
parts, compared at equal arclength; and at how many forcings of the full order's grid the number of
stable motions is another. A model without the full order's folds has none of the errors that need
them: it counts as infinitely wrong. Medians over seeds, smallest and largest in parentheses.
"""

import numpy as np

from vibrom.report import branches
from vibrom.report.branches import curve, scenes
from vibrom.report.collection import FULL_ORDER
from vibrom.report.columns import CASE, METHOD, OUTCOME, SEEDS, Column
from vibrom.report.scores import endings, spread

FAMILY = "models"
PLACE = 73
ASKED = "s_curve"  # where that is asked only
FOUND = {
    "folds": "Main folds [–]",
    "upper_fold": "Upper fold [–]",
    "lower_fold": "Lower fold [–]",
}
ERRORS = {
    "fold_forcing_error_percent": "Fold forcing [%]",
    "fold_amplitude_error_percent": "Fold amplitude [%]",
    **branches.ERRORS,
}
COLUMNS = (
    CASE,
    METHOD,
    *(Column(name, heading, digits=4, spread=True) for name, heading in FOUND.items()),
    *(Column(name, heading, digits=3, spread=True) for name, heading in ERRORS.items()),
    SEEDS,
    OUTCOME,
)


def build(collection, scores):
    """One row a case and model, of the cases whose full order was evaluated."""
    rows = []
    for scene, model in collection.models:
        if scene not in scenes(collection, "s_curve"):
            continue
        row = {"case": scene, "method": model, "seeds": len(collection.seeds(scene, model))}
        found = [curve(answer) for answer in collection.every(scene, model, "s_curve")]
        marks = [landmarks(one) for one in found if one is not None]
        for name, values in zip(FOUND, np.reshape(marks, (len(marks), len(FOUND))).T):
            row |= spread(values, worst=False).columns(name)
        if model != FULL_ORDER:
            for name in ERRORS:
                row |= scores.spread(scene, model, "s_curve", name).columns(name)
            row |= {"outcome": endings(collection, scores, scene, model, "s_curve")}
        rows.append(row)
    return rows


def landmarks(found) -> tuple[float, float, float]:
    """Main folds, and the forcing at the first and the second one."""
    places = found.folds
    forcing = [*found.parameter[places], np.nan, np.nan]
    return float(len(places)), float(forcing[0]), float(forcing[1])
