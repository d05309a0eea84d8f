"""The scores of a run, and how those of several seeds become one number.

A seed that failed has no value. For an error it counts as infinitely large: when that makes the
median infinite, the median is a failure and has no value (NaN), and neither has the maximum as soon
as one seed failed. For quantities without a worst side (eigenvalues, run times, errors with a sign)
failed seeds are left out, and the median has no value when as many seeds failed as did not.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from vibrom.artefacts.files import DataError, write
from vibrom.artefacts.identity import FITTED_ONCE
from vibrom.artefacts.outcome import Outcome, Tally
from vibrom.config import plugs
from vibrom.config.digest import digest
from vibrom.config.places import UNSEEDED
from vibrom.report.collection import Collection, Key, outcome

# Scores of the experiment run_times.
OFFLINE = ("generate_training_data_s", "obtain_mapping_s", "obtain_dynamics_s")
ONLINE = ("decay_s", "forced_s", "frc_s")

DIGEST = ".digest"  # of the file beside scores.csv

BALANCE = "balance"  # under this name stand the work balances, each of a run:
UNDER_SIGNALS = ("response", "random_forcing")
RUNS = ("train", "test", "forced", "frc", *UNDER_SIGNALS)  # of the full order,
MODEL_RUNS = ("decay", "forced", *UNDER_SIGNALS)  # and of the models


class Score(NamedTuple):
    """One number of one model in one experiment."""

    scene: str
    method: str
    seed: int | None
    experiment: str
    metric: str
    value: float  # in `unit`; NaN where there is none
    unit: str
    seconds: float  # of wall time
    outcome: Tally  # how the experiment ended, for a curve at all of its points


class Spread(NamedTuple):
    """Over seeds."""

    median: float
    minimum: float
    maximum: float

    def columns(self, name: str) -> dict[str, float]:
        """As the cells of a column of this name."""
        return {name: self.median, f"{name}_min": self.minimum, f"{name}_max": self.maximum}


NO_SPREAD = Spread(np.nan, np.nan, np.nan)


def spread(values: Iterable[float], *, worst: bool) -> Spread:
    """Median, minimum and maximum over seeds; `worst` says that a failed seed (NaN, infinite)
    counts as infinitely large.
    """
    values = np.asarray(list(values), float)
    good = values[np.isfinite(values)]
    failed = len(values) - len(good)
    if len(good) == 0 or (not worst and failed >= len(good)):
        return NO_SPREAD
    if not worst:
        return Spread(float(np.median(good)), float(good.min()), float(good.max()))
    with np.errstate(invalid="ignore"):
        median = float(np.median(np.concatenate([good, np.full(failed, np.inf)])))
    largest = float(good.max()) if failed == 0 else np.nan
    return Spread(median if np.isfinite(median) else np.nan, float(good.min()), largest)


class Scores:
    """All scores of a run, collected when one is first asked for: few figures show any."""

    def __init__(self, rows: Iterable[Score]):
        self._source = rows

    @cached_property
    def rows(self) -> list[Score]:
        """In the order of the run."""
        return list(self._source)

    @cached_property
    def _by_experiment(self) -> dict[tuple, list[Score]]:
        found = defaultdict(list)
        for row in self.rows:
            found[row.scene, row.method, row.experiment].append(row)
        return found

    @classmethod
    def of(cls, collection: Collection) -> Scores:
        """Those that the artefacts of the experiments carry, and the work balance of every run: of
        the full order from its own, of the models from the study `trust`.
        """
        readers = (
            (_scores, plugs.names("experiments")),
            (_balance, RUNS),
            (_balances, ("trust",)),
        )
        return cls(
            score
            for read, names in readers
            for key in collection.loaders
            if key.name in names
            for score in read(key, collection.find(key.scene, key.model, key.name, key.seed))
        )

    @classmethod
    def read(cls, path: str | Path) -> Scores:
        """Those that `write` wrote; raises `DataError` where the file is another one by now."""
        try:
            written = Path(f"{path}{DIGEST}").read_text(encoding="utf-8").split()[0]
            kept = digest(Path(path)) == written
        except (OSError, IndexError):
            kept = False
        if not kept:
            raise DataError(f"{path}: not what was written; delete it and run again")
        table = pd.read_csv(path, dtype=str, keep_default_na=False)  # a scene may be called NA
        found = (Score(*row[:-1]) for row in table.itertuples(index=False))
        return cls(
            score._replace(
                seed=None if score.seed == UNSEEDED else int(score.seed),
                value=float(score.value or np.nan),
                seconds=float(score.seconds or np.nan),
                outcome=Tally.read(score.outcome, int(total)),
            )
            for score, total in zip(found, table["endings"])
        )

    def write(self, path: str | Path) -> None:
        """As csv, a row a number: the fields of `Score`, values to the last digit, and how many
        endings the outcome counts. Beside it stands its digest.
        """
        named = [row._replace(seed=UNSEEDED if row.seed is None else row.seed) for row in self.rows]
        table = pd.DataFrame(named, columns=list(Score._fields))
        table["endings"] = [row.outcome.total() for row in self.rows]
        write(path, table.to_csv(index=False))
        write(f"{path}{DIGEST}", f"{digest(Path(path))}\n")

    def of_experiment(
        self, scene: str, method: str, experiment: str, metric: str | None = None
    ) -> list[Score]:
        """Of all seeds; of one metric or of all."""
        rows = self._by_experiment.get((scene, method, experiment), [])
        return [row for row in rows if metric in (None, row.metric)]

    def spread(
        self, scene: str, method: str, experiment: str, metric: str, *, worst: bool = True
    ) -> Spread:
        """Of one metric over seeds."""
        rows = self.of_experiment(scene, method, experiment, metric)
        return spread((row.value for row in rows), worst=worst)

    def seconds(self, scene: str, model: str) -> dict[str, float]:
        """Run times of a model, offline and online: medians over seeds."""
        return {
            name: self.spread(scene, model, "run_times", name, worst=False).median
            for name in OFFLINE + ONLINE
        }

    def outcome(self, scene: str, method: str, experiment: str) -> Tally:
        """How the seeds ended; empty where the model took no part."""
        seeds = {row.seed: row.outcome for row in self.of_experiment(scene, method, experiment)}
        return Tally(ending for tally in seeds.values() for ending in tally.elements())

    def value(
        self, scene: str, method: str, seed: int | None, experiment: str, metric: str
    ) -> float:
        """Of one seed; NaN where there is none."""
        rows = self.of_experiment(scene, method, experiment, metric)
        return next((row.value for row in rows if row.seed == seed), np.nan)

    def median_seed(self, scene: str, method: str, seeds: list[int | None]) -> int | None:
        """The seed that figures draw: the middle one by decay NMTE (of an even number the lower),
        failed seeds last.
        """
        errors = {seed: self.value(scene, method, seed, "decay", "nmte_percent") for seed in seeds}
        ranked = sorted(seeds, key=lambda seed: np.nan_to_num(errors[seed], nan=np.inf))
        return ranked[(len(ranked) - 1) // 2]


def offline(seconds: Mapping[str, float]) -> float:
    """All that is spent before the first answer [s]; what a method does not have counts nothing."""
    parts = [seconds[name] for name in OFFLINE]
    return float(np.nansum(parts)) if np.isfinite(parts).any() else np.nan


def _scores(key: Key, dataset: xr.Dataset) -> list[Score]:
    """Those of one artefact; none of a truth, which is compared with nothing."""
    if "score" not in dataset.coords:
        return []
    ended = Tally(dataset["outcome"].values.ravel().astype(str))
    seconds = float(dataset["seconds"])
    columns = (dataset[name].values for name in ("score", "score_value", "score_unit"))
    return [
        Score(*key, str(metric), float(value), str(unit), seconds, ended)
        for metric, value, unit in zip(*columns)
    ]


def _balance(key: Key, dataset: xr.Dataset) -> list[Score]:
    """The largest one of a full-order run; models keep none."""
    if "balance" not in dataset:
        return []
    value = np.fmax.reduce(np.ravel(dataset["balance"].values), initial=np.nan)
    ended = Tally(np.ravel(dataset["outcome"].values).astype(str))
    return [_balance_of(key, key.name, value, float(dataset["seconds"]), ended)]


def _balances(key: Key, study: xr.Dataset) -> list[Score]:
    """Those of every fit of a scene, in the runs that the scene has."""
    found = []
    fits = [study[name].values.tolist() for name in ("model", "model_seed", "outcome")]
    for run in MODEL_RUNS:
        values = study[f"{run}_balance"].values if f"{run}_balance" in study else np.empty(0)
        if np.isnan(values).all():
            continue
        for value, model, seed, ended in zip(values, *fits):
            whose = key._replace(model=model, seed=None if seed == FITTED_ONCE else int(seed))
            word = Outcome.UNBALANCED if value > study.attrs["tolerance"] else ended
            found.append(_balance_of(whose, run, value, np.nan, Tally([word])))
    return found


def _balance_of(key: Key, run: str, value: float, seconds: float, ended: Tally) -> Score:
    percent = 100.0 * float(value)
    return Score(*key[:3], BALANCE, f"{run}_percent", percent, "percent", seconds, ended)


def endings(
    collection: Collection, scores: Scores, scene: str, method: str, experiment: str
) -> Tally:
    """What became of the seeds; a model that took no part says why, if its fit knows."""
    found = scores.outcome(scene, method, experiment)
    if found:
        return found
    fits = [fit for fit in collection.every(scene, method, "rom") if fit is not None]
    return Tally(ended for fit in fits if (ended := outcome(fit)) is not Outcome.OK)
