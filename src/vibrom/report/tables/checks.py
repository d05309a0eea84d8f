"""What the reproduction promises, and whether it is kept

Our number beside the bound that it has to meet. First frequency, release states and largest tip
displacement under forcing are compared with a reference reproduction of the thesis's beam, errors
and eigenvalues with the tables of the thesis; errors are medians over seeds, and a failed seed
counts as infinitely wrong. A missing number is not met. A case with another body or other effects
than the thesis's is not compared with it, nor an answer that depends on another release or
another forcing: a row says so.

Models from the equations of motion must follow decays, those without errors of the time
integration too (table "decay"), and response curves at every frequency, and be made in time.

Of the folding case, SPLIT+ and the decoupled autoencoder must follow the response curve all the
way with their guards (table "guards"): no point without a value, the median amplitude error, the
peak and its place within bounds, as medians over seeds.

The last rows of each case count the forced runs and the points of the response curves that have
neither a value nor an outcome that says why not.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

from vibrom.artefacts.identity import differences
from vibrom.config import plugs
from vibrom.report import curves, robustness
from vibrom.report.branches import landmark
from vibrom.report.collection import (
    FULL_ORDER,
    Collection,
    answered,
    at_probe,
    described,
    outcome,
    probe_dof,
    scalar,
)
from vibrom.report.columns import CASE, METHOD, Column, number
from vibrom.report.scores import Scores, offline
from vibrom.report.table import FAILED, printed
from vibrom.thesis import promises, published

FAMILY = "models"
PLACE = 90
ALSO = ["robustness"]  # what guards promise
COLUMNS = (
    CASE,
    METHOD,
    Column("quantity", "Quantity"),
    Column("value", "Ours", text=lambda row: number(row["value"], 6)),
    Column("unit", "Unit"),
    Column("bound", "Bound"),
    Column("met", "Met"),
    Column("source", "Source"),
)
NOT_COMPARED = "not compared"
ERRORS = ("reconstruction", "decay", "forced", "frc")  # a failed seed is infinitely wrong


def shown(rows, columns):
    """What is not met is marked."""
    return printed(rows, columns, lambda row: FAILED if row["met"] == "no" else "")


def build(collection, scores):
    """One row a promise, of what was part of this run."""
    rows = []
    for scene in collection.scenes:
        for model in (FULL_ORDER, *collection.methods):
            rows += compared(scene, model, collection, scores)
        for model in (FULL_ORDER, *collection.methods):
            for promise, value in complete(scene, model, collection, scores):
                rows.append(row(scene, value, promise))
    return rows


def compared(
    scene: str, model: str, collection: Collection, scores: Scores
) -> Iterator[dict[str, Any]]:
    """A row for each promise that this run can be held to, and one that says why for the others."""
    structure = collection.find(scene, FULL_ORDER, "structure")
    if structure is None or scene not in promises.FORCING:
        return
    if other := unlike(structure):
        if model == FULL_ORDER:
            yield not_compared(scene, model, "all of the thesis's numbers", other)
        return
    frequency = scores.spread(scene, FULL_ORDER, "eigenvalues", "imaginary_rad_per_s").median
    same, left = as_printed(scene, collection), []
    made = (
        promises.of_full_order(scene)
        if model == FULL_ORDER
        else promises.of_method(scene, model, frequency)
    )
    for promise in made:
        value = measured(promise.at, scene, model, collection, scores)
        if not promise.needs <= same:
            left.append(promise)
        elif value is not None:
            yield row(scene, value, promise)
    if left:
        quantities = ", ".join(promise.quantity for promise in left)
        others = sorted({need for promise in left for need in promise.needs} - same)
        yield not_compared(scene, model, quantities, f"not the thesis's: {', '.join(others)}")


def row(scene: str, value: float, promise: promises.Promise) -> dict:
    """Our number, and whether the promise is kept."""
    return {
        "case": scene,
        "method": promise.method,
        "quantity": promise.quantity,
        "value": value,
        "unit": promise.unit,
        "bound": promise.bound.text,
        "met": "yes" if promise.bound.met(value) else "no",
        "source": promise.source,
    }


def not_compared(scene: str, model: str, quantity: str, why: str) -> dict[str, Any]:
    """A promise that this run cannot be held to."""
    empty = {"value": np.nan, "unit": "1", "bound": "", "met": NOT_COMPARED, "source": why}
    return {"case": scene, "method": model, "quantity": quantity, **empty}


def unlike(structure: xr.Dataset) -> str:
    """Where the scene's body or effects are not the thesis's; empty where they are."""
    body, effects = described(structure, "body"), described(structure, "effects")
    own = {"body": body, "effects": completed(effects)}
    known = {"body": {**body, **promises.BODY}, "effects": completed(promises.EFFECTS)}
    for where, ours, theirs in differences(own, known):
        return f"{where}{ours!r}, and not {theirs!r}"
    return ""


def completed(effects: dict[str, Any]) -> dict[str, Any]:
    """With the defaults that the effects declare; a list of settings stays what it is."""
    known = plugs.names("effects")
    defaults = {
        name: plugs.defaults_of(plugs.settings_of("effects", name)) if name in known else {}
        for name in effects
    }
    return {
        name: keys if isinstance(keys, list) else {**defaults[name], **(keys or {})}
        for name, keys in effects.items()
    }


def as_printed(scene: str, collection: Collection) -> set[str]:
    """Which of the releases `train` and `test` and of the forcings of `forced`, `frc` and
    `branches` are the thesis's, not changed by the user's wish; what is missing counts.
    """
    recipes = described(collection.find(scene, FULL_ORDER, "release"), "releases")
    same = set()
    for role in ("train", "test"):
        state = published.state(scene, role)
        recipe = recipes.get(role, state)
        alike = (recipe["forcing"], recipe["step"]) == (state["forcing"], state["step"])
        if alike and not recipe.get("velocity"):
            same.add(role)
    for name in ("forced", "frc", "branches"):
        own = promises.FORCING[scene]
        if float(scalar(collection.find(scene, FULL_ORDER, name), "forcing", own)) == own:
            same.add(name)
    return same


def measured(
    at: tuple[str, ...], scene: str, model: str, collection: Collection, scores: Scores
) -> float | None:
    """Our number; None where the run was to have none."""
    place, *rest = at
    if place == "structure":
        return float(collection.find(scene, FULL_ORDER, "structure")["frequency"].values[0])
    if place == "release":
        return released(scene, *rest, collection)
    if place == "guards":
        found = robustness.guarded(collection, scene, model, rest[0])
        return None if found is None else found[rest[1]]
    if place == "offline":
        return offline(scores.seconds(scene, model))
    if place not in {key.name for key in collection.loaders}:
        return None
    if place == "branches" and model == FULL_ORDER:
        return landmark(collection, scene, rest[0])
    if model == FULL_ORDER:
        return largest_tip(collection.find(scene, FULL_ORDER, "forced"))
    return scores.spread(scene, model, place, rest[0], worst=place in ERRORS).median


def released(scene: str, role: str, probe: str, collection: Collection) -> float:
    """Displacement of a probe in a release state [m]."""
    structure, release = (
        collection.find(scene, FULL_ORDER, name) for name in ("structure", "release")
    )
    dof = probe_dof(structure, probe)
    if release is None or dof is None or role not in release["role"].values:
        return np.nan
    return float(release["displacement"].sel(role=role).values[dof])


def largest_tip(forced) -> float:
    """Over the last period [m]; NaN where the run did not reach it."""
    motion = None if forced is None else at_probe(forced, "probe_displacement", "tip")
    if motion is None or not outcome(forced).has_value:
        return np.nan
    last = forced["time"].values >= forced["last_time"].values[0] - 1e-9
    return float(np.abs(motion[last]).max())


def complete(
    scene: str, model: str, collection: Collection, scores: Scores
) -> Iterator[tuple[promises.Promise, float]]:
    """How many seeds (forced) or points (frc) of a model have no value, though no outcome says why;
    of a model without seeds all are lost (NaN). What no method was asked is not lost.
    """
    seeds, full = collection.seeds(scene, model), model == FULL_ORDER
    asked = {key.name for key in collection.loaders if (key.model == FULL_ORDER) == full}
    for experiment in ("forced", "frc"):
        if experiment in asked:
            quantity = f"{experiment}, cells without value or outcome"
            promise = promises.Promise(
                model, quantity, (), "1", promises.ZERO, promises.PROMISE, set()
            )
            lost = sum(empty(experiment, scene, model, seed, collection, scores) for seed in seeds)
            yield promise, float(lost) if seeds else np.nan


def empty(
    experiment: str,
    scene: str,
    model: str,
    seed: int | None,
    collection: Collection,
    scores: Scores,
) -> int:
    """Of one seed."""
    run = collection.find(scene, model, experiment, seed)
    if run is None:
        return 1
    if not answered(run):
        return int(outcome(run).has_value)
    if experiment == "frc":
        amplitude = at_probe(run, "amplitude")
        good = [ended.has_value for ended in curves.outcomes(run, len(amplitude))]
        return int((np.isnan(amplitude) & good).sum())
    value = (
        run["probe_displacement"].values[:, -1]
        if model == FULL_ORDER
        else scores.value(scene, model, seed, "forced", "nmte_percent")
    )
    return int(outcome(run).has_value and not np.isfinite(value).all())
