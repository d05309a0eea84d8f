"""The study of what accuracy costs in time: settings of the full order and of the methods, with the
error and the seconds of each answer. Three tables and three figures share this.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import xarray as xr

from vibrom.artefacts.identity import FITTED_ONCE
from vibrom.artefacts.outcome import Outcome, Tally
from vibrom.report.collection import FULL_ORDER, Collection
from vibrom.report.scores import spread

EXPERIMENTS = ("decay", "forced", "frc")  # that methods are evaluated on
CONFIGURED = "as configured"  # what is varied of a model of the run


class Answer(NamedTuple):
    """To one question, with one setting."""

    error: float  # %, NaN where there is none
    seconds: float
    outcome: Outcome


def studied(collection: Collection, what: str) -> dict[str, xr.Dataset]:
    """Scene -> its study, `cost_full_order` or `cost_reduced`."""
    found = {scene: collection.find(scene, FULL_ORDER, what) for scene in collection.scenes}
    return {scene: dataset for scene, dataset in found.items() if dataset is not None}


def missing(collection: Collection, what: str) -> list[dict]:
    """A row for each scene that was not studied."""
    known = studied(collection, what)
    row = {"method": FULL_ORDER, "outcome": Outcome.NOT_RUN}
    return [{"case": scene} | row for scene in collection.scenes if scene not in known]


def answers(dataset: xr.Dataset, setting: int) -> dict[str, Answer]:
    """Question -> answer."""
    row = dataset.isel(setting=setting)
    columns = (row[name].values.tolist() for name in ("error", "seconds", "outcome"))
    return {
        str(name): Answer(error if np.isfinite(error) else np.nan, seconds, Outcome(str(word)))
        for name, error, seconds, word in zip(dataset["question"].values, *columns)
    }


def tally(given: dict[str, Answer]) -> Tally:
    """How the questions ended that were put."""
    return Tally(
        answer.outcome for answer in given.values() if answer.outcome is not Outcome.NOT_RUN
    )


class Setting(NamedTuple):
    """One setting of a method, fitted from one seed."""

    scene: str
    method: str
    seed: int | None
    varied: str  # name of the setting, or `as configured`
    set_to: str
    data: float  # s, and so on
    mapping: float
    dynamics: float
    answers: dict[str, Answer]


def settings(collection: Collection) -> list[Setting]:
    """All that were studied."""
    found = []
    for scene, dataset in studied(collection, "cost_reduced").items():
        for index in range(dataset.sizes["setting"]):
            one = dataset.isel(setting=index)
            seed = int(one["model_seed"])
            found.append(
                Setting(
                    scene,
                    str(one["model"].values),
                    None if seed == FITTED_ONCE else seed,
                    str(one["varied"].values),
                    str(one["value"].values),
                    *(float(one[f"{name}_seconds"]) for name in ("data", "mapping", "dynamics")),
                    answers(dataset, index),
                )
            )
    return found


class Pooled(NamedTuple):
    """A setting over its seeds: medians, a failed seed counting as infinitely wrong."""

    scene: str
    method: str
    varied: str
    set_to: str
    fit: float  # s, mapping and dynamics
    offline: float  # s, training data included
    error: dict[str, float]  # % by question, NaN where the median seed failed
    online: dict[str, float]  # s by question


def pooled(collection: Collection) -> list[Pooled]:
    """All settings that were studied."""
    groups: dict[tuple, list[Setting]] = {}
    for one in settings(collection):
        groups.setdefault((one.scene, one.method, one.varied, one.set_to), []).append(one)
    return [_pool(identity, seeds) for identity, seeds in groups.items()]


def _pool(identity: tuple, seeds: list[Setting]) -> Pooled:
    fit = [one.mapping + one.dynamics for one in seeds]
    offline = [np.nansum([one.data, one.mapping, one.dynamics]) for one in seeds]
    return Pooled(
        *identity,
        fit=_median(fit),
        offline=_median(offline),
        error={
            name: spread((one.answers[name].error for one in seeds), worst=True).median
            for name in EXPERIMENTS
        },
        online={
            name: spread((one.answers[name].seconds for one in seeds), worst=False).median
            for name in EXPERIMENTS
        },
    )


def _median(values: Iterable[float]) -> float:
    """Of those that are known."""
    good = [value for value in values if np.isfinite(value)]
    return float(np.median(good)) if good else np.nan


def of_methods(found: list[Pooled]) -> dict[str, list[Pooled]]:
    """Method -> its settings."""
    methods: dict[str, list[Pooled]] = {}
    for one in found:
        methods.setdefault(one.method, []).append(one)
    return methods


def scheme_words(scheme: str, alpha: float) -> str:
    """A time integration: `α = 0.005` of Newmark's method, or `generalised alpha, α = 0.1`."""
    return ("" if scheme == "newmark" else f"{scheme.replace('_', ' ')}, ") + f"α = {alpha:g}"
