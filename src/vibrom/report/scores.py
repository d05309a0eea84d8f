"""Scores over seeds: median, smallest and largest value, and what became of the seeds.

A seed that failed has no value. For an error it counts as infinitely large: when that makes the
median infinite, the median is a failure and has no value (NaN), and neither has the maximum as soon
as one seed failed. For quantities without a worst side (eigenvalues, run times, errors with a sign)
failed seeds are left out, and the median has no value when as many seeds failed as did not.
"""

from collections import Counter
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd

from vibrom.report.collection import UNSEEDED

COLUMNS = ("scene", "method", "seed", "experiment", "metric", "value", "unit", "seconds", "outcome")


class Spread(NamedTuple):
    median: float
    minimum: float
    maximum: float


NOTHING = Spread(np.nan, np.nan, np.nan)


def seed_label(seed) -> str:
    """The folder name of a seed written as a number, as that name, or left empty."""
    if isinstance(seed, str) and (seed == UNSEEDED or seed.startswith("seed_")):
        return seed
    number = pd.to_numeric(seed, errors="coerce")
    return UNSEEDED if pd.isna(number) or number < 0 else f"seed_{int(number)}"


def spread(values: np.ndarray, *, worst: bool) -> Spread:
    """Median, minimum and maximum over seeds; `worst` says that a failed seed (NaN) counts as
    infinitely large.
    """
    values = np.asarray(values, float)
    good = values[np.isfinite(values)]
    failed = len(values) - len(good)
    if len(good) == 0 or (not worst and failed >= len(good)):
        return NOTHING
    if not worst:
        return Spread(float(np.median(good)), float(good.min()), float(good.max()))
    with np.errstate(invalid="ignore"):
        median = float(np.median(np.concatenate([good, np.full(failed, np.inf)])))
    largest = float(good.max()) if failed == 0 else np.nan
    return Spread(median if np.isfinite(median) else np.nan, float(good.min()), largest)


def tally(outcomes) -> str:
    """`ok` when all agree, else each outcome with its count, the most frequent first: `ok 2,
    diverged 1`.
    """
    counts = Counter(outcomes)
    if len(counts) < 2:
        return next(iter(counts), "not run")
    ranked = sorted(counts, key=lambda outcome: (-counts[outcome], outcome != "ok"))
    return ", ".join(f"{outcome} {counts[outcome]}" for outcome in ranked)


@dataclass(frozen=True)
class Scores:
    """The long table of scores."""

    frame: pd.DataFrame

    def __post_init__(self):
        missing = [name for name in COLUMNS if name not in self.frame.columns]
        if missing:
            raise ValueError(f"scores: no column {', '.join(missing)}; make the scores anew")
        seeds = [seed_label(seed) for seed in self.frame["seed"]]
        object.__setattr__(
            self, "frame", self.frame.assign(seed=seeds, outcome=self.frame["outcome"].astype(str))
        )

    def rows(
        self, scene: str, method: str, experiment: str, metric: str | None = None
    ) -> pd.DataFrame:
        frame = self.frame
        chosen = (
            (frame["scene"] == scene)
            & (frame["method"] == method)
            & (frame["experiment"] == experiment)
        )
        return frame[chosen if metric is None else chosen & (frame["metric"] == metric)]

    def spread(
        self, scene: str, method: str, experiment: str, metric: str, *, worst: bool = True
    ) -> Spread:
        return spread(
            self.rows(scene, method, experiment, metric)["value"].to_numpy(float), worst=worst
        )

    def outcome(self, scene: str, method: str, experiment: str) -> str:
        return tally(self.rows(scene, method, experiment).drop_duplicates("seed")["outcome"])

    def value(self, scene: str, method: str, seed: str, experiment: str, metric: str) -> float:
        rows = self.rows(scene, method, experiment, metric)
        rows = rows[rows["seed"] == seed]
        return float(rows["value"].iloc[0]) if len(rows) else np.nan

    def median_seed(self, scene: str, method: str, seeds: list[str]) -> str:
        """The seed that figures draw: the middle one by decay NMTE (of an even number the lower),
        failed seeds last.
        """
        errors = {seed: self.value(scene, method, seed, "decay", "nmte_percent") for seed in seeds}
        ranked = sorted(seeds, key=lambda seed: np.nan_to_num(errors[seed], nan=np.inf))
        return ranked[(len(ranked) - 1) // 2]
