"""What the accuracy of reduced models costs, setting by setting.

Every model of the run is a setting as it was configured, with the errors and seconds that the run
measured. Then one setting after the other is varied, the others being those of the configuration.
Besides the method's own settings: `thin` (train on every k-th sample), `periods` (on the first k
periods of the training decay, whose share of the simulation counts), `start.<setting>` (of the
method that this one starts from) and `rtol` (of the integrator; atol a hundredth of it). Each model
is evaluated on the test decay, the forced run and the response curve of the scene, with the errors
of those experiments: NMTE, NMTE of the last period, median error of the amplitude. A value that
does not go with the method's other settings is `skipped`.

Offline seconds are those of the training data, the mapping (that of a model to start from included)
and the dynamics; online ones those of one answer. What the study measures itself are medians of
repeated calls, after one that compiles; what takes long is not repeated, `calls` and `fits` say how
often.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from vibrom.artefacts.identity import FITTED_ONCE
from vibrom.artefacts.outcome import Outcome, worst
from vibrom.artefacts.progress import bar
from vibrom.models.reduced import Reduced
from vibrom.models.rollout import Integrator
from vibrom.models.training import MethodError
from vibrom.studies import Case, Fitted
from vibrom.studies.cost import Cost
from vibrom.studies.parts.fits import Fit, Fits, Recipe
from vibrom.studies.parts.records import Column, stacked, text
from vibrom.studies.parts.timing import Measured, columns, entries, repeated

ERRORS = {
    "decay": "nmte_percent",
    "forced": "nmte_percent",
    "frc": "amplitude_error_median_percent",
}
QUESTIONS = tuple(ERRORS)
# Settings that a fitted model or its integration has, so that they need no new fit.
ONLINE = ("rtol", "force_rule")
DATA = ("thin", "periods")
START = "start."
CONFIGURED = "as configured"
COLUMNS = {
    "model": Column("1", "method", missing=""),
    "model_seed": Column("1", "seed, -1 where it is fitted once"),
    "varied": Column("1", "setting that is varied", missing=""),
    "value": Column("1", "its value", missing=""),
    "data_seconds": Column("s", "wall time of the training data"),
    "mapping_seconds": Column(
        "s", "wall time of the mapping, that of a model to start from included"
    ),
    "dynamics_seconds": Column("s", "wall time of the dynamics after the mapping"),
    "fits": Column("1", "fits behind the median"),
    **columns(
        error="NMTE of decay and forced run, median amplitude error of the response curve",
        seconds="median wall time of one answer",
        calls="answers behind the median",
        outcome="how the answer ended; of a response curve its worst point",
    ),
}


def made(study: Cost, case: Case) -> xr.Dataset:
    """One entry a setting and question."""
    # A method is varied where it takes part in the run.
    wanted = [
        (method, dict.fromkeys(sweep.vary, value))
        for method, sweeps in study.reduced.items()
        if method in case.methods
        for sweep in sweeps
        for value in sweep.over
    ]
    data = float(case.full_order["train"]["seconds"])
    records = [configured(model, data) for model in case.fitted]
    title = f"{case.structure.attrs['scene']}: what the methods cost"
    with bar(title, len(wanted), "settings") as advance:
        for record in varied(study, case, wanted):
            records.append(record)
            advance(1)
    return xr.Dataset(
        stacked(records, {"setting": len(records)}, COLUMNS, {"question": len(QUESTIONS)}),
        coords={"question": text("question", QUESTIONS, "what is evaluated")},
    )


def configured(model: Fitted, data: float) -> dict[str, Any]:
    """A model of the run whose training data took `data` seconds, and its answers as the run has
    them.
    """
    about = {
        "model": model.record.attrs["method"],
        "model_seed": int(model.record.attrs["seed"]),
        "varied": CONFIGURED,
    }
    return about | Fit.of_run(model, data).record | entries(known(model), QUESTIONS)


def known(model: Fitted) -> dict[str, Measured]:
    """What the run measured of a model."""
    found = {}
    for question, error in ERRORS.items():
        answer = model.answers[question]
        found[question] = Measured(worst(np.ravel(answer["outcome"].values)))
        if answer.attrs.get("answered", 0):
            value = float(answer["score_value"].sel(score=error))
            seconds = float(answer["seconds"])
            found[question] = found[question]._replace(error=value, seconds=seconds, calls=1)
    return found


def varied(
    study: Cost, case: Case, wanted: list[tuple[str, dict[str, Any]]]
) -> Iterator[dict[str, Any]]:
    """A record of each method with these changes; models that the run has anyway are not fitted
    again.
    """
    fits = Fits(case, study.repeats, study.patience)
    for model in case.fitted:
        if int(model.record.attrs["seed"]) in (case.seed, FITTED_ONCE):
            fits.add(recipe(case, model.record.attrs["method"], {}), model, known(model))
    for method, changes in wanted:
        offline = {key: value for key, value in changes.items() if key not in ONLINE}
        fit = fits.of(recipe(case, method, offline))
        integrator = Integrator(**case.integrator)
        if len(offline) < len(changes):
            fit, integrator = online(fit, integrator, changes)
        about = {
            "model": method,
            "model_seed": case.seed if case.methods[method]["seeded"] else FITTED_ONCE,
            "varied": ", ".join(changes),
            "value": str(next(iter(changes.values()))),
        }
        answers = {name: measured(study, case, fit, name, integrator) for name in QUESTIONS}
        yield about | fit.record | entries(answers, QUESTIONS)


def recipe(case: Case, method: str, changes: Mapping[str, Any]) -> Recipe:
    """How a method is fitted with these changes."""
    block = case.methods[method]
    data = {key: changes[key] for key in DATA if key in changes}
    of_start = {
        key.removeprefix(START): value for key, value in changes.items() if key.startswith(START)
    }
    own = {
        key: value
        for key, value in changes.items()
        if key not in data and not key.startswith(START)
    }
    start = recipe(case, block["start"], of_start | data) if block["start"] else None
    return Recipe(block["kind"], {**block["settings"], **own}, start=start, **data)


def online(fit: Fit, integrator: Integrator, changes: Mapping[str, Any]) -> tuple[Fit, Integrator]:
    """A fitted model, and its integrator, with what needs no new fit."""
    fit = replace(fit, answers={})
    if "rtol" in changes:
        integrator = replace(integrator, rtol=changes["rtol"], atol=changes["rtol"] / 100)
    if "force_rule" in changes and fit.rom is not None:
        rule: dict[str, Any] = {"force_rule": changes["force_rule"]}
        fit = replace(fit, rom=replace(fit.rom, **rule))
    return fit, integrator


def measured(study: Cost, case: Case, fit: Fit, name: str, integrator: Integrator) -> Measured:
    """Error and time of an answer."""
    if name in fit.answers:
        return fit.answers[name]
    if fit.rom is None or not case.is_comparable(name):
        return Measured(fit.outcome if fit.rom is None else Outcome.REFERENCE_FAILED)
    question, given = case.question(name), case.given
    model = Reduced.of_scene(fit.rom, case.structure, integrator)

    def call() -> tuple[xr.Dataset, float]:
        answer = question.ask(model, given)
        return answer, float(answer["seconds"])

    try:
        question.brief().ask(model, given)  # loads and compiles
        answer, seconds, calls = repeated(call, study.repeats, study.patience)
    except MethodError:
        return Measured(Outcome.UNSUPPORTED)
    error = question.score(answer, case.truth(name))[ERRORS[name]]
    return Measured(worst(np.ravel(answer["outcome"].values)), error, seconds, calls)
