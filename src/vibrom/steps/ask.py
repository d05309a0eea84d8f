"""A model and questions -> the dataset of each answer with its scores, whatever becomes of it.

The model is opened once, and an answer that another question reads is handed on.
"""

from __future__ import annotations

import importlib
import json
from collections.abc import Callable, Mapping
from functools import cache, partial
from typing import Any

import numpy as np
import xarray as xr

from vibrom.artefacts.data import label, open_dataset, outcome_variables, save_dataset, scored
from vibrom.artefacts.outcome import Outcome
from vibrom.experiments import Experiment, Given, experiment, is_comparable, plug
from vibrom.models.model import Model
from vibrom.models.rom import rom_from_dataset
from vibrom.models.training import Unsupported

KINDS = {"train": "trajectory", "test": "trajectory", "fit": "rom"}
CALLS, ENOUGH = 3, 0.2  # an answer is timed up to three times, or until that took 0.2 s


def run(
    *,
    questions: dict[str, dict[str, Any]],
    names: dict[str, Any],
    samples: int,
    structure: str,
    provenance: dict[str, str],
    rom: str | None = None,
    scene: dict[str, Any] | None = None,
    integrator: dict[str, Any] | None = None,
    **paths: str,
) -> None:
    """`questions` are the settings of each experiment, in an order in which answers are made before
    they are read; `names` are scene, method and seed of the artefacts. A fitted model is at `rom`;
    the full order, which has none, is built from the blocks of `scene`, and is what was measured
    where there are none. `paths` say where each answer is written, by the experiment's name, where
    its truth is, as `truth_<name>`, and where lies what else is read, by name.
    """
    known = open_dataset(structure, "structure")
    fitted = open_dataset(rom, "rom") if rom else None
    opened = cache(partial(open_dataset, lazy=True))
    built = cache(partial(model_of, fitted, known, scene, integrator))
    answered: dict[str, xr.Dataset] = {}
    for name, settings in questions.items():
        question, truth = experiment(name, settings), paths.get(f"truth_{name}")
        reads = {
            need: answered[need]
            if need in answered
            else opened(paths[need], kind(need, fitted is None))
            for need in question.reads
            if need in paths
        }
        true = opened(truth, kind(str(question.truth), False)) if truth else None
        if true is not None and is_skipped(true):  # there is nothing to compare with
            true = None
        given = Given(known, samples, reads, title(**names))
        answer = answer_of(question, built, fitted, given, true)
        about = json.dumps({"experiment": settings, "integrator": integrator}, sort_keys=True)
        answered[name] = label(answer, name, settings=about, **names)
        save_dataset(answered[name], paths[name], provenance)


def answer_of(
    question: Experiment,
    built: Callable[[], Model],
    fitted: xr.Dataset | None,
    given: Given,
    truth: xr.Dataset | None,
) -> xr.Dataset:
    """The scored answer, or an outcome and the reason why there is none."""
    outcome, reason = obstacle(question, fitted, given.answers, truth)
    if outcome.has_value:
        try:
            model = built() if question.of_model else None
            answer = evaluated(question, model, given, truth, warm=fitted is not None)
        except Unsupported as error:
            outcome, reason = Outcome.SKIPPED, str(error)
    if not outcome.has_value:
        answer = unanswered(question, outcome)
    return answer.assign_attrs(reason=reason, answered=int(outcome.has_value))


def title(scene: str, method: str, seed: int | None = None, **_: Any) -> str:
    """What begins a bar of progress."""
    return f"{scene}: {method}" + ("" if seed is None else f", seed {seed}") + ": "


def is_skipped(answer: xr.Dataset) -> bool:
    """Was nothing measured?"""
    return bool((answer["outcome"] == Outcome.SKIPPED).all())


def kind(name: str, of_full_order: bool) -> str:
    """The kind of artefact that stands for `name`: the full order's own decay is its record."""
    if name in KINDS:
        return KINDS[name]
    asked = plug(name)
    recorded = of_full_order and not asked.of_full_order
    return kind(str(asked.truth), of_full_order) if recorded else name


def obstacle(
    question: Experiment,
    fitted: xr.Dataset | None,
    answers: Mapping[str, xr.Dataset],
    truth: xr.Dataset | None,
) -> tuple[Outcome, str]:
    """Why the question cannot be evaluated, as an outcome and a reason; OK if nothing stands in its
    way.
    """
    for source in [
        fitted,
        *(item for key, item in answers.items() if key not in ("train", "test")),
    ]:
        if source is None or source["outcome"].ndim:
            continue
        outcome = Outcome(str(source["outcome"].item()))
        if not outcome.has_value and not source.attrs.get("answered", 0):
            return outcome, str(source.attrs.get("reason", ""))
    records = [item for key, item in answers.items() if key in ("train", "test")]
    for reference in [*records, *([] if truth is None else [truth])]:
        if question.of_model and not is_comparable(reference):
            return Outcome.REFERENCE_FAILED, "the full-order run to compare with stopped early"
    return Outcome.OK, ""


def model_of(
    fitted: xr.Dataset | None,
    known: xr.Dataset,
    scene: dict[str, Any] | None,
    integrator: dict[str, Any] | None,
) -> Model:
    """The model, from its own module: code of the other kind is not behind the answer."""
    if fitted is None and scene is None:
        return importlib.import_module("vibrom.models.measured").Measured.of_scene(known)
    if fitted is None:
        return importlib.import_module("vibrom.models.full_order").FullOrder.of_scene(scene, known)
    module = importlib.import_module("vibrom.models.reduced")
    settings = module.Integrator(**(integrator or {}))
    return module.Reduced.of_scene(rom_from_dataset(fitted), known, settings)


def evaluated(
    question: Experiment, model: Model | None, given: Given, truth: xr.Dataset | None, warm: bool
) -> xr.Dataset:
    """The scored answer, with the least wall time of a few calls: other jobs may run beside it."""
    if warm and question.of_model:
        question.brief().ask(model, given)  # loads and compiles
    answer = question.ask(model, given)
    seconds = [float(answer["seconds"])]
    while warm and np.isfinite(seconds[0]) and len(seconds) < CALLS and sum(seconds) < ENOUGH:
        seconds.append(float(question.ask(model, given)["seconds"]))
    answer = answer.assign(seconds=answer["seconds"].copy(data=min(seconds)))
    if truth is None and question.truth is not None:
        return scored(answer, {}, {})
    values = question.score(answer, truth)
    units = {name: unit for name, unit in question.scores.items() if name in values}
    kept = answer if truth is None else question.stored(answer, truth)
    return scored(kept, values, units)


def unanswered(question: Experiment, outcome: Outcome) -> xr.Dataset:
    """An outcome, and scores without a value."""
    return scored(xr.Dataset(outcome_variables(outcome)), {}, dict(question.scores))
