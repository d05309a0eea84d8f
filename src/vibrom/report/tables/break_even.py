"""Break-even: after how many answers a method has paid for its training

The least number of decays, forced runs and response curves for which training data, training and
the model's answers take no longer than the same answers of the full order, by the times of the
table run_times. Beside it stands the number that follows from the thesis's times. There is no
number where a method does not answer the question (its median seed failed), and "never" where its
answer takes longer than the full order's. A response curve with gaps has no run time; it counts
with the seconds that it took.
"""

import numpy as np

from vibrom.report import curves
from vibrom.report.collection import FULL_ORDER
from vibrom.report.columns import CASE, METHOD, OUTCOME, Column, as_given
from vibrom.report.scores import offline, spread
from vibrom.studies.parts.work_precision import break_even
from vibrom.thesis import published as thesis

FAMILY = "models"
PLACE = 80
ASKED = "run_times"  # where that is asked only
COUNTED = {"decay": "decays", "forced": "forced_runs", "frc": "sweeps"}
HEADINGS = {"decays": "decays", "forced_runs": "forced runs", "sweeps": "response curves"}


def count(name: str, heading: str) -> Column:
    """A number of answers, or never."""
    return Column(
        name,
        heading,
        text=lambda row: "never" if np.isposinf(row[name]) else as_given(row[name]),
    )


COLUMNS = (
    CASE,
    METHOD,
    Column("offline_s", "Offline [s]"),
    *(count(name, f"{words.capitalize()} [–]") for name, words in HEADINGS.items()),
    Column(
        "thesis_offline_s",
        "Thesis: offline [s]",
        text=lambda row: as_given(row["thesis_offline_s"]),
    ),
    *(count(f"thesis_{name}", f"Thesis: {words} [–]") for name, words in HEADINGS.items()),
    OUTCOME,
)


def build(collection, scores):
    """One row a case and method."""
    rows = []
    for scene in collection.scenes:
        full = scores.seconds(scene, FULL_ORDER)
        for method in collection.methods:
            own = scores.seconds(scene, method)
            printed = {name: thesis.run_time(name, scene, method) for name in own}
            row = {"case": scene, "method": method, "offline_s": offline(own)}
            row["thesis_offline_s"] = offline(printed)
            for experiment, name in COUNTED.items():
                online = f"{experiment}_s"
                row[name] = row[f"thesis_{name}"] = np.nan
                if np.isfinite(error(collection, scores, scene, method, experiment)):
                    seconds = own[online]
                    if experiment == "frc" and np.isnan(seconds):
                        seconds = spent(scores, scene, method)
                    row[name] = break_even(row["offline_s"], seconds, full[online])
                if not fails(experiment, scene, method):
                    theirs = thesis.run_time(online, scene, FULL_ORDER)
                    row[f"thesis_{name}"] = break_even(
                        row["thesis_offline_s"], printed[online], theirs
                    )
            rows.append(row | {"outcome": scores.outcome(scene, method, "run_times")})
    return rows


def error(collection, scores, scene: str, method: str, experiment: str) -> float:
    """The median error [%] that is printed for this question; NaN where the median seed failed."""
    if experiment == "frc":
        return curves.error_of(collection, scene, method).median
    return scores.spread(scene, method, experiment, "nmte_percent").median


def spent(scores, scene: str, method: str) -> float:
    """Median seconds of the response curves of a method, those with gaps included."""
    seeds = {row.seed: row.seconds for row in scores.of_experiment(scene, method, "frc")}
    return spread(seeds.values(), worst=False).median


def fails(experiment: str, scene: str, method: str) -> bool:
    """Does the thesis print that this method fails? It prints no errors of response curves."""
    return experiment != "frc" and bool(thesis.percent(experiment, scene, method)[1])
