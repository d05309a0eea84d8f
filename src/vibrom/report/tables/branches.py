"""Response curves with all their branches

Every periodic motion that was found under the scene's forcing, stable or not, followed by
continuation through the folds of the curve. A curve with folds has several motions at one
frequency: which of them a start from rest reaches says little about the others.

Here: points, main folds (pairs of folds closer than a width are minor), the highest point, and the
width of the frequencies with two stable motions or more; medians over seeds. The .csv has one row
a motion: branch and number, frequency, amplitude and phase of the probe, whether it is stable, the
size of its largest Floquet multiplier, and what is special about it (fold, minor fold, pitchfork,
period doubling, torus, end). The outcome of an end says how the branch ended; that of another
motion, whether it leaves the range of the training data.
"""

import numpy as np

from vibrom.artefacts.outcome import Tally
from vibrom.models.curves import Curve
from vibrom.report.collection import answered, at_probe, outcome
from vibrom.report.columns import CASE, METHOD, OUTCOME, Column, hidden
from vibrom.report.scores import spread
from vibrom.report.table import Printed, printed

FAMILY = "models"
PLACE = 72
ASKED = "branches"  # where that is asked only
COLUMNS = (
    CASE,
    METHOD,
    Column("seed", whole=True),
    Column("branch", whole=True),
    Column("point", whole=True),
    *hidden("omega_rad_per_s", "probe_amplitude_m", "phase_rad"),
    Column("stable", whole=True),
    *hidden("multiplier_largest", "kind"),
    OUTCOME,
)
SUMMARY = (
    CASE,
    METHOD,
    Column("points", "Points", whole=True),
    Column("folds", "Main folds [–]", digits=2, spread=True),
    Column("peak_m", "Highest amplitude [m]", spread=True),
    Column("peak_rad_per_s", "at [rad/s]", spread=True),
    Column("width_rad_per_s", "Two stable motions over [rad/s]", spread=True),
    OUTCOME,
)


def build(collection, scores):
    """One row a periodic motion, model and seed; one without a motion where there is none."""
    rows = []
    for scene, model in collection.models:
        for seed in collection.seeds(scene, model):
            found = collection.find(scene, model, "branches", seed)
            if found is not None:
                rows += motions({"case": scene, "method": model, "seed": seed}, found)
    return rows


def motions(whose: dict, found) -> list[dict]:
    """One row a periodic motion; a model that could not be fitted has its outcome."""
    if not answered(found):
        return [whose | {"branch": 0, "point": 0, "stable": 0, "outcome": outcome(found)}]
    columns = {
        "branch": found["branch"].values,
        "omega_rad_per_s": found["angular_frequency"].values,
        "probe_amplitude_m": at_probe(found, "maximum"),
        "phase_rad": at_probe(found, "phase"),
        "stable": found["stable"].values,
        "multiplier_largest": found["multiplier_largest"].values,
        "kind": found["kind"].values,
        "outcome": found["outcome"].values,
    }
    return [
        whose | {"point": point} | dict(zip(columns, row))
        for point, row in enumerate(zip(*(column.tolist() for column in columns.values())))
    ]


def shown(rows, columns) -> Printed:
    """One row a case and model."""
    models = dict.fromkeys((row["case"], row["method"]) for row in rows)
    return printed([summary(rows, *model) for model in models], SUMMARY)


def summary(rows, case: str, method: str) -> dict:
    """Medians over the seeds of one model; a curve without motions counts for none."""
    chosen = [row for row in rows if (row["case"], row["method"]) == (case, method)]
    known = [row for row in chosen if np.isfinite(row["probe_amplitude_m"])]
    curves = [
        of_rows([row for row in known if row["seed"] == seed])
        for seed in dict.fromkeys(row["seed"] for row in known)
    ]
    numbers = {
        "folds": [float(len(one.folds)) for one in curves],
        "peak_m": [one.amplitude[one.peak] for one in curves],
        "peak_rad_per_s": [one.parameter[one.peak] for one in curves],
        "width_rad_per_s": [one.bistable_width for one in curves],
    }
    whole = {"case": case, "method": method, "points": len(known)}
    for name, values in numbers.items():
        whole |= spread(values, worst=False).columns(name)
    return whole | {"outcome": Tally(row["outcome"] for row in chosen)}


def of_rows(rows) -> Curve:
    """The curve of one seed."""
    names = ("branch", "omega_rad_per_s", "probe_amplitude_m", "stable", "kind")
    branch, *others = (np.array([row[name] for row in rows]) for name in names)
    frequency, amplitude, stable, kind = others
    return Curve(branch, frequency, amplitude, stable.astype(bool), kind)
