"""What a reproduction of the thesis promises, row by row: our number, its bound, and whether it is
met.

Frequency, release states and forced tip displacements are compared with a reference reproduction of
the thesis's beam, errors and eigenvalues with the thesis's tables. A case whose body or effects are
not the thesis's is not compared, nor an answer that depends on another release or another forcing.
A missing number is not met. Every forced and frc cell of any case must have a value or say why not.
With its guard (table `guards`) a model must follow the folding response curve all the way.
"""

from collections.abc import Iterator

import numpy as np
import pandas as pd
import xarray as xr

from vibrom.report import curves, stability
from vibrom.report.collection import (
    FULL_ORDER,
    UNSEEDED,
    Collection,
    answered,
    at_probe,
    described,
    scalar,
)
from vibrom.report.scores import Scores
from vibrom.thesis import published as thesis

COLUMNS = ("case", "method", "quantity", "value", "unit", "bound", "met", "source")
BODY = {"length": 1.0, "height": 0.02, "width": 0.05, "cells": [40, 2], "element": "bilinear"}
EFFECTS = {
    "inertia": {"density": 440.0},
    "elasticity": {"young_modulus": 104.0e9, "poisson_ratio": 0.3, "plane": "stress"},
    "geometric_nonlinearity": {},
    "rayleigh_damping": {"damping_ratio": 0.01},
    "modal_load": {"mode": 1},
}
OMEGA_1 = 398.0524  # rad/s
# case: (forcing of run and response curve, largest tip displacement of the last period [m],
# tolerance in %)
FORCED_TIP = {
    "small": (1.0, 0.00095, 0.5),  # printed with two digits
    "large": (600.0, 0.4678, 0.2),
    "folding": (6000.0, 0.8285, 0.2),
}
DETERMINISTIC = ("modal_projection", "ssmlearn")
TRAINED = ("decoupled_autoencoder", "sindy_autoencoder", "split", "split_plus")
GUARDED = {
    "split_plus": "dissipative_9",
    "decoupled_autoencoder": "dissipative_9",
}  # of the folding scene; the guard by its name in config.yaml
PARTS = {"real_per_s": ("real part", "1/s"), "imaginary_rad_per_s": ("imaginary part", "rad/s")}
TABLE = {"eigenvalues": "3.2", "reconstruction": "3.3", "decay": "3.4", "forced": "3.5"}
# release states and forced runs of the scene that a model's answer depends on, its training's
# included
BEHIND = {
    "reconstruction": {"train", "test"},
    "decay": {"train", "test"},
    "eigenvalues": {"train"},
    "forced": {"train", "forced"},
    "frc": {"train", "frc"},
}
REFERENCE, PROMISE = "reference reproduction", "promise"


def table(collection: Collection, scores: Scores) -> pd.DataFrame:
    """One row a promise, of what this run was asked."""
    asked = {key[3] for key in collection.loaders}
    hard = stability.guards(collection)
    rows: list[tuple] = []
    for scene in collection.scenes:
        structure = collection.find(scene, FULL_ORDER, "structure")
        if structure is not None and scene in FORCED_TIP and reproduces(structure):
            same = as_printed(scene, collection)
            comparable = {experiment for experiment, parts in BEHIND.items() if parts <= same}
            rows += [
                (scene, FULL_ORDER, *row) for row in full_order(scene, structure, collection, same)
            ]
            for method in collection.methods:
                rows += [
                    (scene, method, *row)
                    for row in reduced(scene, method, scores, asked & comparable)
                ]
            if scene == "folding" and "frc" in comparable:
                rows += [(scene, *row) for row in guarded(hard[hard["case"] == scene])]
        for model in [FULL_ORDER, *collection.methods]:
            rows += [(scene, model, *row) for row in cells(scene, model, collection, scores, asked)]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def reproduces(structure: xr.Dataset) -> bool:
    """Whether the scene's body and effects are the thesis's."""
    body, effects = described(structure, "body"), described(structure, "effects")
    effects = {name: {**EFFECTS.get(name, {}), **(keys or {})} for name, keys in effects.items()}
    return {**body, **BODY} == body and effects == EFFECTS


def as_printed(scene: str, collection: Collection) -> set[str]:
    """Which of the release states `train` and `test` and of the runs `forced` and `frc` are the
    thesis's, not changed by the user's wish; what is missing counts.
    """
    same, release = set(), collection.find(scene, FULL_ORDER, "release")
    recipes = {} if release is None else described(release, "releases")
    for role in ("train", "test"):
        state = thesis.state(scene, role)
        recipe = recipes.get(role, state)
        if (recipe["forcing"], recipe["step"]) == (state["forcing"], state["step"]):
            same.add(role)
    forcing = FORCED_TIP[scene][0]
    return same | {
        name
        for name in ("forced", "frc")
        if float(scalar(collection.find(scene, FULL_ORDER, name), "forcing", forcing)) == forcing
    }


def within(
    quantity: str, value: float, unit: str, reference: float, tolerance: float, source: str
) -> tuple:
    """`tolerance` in % of the reference."""
    met = abs(value - reference) <= tolerance / 100 * abs(reference)
    return quantity, value, unit, f"{reference:.6g} within {tolerance:g} %", yes(met), source


def at_most(quantity: str, value: float, bound: float, source: str) -> tuple:
    return quantity, value, "%", f"at most {bound:.6g}", yes(value <= bound), source


def yes(met) -> str:
    return "yes" if met else "no"


def full_order(
    scene: str, structure: xr.Dataset, collection: Collection, same: set[str]
) -> Iterator[tuple]:
    omega = float(structure["frequency"].values[0])
    close = abs(omega - OMEGA_1) <= 0.001
    yield "omega_1", omega, "rad/s", f"{OMEGA_1} within 0.001", yes(close), REFERENCE
    release = collection.find(scene, FULL_ORDER, "release")
    for role in sorted(same & {"train", "test"}, reverse=True):
        state = thesis.state(scene, role)
        for probe in ("probe", "tip", "tip_x"):
            value = released(structure, release, role, probe)
            yield within(
                f"{role} release, {probe}", value, "m", state[f"{probe}_m"], 0.1, REFERENCE
            )
    forced = collection.find(scene, FULL_ORDER, "forced")
    _, tip, tolerance = FORCED_TIP[scene]
    if forced is not None and "forced" in same:
        yield within("forced, largest tip", largest_tip(forced), "m", tip, tolerance, REFERENCE)


def released(structure: xr.Dataset, release: xr.Dataset | None, role: str, probe: str) -> float:
    names = [str(name) for name in structure["probe"].values]
    if release is None or probe not in names or role not in release["role"].values:
        return np.nan
    return float(
        release["displacement"]
        .sel(role=role)
        .values[int(structure["probe_dof"].values[names.index(probe)])]
    )


def largest_tip(forced: xr.Dataset) -> float:
    """Over the last period [m]; NaN where the run did not reach it."""
    motion = at_probe(forced, "probe_displacement", "tip")
    if motion is None or str(scalar(forced, "outcome", "ok")) != "ok":
        return np.nan
    return float(
        np.abs(motion[forced["time"].values >= forced["last_time"].values[0] - 1e-9]).max()
    )


def reduced(scene: str, method: str, scores: Scores, asked: set[str]) -> Iterator[tuple]:
    def error(experiment: str) -> float:
        return scores.spread(scene, method, experiment, "nmte_percent").median

    def printed(experiment: str) -> float:
        return thesis.percent(experiment, scene, method)[0]

    def part(name: str, model: str) -> float:
        return scores.spread(scene, model, "eigenvalues", name, worst=False).median

    fixed, trained = method in DETERMINISTIC, method in TRAINED
    for experiment, tolerance in (("reconstruction", 0.5), ("decay", 4.0)):
        what = (f"{experiment} NMTE", error(experiment))
        if fixed and experiment in asked:
            yield within(*what, "%", printed(experiment), tolerance, source(experiment))
        if trained and experiment in asked:
            yield at_most(*what, printed(experiment), source(experiment))
    if fixed and "eigenvalues" in asked:
        for (name, (words, unit)), known in zip(PARTS.items(), thesis.eigenvalue(scene, method)):
            yield within(
                f"eigenvalue, {words}", part(name, method), unit, known, 0.5, source("eigenvalues")
            )
    if method == "sindy_autoencoder" and "decay" in asked:
        yield "decay NMTE", error("decay"), "%", "below 10", yes(error("decay") < 10), PROMISE
    if method == "sindy_autoencoder" and "eigenvalues" in asked:
        ours, full = (part("imaginary_rad_per_s", model) for model in (method, FULL_ORDER))
        yield within("eigenvalue, imaginary part", ours, "rad/s", full, 5.0, "full order")
        real = part("real_per_s", method)
        yield "eigenvalue, real part", real, "1/s", "below 0", yes(real < 0), PROMISE
    if method == "split_plus" and "forced" in asked:
        yield at_most("forced NMTE", error("forced"), printed("forced"), source("forced"))


def guarded(hard: pd.DataFrame) -> Iterator[tuple]:
    """Response curves of guarded models: no gaps, and medians over seeds of the error and of the
    peak's height and place.
    """
    for method, guard in GUARDED.items():
        for _, row in hard[(hard["method"] == method) & (hard["guard"] == guard)].iterrows():
            lost = row["points"] - row["points_with_value"]
            yield (
                method,
                f"frc with guard {guard}, points without value",
                lost,
                "1",
                "0",
                yes(lost == 0),
                PROMISE,
            )
            error, peak, steps = (
                row["median_amplitude_error_percent"],
                row["peak_error_percent"],
                row["peak_steps"],
            )
            yield (
                method,
                *at_most(f"frc with guard {guard}, median amplitude error", error, 2.0, PROMISE),
            )
            yield (
                method,
                f"frc with guard {guard}, peak amplitude",
                peak,
                "%",
                "0 within 3",
                yes(abs(peak) <= 3.0),
                PROMISE,
            )
            yield (
                method,
                f"frc with guard {guard}, place of the peak",
                steps,
                "1",
                "at most 1",
                yes(steps <= 1),
                PROMISE,
            )


def source(experiment: str) -> str:
    return f"thesis, Table {TABLE[experiment]}"


def cells(
    scene: str, model: str, collection: Collection, scores: Scores, asked: set[str]
) -> Iterator[tuple]:
    """How many seeds (forced) or points (frc) of a model have neither a value nor an outcome that
    says why.
    """
    seeds = [UNSEEDED] if model == FULL_ORDER else collection.seeds(scene, model)
    for experiment in ("forced", "frc"):
        if experiment in asked:
            runs = {seed: collection.find(scene, model, experiment, seed) for seed in seeds}
            lost = sum(
                empty(experiment, run, scene, model, seed, collection, scores)
                for seed, run in runs.items()
            )
            yield (
                f"{experiment}, cells without value or outcome",
                lost,
                "1",
                "0",
                yes(seeds and lost == 0),
                PROMISE,
            )


def empty(
    experiment, run: xr.Dataset | None, scene, model, seed, collection: Collection, scores: Scores
) -> int:
    if run is None:
        return 1
    if experiment == "frc":
        truth = collection.find(scene, FULL_ORDER, "frc")
        if not answered(run) and truth is None:
            return int(str(np.atleast_1d(run["outcome"].values)[0]) in ("ok", "", "nan"))
        points = curves.points(run, scene, model, seed, truth)
        return int(
            (points["probe_amplitude_m"].isna() & points["outcome"].isin(["ok", "", "nan"])).sum()
        )
    if str(scalar(run, "outcome", "ok")) not in ("ok", "", "nan"):
        return 0
    value = (
        run["probe_displacement"].values[:, -1]
        if model == FULL_ORDER
        else scores.value(scene, model, seed, "forced", "nmte_percent")
    )
    return int(not np.isfinite(value).all())
