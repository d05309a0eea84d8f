"""What the accuracy of the full-order model costs, setting by setting.

    step      h = T/N for each scheme (numerical damping and start), on the scene's mesh
    residual  the tolerance of the Newton iteration, without numerical damping, at the scene's own N
              (up to the next multiple of 50)
    mesh      elements and cells: see `cost_meshes`

Errors in time are NMTEs of the decay from the test release and of the last period of a forced run
from rest, against the same mesh with the smallest step, no numerical damping and the tightest
tolerance. That reference is run with 1, 2 and 4 times its step: q(2h) - q(h) over 2^p - 1 is its
own error (Richardson), p being its observed order, 2 at most.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr

from vibrom.artefacts.outcome import Outcome
from vibrom.models.full_order import FullOrder
from vibrom.models.measures import distance, nmte_percent
from vibrom.models.model import Drive, Watch
from vibrom.solvers.full.newmark import Newmark
from vibrom.studies import Case
from vibrom.studies.cost import Cost, Reference
from vibrom.studies.parts import cost_meshes
from vibrom.studies.parts.records import Column, stacked, text
from vibrom.studies.parts.timing import Measured, columns, entries, repeated

# of a period; every number of steps is a multiple of it, so that all runs have these instants
SAMPLES = 50
QUESTIONS = ("decay", "forced", *cost_meshes.QUESTIONS)
COLUMNS = {
    "study": Column("1", "what is varied: step, residual or mesh", missing=""),
    "element": Column("1", "element", missing=""),
    "columns": Column("1", "cells along the length"),
    "rows": Column("1", "cells over the height"),
    "free_dofs": Column("1", "free displacements"),
    "steps_per_period": Column("1", "time steps in a period of the first mode"),
    "scheme": Column("1", "time integration", missing=""),
    "alpha": Column("1", "numerical damping"),
    "residual": Column("1", "relative residual of a converged step"),
    "initial_acceleration": Column("1", "start of the integration", missing=""),
    "first_frequency": Column("rad s-1", "undamped first angular frequency"),
    "modal_amplitude": Column("kg^(1/2) m", "largest modal coordinate of the last forced period"),
    **columns(
        error="error against the reference",
        seconds="median wall time of the run; of the frequency: assembly and eigenmodes",
        calls="runs behind the median",
        outcome="how the run ended",
    ),
}
OWN = {
    "reference_error": Column("percent", "estimated error of the reference"),
    "reference_order": Column("1", "observed order of the reference, from three of its steps"),
}


@dataclass(frozen=True)
class Question:
    """A run of the model, of which some instants are compared."""

    start: np.ndarray  # (2n,) m, m/s
    periods: int
    forcing: float | None = None  # amplitude, times the scene's load; None: it is left alone

    def answer(self, model: FullOrder) -> tuple[Any, float, Outcome]:
        """Displacement (m, n) of the whole decay, or of the last period of a forced run, at SAMPLES
        instants a period; seconds; outcome.
        """
        drive = None
        if self.forcing is not None:
            drive = Drive(np.array([self.forcing]), np.array([model.frequency]))
        first = 0 if drive is None else self.periods - 1
        instants = model.period * np.arange(first * SAMPLES, self.periods * SAMPLES + 1) / SAMPLES
        run = model.motion(self.start[None], drive, Watch(instants))
        return run.displacement[0][0], run.seconds, Outcome(str(run.outcome[0]))

    def brief(self) -> Question:
        """The same question, small and short: evaluated first, so that it compiles."""
        forcing = None if self.forcing is None else 1e-6 * self.forcing
        return Question(0.0 * self.start, 1, forcing)


def made(study: Cost, case: Case) -> xr.Dataset:
    """One entry a setting and question."""
    model = FullOrder.of_scene(dict(case.scene), case.structure)
    shape = case.full_order["release"]["displacement"].sel(role="test").values
    start = np.concatenate([shape, np.zeros_like(shape)])
    forcing = float(case.settings("forced")["forcing"])
    questions = {
        "decay": Question(start, case.scene["record"]["periods"]),
        "forced": Question(0.0 * start, study.full_order.forced_periods, forcing),
    }
    for question in questions.values():
        for scheme in {scheme.scheme for scheme in study.full_order.schemes}:
            question.brief().answer(with_time(model, SAMPLES, Newmark(0.0, scheme, 1e-3)))
    truths, own = {}, {}
    for name, question in questions.items():
        truths[name], own[name] = reference(model, question, study.full_order.reference)
    settled = list(in_time(study, case, model, questions, truths))
    meshes, mesh_own = cost_meshes.made(study, case)
    own |= mesh_own
    records = [record | entries(answers, QUESTIONS) for record, answers in settled + meshes]
    return xr.Dataset(
        stacked(records, {"setting": len(records)}, COLUMNS, {"question": len(QUESTIONS)})
        | stacked([own[name] for name in QUESTIONS], {"question": len(QUESTIONS)}, OWN, {}),
        coords={"question": text("question", QUESTIONS, "what is compared with the reference")},
        attrs={"decay_periods": case.scene["record"]["periods"]},
    )


def with_time(
    model: FullOrder, steps: int, newmark: Newmark, start: str = "equilibrium"
) -> FullOrder:
    """The model with another integration in time."""
    return replace(
        model,
        steps_per_period=steps,
        initial_acceleration=start,
        newmark=newmark,
        title=f"{model.title.partition(',')[0]}, T/{steps}",
    )


def settings(study: Cost, model: FullOrder) -> Iterator[tuple[str, FullOrder]]:
    """(study, model) for each time step of each scheme, then for each residual."""
    varied, residual = study.full_order, model.newmark.tolerance
    for scheme in varied.schemes:
        newmark = Newmark(scheme.alpha, scheme.scheme, residual, scheme.iterations)
        for steps in scheme.steps_per_period or varied.steps_per_period:
            yield "step", with_time(model, steps, newmark, scheme.initial_acceleration)
    own = -(-model.steps_per_period // SAMPLES) * SAMPLES
    for residual in varied.residuals:
        yield "residual", with_time(model, own, Newmark(tolerance=residual))


def in_time(
    study: Cost,
    case: Case,
    model: FullOrder,
    questions: dict[str, Question],
    truths: dict[str, Any],
) -> Iterator[tuple[dict[str, Any], dict[str, Measured]]]:
    """What each setting is, and its answers; one that stands in both lists is run once."""
    known: dict[tuple[Any, ...], dict[str, Measured]] = {}
    for kind, setting in settings(study, model):
        key = (setting.newmark, setting.steps_per_period, setting.initial_acceleration)
        if key not in known:
            known[key] = {
                name: measured(study, setting, question, truths[name])
                for name, question in questions.items()
            }
        yield about(kind, case.scene["body"], setting), known[key]


def measured(study: Cost, model: FullOrder, question: Question, truth: Any) -> Measured:
    """Error and time of a setting."""

    def call() -> tuple[tuple[Any, Outcome], float]:
        displacement, seconds, outcome = question.answer(model)
        return (displacement, outcome), seconds

    (displacement, outcome), seconds, calls = repeated(call, study.repeats, study.patience)
    if truth is None:
        failed = Outcome.REFERENCE_FAILED if outcome.has_value else outcome
        return Measured(failed, np.nan, seconds, calls)
    return Measured(outcome, nmte_percent(truth, displacement), seconds, calls)


def reference(
    model: FullOrder, question: Question, finest: Reference
) -> tuple[Any, dict[str, float]]:
    """The motion that others are compared with, None where it failed; its own error [%] and
    observed order.
    """
    (fine, _, ended), (middle, _, _), (coarse, _, _) = (
        question.answer(
            with_time(model, finest.steps_per_period // part, Newmark(tolerance=finest.residual))
        )
        for part in (1, 2, 4)
    )
    first, second = (np.linalg.norm(distance(*pair)) for pair in ((coarse, middle), (middle, fine)))
    order = float(np.log2(first / second)) if second else np.nan
    # A release may excite modes that no step resolves: their order is below two, and the stated
    # error of the reference then is a lower bound.
    error = nmte_percent(fine, middle) / (2 ** np.clip(order, 0.5, 2.0) - 1)
    own = {"reference_error": float(error), "reference_order": order}
    return fine if ended.has_value else None, own


def about(kind: str, body: Mapping[str, Any], model: FullOrder) -> dict[str, Any]:
    """What a setting is: its study, the mesh of a body, and the integration of the model."""
    columns, rows = body["cells"]
    return {
        "study": kind,
        "element": body["element"],
        "columns": columns,
        "rows": rows,
        "free_dofs": model.size,
        "steps_per_period": model.steps_per_period,
        "scheme": model.newmark.scheme,
        "alpha": model.newmark.alpha,
        "residual": model.newmark.tolerance,
        "initial_acceleration": model.initial_acceleration,
    }
