"""The tables of a run: a row for each case and model, units in the column names, the thesis's
numbers beside ours.

Over seeds: median, and `_min`, `_max`; how failed seeds count is said in `vibrom.report.scores`.
`outcome` tells how many seeds ended how.
"""

import numpy as np
import pandas as pd
import xarray as xr

from vibrom.report import beam, checks, cost, curves, effects, stability
from vibrom.report.collection import FULL_ORDER, Collection, scalar
from vibrom.report.scores import Scores, Spread, tally
from vibrom.thesis import published as thesis


def build(name: str, collection: Collection, scores: Scores) -> pd.DataFrame:
    """The table of this name, numbers as numbers."""
    builders = {
        "beam": lambda: beam.table(collection),
        "eigenvalues": lambda: eigenvalues(collection, scores),
        "reconstruction": lambda: errors("reconstruction", "test", collection, scores),
        "decay": lambda: errors("decay", "test", collection, scores),
        "forced": lambda: errors("forced", "forced", collection, scores),
        "run_times": lambda: run_times(collection, scores),
        "frc": lambda: curves.table(collection),
        "cost_full_order": lambda: cost.full_order(collection),
        "cost_reduced": lambda: cost.reduced(collection),
        "cheapest": lambda: cost.cheapest_settings(collection),
        "break_even": lambda: cost.break_evens(collection, scores),
        "effects": lambda: effects.table(collection),
        "checks": lambda: checks.table(collection, scores),
        "stability": lambda: stability.outcomes(collection),
        "guards": lambda: stability.guards(collection),
        "full_order_steps": lambda: stability.full_order(collection),
    }
    if name not in builders:
        raise ValueError(f"table {name!r}: unknown; choose from {', '.join(builders)}")
    return builders[name]()


def outcome(
    collection: Collection, scores: Scores, scene: str, method: str, experiment: str
) -> str:
    """What became of the seeds; a model that was not asked says why, if its fit knows."""
    found = scores.outcome(scene, method, experiment)
    if found != "not run":
        return found
    fits = [collection.find(scene, method, "rom", seed) for seed in collection.seeds(scene, method)]
    bad = [
        str(scalar(fit, "outcome", "ok"))
        for fit in fits
        if str(scalar(fit, "outcome", "ok")) != "ok"
    ]
    return tally(bad) if bad else found


def spread_columns(stem: str, values: Spread) -> dict[str, float]:
    return {stem: values.median, f"{stem}_min": values.minimum, f"{stem}_max": values.maximum}


def errors(experiment: str, reference: str, collection: Collection, scores: Scores) -> pd.DataFrame:
    """NMTE [%] of one experiment. The full-order model is the reference: zero where its own run
    went well.
    """
    rows = []
    for scene in collection.scenes:
        run = collection.find(scene, FULL_ORDER, reference)
        ended = str(scalar(run, "outcome", "not run"))
        zero = Spread(*[0.0 if ended == "ok" else np.nan] * 3)
        row = {"case": scene, "method": FULL_ORDER, **spread_columns("nmte_percent", zero)}
        row |= {"thesis_percent": np.nan, "thesis_outcome": ""}
        row |= spread_columns("amplitude_error_percent", zero) if experiment == "forced" else {}
        rows.append(row | {"seeds": 1, "outcome": ended} | first_times([run]))
        for method in collection.methods:
            seeds = collection.seeds(scene, method)
            published, verdict = thesis.percent(experiment, scene, method)
            row = {"case": scene, "method": method}
            row |= spread_columns(
                "nmte_percent", scores.spread(scene, method, experiment, "nmte_percent")
            )
            row |= {"thesis_percent": published, "thesis_outcome": verdict}
            if experiment == "forced":
                error = scores.spread(
                    scene, method, experiment, "amplitude_error_percent", worst=False
                )  # it has a sign
                row |= spread_columns("amplitude_error_percent", error)
            row |= ending(collection, scores, scene, method, experiment)
            rows.append(
                row
                | first_times([collection.find(scene, method, experiment, seed) for seed in seeds])
            )
    frame = pd.DataFrame(rows)
    return (
        frame.drop(columns=["failed_at_s", "left_range_at_s"])
        if experiment == "reconstruction"
        else frame
    )


def first_times(runs: list[xr.Dataset | None]) -> dict[str, float]:
    """Earliest time [s] at which a seed failed, and at which one that did not fail left its
    training range.
    """
    times: dict[str, list[float]] = {"failed_at_s": [], "left_range_at_s": []}
    for run in runs:
        ended, when = str(scalar(run, "outcome", "ok")), float(scalar(run, "failed_at"))
        if ended != "ok" and np.isfinite(when):
            times["left_range_at_s" if ended == "left_range" else "failed_at_s"].append(when)
    return {name: min(found, default=np.nan) for name, found in times.items()}


def eigenvalues(collection: Collection, scores: Scores) -> pd.DataFrame:
    """The first pair of eigenvalues of the linear part at rest: real part [1/s], imaginary part
    [rad/s].
    """
    rows = []
    for scene, model in models(collection):
        row: dict = {"case": scene, "method": model}
        for part in ("real_per_s", "imaginary_rad_per_s"):
            row |= spread_columns(
                part, scores.spread(scene, model, "eigenvalues", part, worst=False)
            )
        row["thesis_real_per_s"], row["thesis_imaginary_rad_per_s"] = thesis.eigenvalue(
            scene, model
        )
        rows.append(row | ending(collection, scores, scene, model, "eigenvalues"))
    return pd.DataFrame(rows)


def run_times(collection: Collection, scores: Scores) -> pd.DataFrame:
    """Wall time [s] of every step, offline and online."""
    rows = []
    for scene, model in models(collection):
        row: dict = {"case": scene, "method": model}
        for quantity in thesis.RUN_TIMES:
            row |= spread_columns(
                quantity, scores.spread(scene, model, "run_times", quantity, worst=False)
            )
        row |= {
            f"thesis_{quantity}": thesis.run_time(quantity, scene, model)
            for quantity in thesis.RUN_TIMES
        }
        rows.append(row | ending(collection, scores, scene, model, "run_times"))
    return pd.DataFrame(rows)


def models(collection: Collection) -> list[tuple[str, str]]:
    return [
        (scene, model) for scene in collection.scenes for model in [FULL_ORDER, *collection.methods]
    ]


def ending(collection: Collection, scores: Scores, scene: str, model: str, experiment: str) -> dict:
    seeds = 1 if model == FULL_ORDER else len(collection.seeds(scene, model))
    return {"seeds": seeds, "outcome": outcome(collection, scores, scene, model, experiment)}
