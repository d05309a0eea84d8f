"""Everything that did not end well, in one table: which model, asked what, ended how, when, with
which seeds.
"""

import numpy as np
import pandas as pd

from vibrom.report import effects
from vibrom.report.collection import FULL_ORDER, UNSEEDED, Collection, scalar
from vibrom.report.presentation import GONE, number
from vibrom.report.scores import Scores
from vibrom.thesis import published as thesis

COLUMNS = ("Case", "Model", "Asked for", "Outcome", "Seeds", "When [s]", "NMTE [%]")


def table(
    collection: Collection, scores: Scores, points: pd.DataFrame | None = None
) -> pd.DataFrame:
    """All outcomes but `ok`, as text, those without a value first; `points` are those of the
    response curves.
    """
    rows = [*full_order(collection), *predictions(collection, scores), *curves(points)]
    order = {scene: place for place, scene in enumerate(collection.scenes)}
    rows.sort(key=lambda row: (order.get(row[0], len(order)), row[3].startswith("left_range")))
    return pd.DataFrame(
        [[row[0], thesis.label(row[1]), *row[2:]] for row in rows], columns=list(COLUMNS)
    )


def full_order(collection: Collection) -> list[tuple]:
    rows = []
    for scene in collection.scenes:
        for name in ("train", "test", "forced"):
            run = collection.find(scene, FULL_ORDER, name)
            if run is not None and str(scalar(run, "outcome", "ok")) != "ok":
                when = number(float(scalar(run, "failed_at")))
                rows.append(
                    (scene, FULL_ORDER, name, str(scalar(run, "outcome")), GONE, when, GONE)
                )
        worth = collection.find(scene, FULL_ORDER, "effects")
        for left_out, outcome, when in (
            zip(*(worth[name].values for name in ("left_out", "outcome", "failed_at")))
            if worth is not None
            else ()
        ):
            if effects.failed(outcome):
                rows.append(
                    (
                        scene,
                        FULL_ORDER,
                        f"without {left_out}",
                        outcome,
                        GONE,
                        number(float(when)),
                        GONE,
                    )
                )
    return rows


def predictions(collection: Collection, scores: Scores) -> list[tuple]:
    """One row for all seeds and experiments of a model that ended in the same way at the same time."""
    # The points of the response curves have rows of their own.
    bad = scores.frame[
        ~scores.frame["outcome"].isin(["ok", "nan"]) & (scores.frame["experiment"] != "frc")
    ]
    found: dict[tuple, tuple[list[str], str]] = {}
    by = ["scene", "method", "experiment", "outcome"]
    for (scene, method, experiment, outcome), group in bad.groupby(by, sort=False):
        seeds = list(dict.fromkeys(group["seed"]))
        times = [
            float(scalar(collection.find(scene, method, experiment, seed), "failed_at"))
            for seed in seeds
        ]
        asked, value = found.setdefault(
            (scene, method, outcome, seed_list(seeds), extent(times)), ([], GONE)
        )
        asked.append(experiment.replace("_", " "))
        error = extent(group.loc[group["metric"] == "nmte_percent", "value"].to_numpy(float))
        if value == GONE:
            found[scene, method, outcome, seed_list(seeds), extent(times)] = (asked, error)
    return [
        (scene, method, ", ".join(asked), outcome, seeds, when, value)
        for (scene, method, outcome, seeds, when), (asked, value) in found.items()
    ]


def curves(points: pd.DataFrame | None) -> list[tuple]:
    """Points of the response curves that failed or left the training range."""
    if points is None or points.empty:
        return []
    rows = []
    bad = points[points["outcome"] != "ok"]
    for (case, method, outcome), group in bad.groupby(["case", "method", "outcome"], sort=False):
        whole = points[(points["case"] == case) & (points["method"] == method)]
        seeds = [
            UNSEEDED if pd.isna(seed) else f"seed_{int(seed)}" for seed in group["seed"].unique()
        ]
        rows.append(
            (
                case,
                method,
                "response curve",
                f"{outcome}: {len(group)} of {len(whole)} points",
                seed_list(seeds),
                extent(group["failed_at_s"].to_numpy(float)),
                GONE,
            )
        )
    return rows


def seed_list(seeds: list[str]) -> str:
    numbers = [seed.removeprefix("seed_") for seed in seeds if seed != UNSEEDED]
    return ", ".join(numbers) if numbers else GONE


def extent(values) -> str:
    """One number, or the smallest and the largest."""
    good = np.asarray(values, float)
    good = good[np.isfinite(good)]
    if not good.size:
        return GONE
    low, high = number(float(good.min()), 3), number(float(good.max()), 3)
    return low if low == high else f"{low} to {high}"
