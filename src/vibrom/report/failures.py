"""Everything that did not end well, in one table: which model, evaluated on what, how it ended,
when, and with which seeds.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial

import numpy as np

from vibrom.artefacts.outcome import Outcome, Severity, Tally
from vibrom.report import curves
from vibrom.report.collection import FULL_ORDER, Collection, outcome, scalar
from vibrom.report.columns import CASE, GONE, METHOD, OUTCOME, Column, number
from vibrom.report.scores import Scores
from vibrom.report.table import Table, printed, table

COLUMNS = (
    CASE,
    METHOD,
    Column("experiment", "Evaluated"),
    OUTCOME,
    Column("seeds", "Seeds"),
    Column("when", "When [s]"),
    Column("error", "NMTE [%]"),
)


@dataclass
class Failure:
    """One row; `experiments` that ended in the same way at the same time share it."""

    case: str
    method: str
    experiments: list[str]
    outcome: str
    severity: Severity
    when: str
    seeds: str = GONE
    error: str = GONE

    @property
    def row(self) -> dict:
        """Its cells."""
        names = ("case", "method", "outcome", "seeds", "when", "error")
        cells = {name: getattr(self, name) for name in names}
        return cells | {"experiment": ", ".join(self.experiments)}


def build(collection: Collection, scores: Scores) -> Table:
    """All outcomes but `ok`, those without a value first."""
    rows = [*full_order(collection), *ablation(collection)]
    rows += [*predictions(collection, scores), *response_curves(collection)]
    scenes = collection.scenes
    rows.sort(key=lambda row: (scenes.index(row.case), row.severity is Severity.NOTE))
    shown = partial(printed, marked=lambda row: "")
    return table("failures", COLUMNS, [row.row for row in rows], shown)


def full_order(collection: Collection) -> Iterable[Failure]:
    """Its decays and its forced run."""
    for scene in collection.scenes:
        for name in ("train", "test", "forced"):
            run = collection.find(scene, FULL_ORDER, name)
            if run is not None and outcome(run) is not Outcome.OK:
                ended, when = outcome(run), number(float(scalar(run, "failed_at")))
                yield Failure(scene, FULL_ORDER, [name], ended, ended.severity, when)


def ablation(collection: Collection) -> Iterable[Failure]:
    """Scenes without one effect; an effect that cannot be left out is no failure."""
    for scene in collection.scenes:
        study = collection.find(scene, FULL_ORDER, "ablation")
        for place in range(0 if study is None else study.sizes["left_out"]):
            less = study.isel(left_out=place)
            ended = outcome(less)
            if ended.severity is Severity.FAILURE:
                when = number(float(less["failed_at"]))
                what = [f"without {less['left_out'].item()}"]
                yield Failure(scene, FULL_ORDER, what, ended, ended.severity, when)


def predictions(collection: Collection, scores: Scores) -> Iterable[Failure]:
    """One row for all seeds and experiments of a model that ended alike at the same time."""
    found: dict[tuple, Failure] = {}
    groups: dict[tuple, dict[int | None, list[float]]] = {}
    for score in scores.rows:
        # The points of the response curves have rows of their own.
        if score.experiment != "frc":
            for ended in score.outcome:
                if ended is not Outcome.OK:
                    key = score.scene, score.method, score.experiment, ended
                    errors = groups.setdefault(key, {}).setdefault(score.seed, [])
                    errors += [score.value] if score.metric == "nmte_percent" else []
    for (scene, method, experiment, ended), seeds in groups.items():
        runs = [collection.find(scene, method, experiment, seed) for seed in seeds]
        when = extent(time for run in runs for time in np.ravel(scalar(run, "failed_at")))
        new = Failure(scene, method, [], ended, ended.severity, when, seed_list(seeds))
        made = found.setdefault((scene, method, ended, new.seeds, when), new)
        made.experiments.append(experiment.replace("_", " "))
        if made.error == GONE:
            made.error = extent(error for errors in seeds.values() for error in errors)
    return found.values()


def response_curves(collection: Collection) -> Iterable[Failure]:
    """Points that failed or left the training range."""
    for scene, model in collection.models:
        truth, found = collection.find(scene, FULL_ORDER, "frc"), {}
        tally = Tally()
        for seed in collection.seeds(scene, model):
            curve = collection.find(scene, model, "frc", seed)
            if curve is None:
                continue
            points = len(curves.frequencies(curve, truth))
            ended = curves.outcomes(curve, points)
            tally.update(ended)
            failed_at = np.broadcast_to(curve["failed_at"].values, points)
            for one, when in zip(ended, failed_at):
                if one is not Outcome.OK:
                    found.setdefault(one, {}).setdefault(seed, []).append(float(when))
        for ended, seeds in found.items():
            text = f"{ended}: {tally[ended]} of {tally.total()} points"
            when = extent(time for times in seeds.values() for time in times)
            what = ["response curve"]
            yield Failure(scene, model, what, text, ended.severity, when, seed_list(seeds))


def seed_list(seeds: Iterable[int | None]) -> str:
    """Their numbers; none of a model that is fitted once."""
    return ", ".join(str(seed) for seed in seeds if seed is not None) or GONE


def extent(values: Iterable[float]) -> str:
    """One number, or the smallest and the largest."""
    good = [value for value in values if np.isfinite(value)]
    if not good:
        return GONE
    low, high = number(min(good), 3), number(max(good), 3)
    return low if low == high else f"{low} to {high}"
