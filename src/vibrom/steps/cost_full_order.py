"""Scene and release states -> cost_full_order.nc: what the accuracy of the full-order model costs,
setting by setting.

    step      h = T/N for each scheme (numerical damping and start), on the scene's mesh
    residual  the tolerance of the Newton iteration, at the scene's own N (up to the next multiple
    of 50) without numerical damping
    mesh      elements and cells

Errors in time are NMTEs of the decay from the test release and of the last period of a forced run
from rest, against the same mesh with the smallest step, no numerical damping and the tightest
tolerance. That reference is run with 1, 2 and 4 times its step: q(2h) - q(h) over 2^p - 1 is its
own error (Richardson), p being its observed order, 2 at most. Meshes are compared by what does not
depend on one: the first frequency, and the largest modal coordinate |phi' M q| of the last period
of a run that is forced at each mesh's own damped first frequency, with as many steps to its period.
Their reference is the finest mesh, whose own error is taken to be its distance from the mesh half
as fine (as for order one; the corners of the clamped edge are singular).
"""

from dataclasses import dataclass, field, replace
from time import perf_counter

import numpy as np
import xarray as xr

from vibrom import effects
from vibrom.artefacts.data import label, open_dataset, save_dataset, variable
from vibrom.artefacts.hardware import description
from vibrom.bodies import space
from vibrom.models.full_order import FullOrder, build
from vibrom.models.measures import nmte_percent
from vibrom.solvers.full.modes import eigenmodes, linearised
from vibrom.solvers.full.newmark import Newmark, Record
from vibrom.studies.work_precision import repeated
from vibrom.term import SceneError

# of a period; every number of steps is a multiple of it, so that all runs have these instants
SAMPLES = 50
IN_TIME, OF_MESH = ("decay", "forced"), ("frequency", "response")
QUESTIONS = IN_TIME + OF_MESH
NUMBERS = {
    "columns": ("1", "cells along the length"),
    "rows": ("1", "cells over the height"),
    "free_dofs": ("1", "free displacements"),
    "steps_per_period": ("1", "time steps in a period of the first mode"),
    "alpha": ("1", "numerical damping"),
    "residual": ("1", "relative residual of a converged step"),
    "first_frequency": ("rad s-1", "undamped first angular frequency"),
    "modal_amplitude": ("kg0.5 m", "largest modal coordinate of the last forced period"),
}
WORDS = {
    "study": "what is varied: step, residual or mesh",
    "element": "element",
    "initial_acceleration": "start of the integration",
}


@dataclass(frozen=True)
class Question:
    """A decay from `start` (n,) [m], or, where there is a forcing, a run from rest; over so many
    periods.
    """

    start: np.ndarray
    periods: int
    forcing: float = 0.0


@dataclass
class Row:
    """One setting: what it is, and the answer to each question that it was asked: (error in
    percent, seconds, calls, outcome).
    """

    names: dict[str, str | float]
    answers: dict[str, tuple[float, float, int, str]] = field(default_factory=dict)


def run(
    *,
    structure: str,
    release: str,
    cost: str,
    scene: dict,
    settings: dict,
    repeats: int,
    patience: float,
    provenance: dict,
) -> None:
    model = build(scene, structure)
    start = open_dataset(release, "release")["displacement"].sel(role="test").values
    questions = {
        "decay": Question(start, scene["record"]["periods"]),
        "forced": Question(
            np.zeros_like(start),
            settings["forced_periods"],
            float(scene["experiments"]["forced"]["forcing"]),
        ),
    }
    for question in questions.values():  # compiles and warms up
        motion(
            with_time(model, SAMPLES, 0.0, 1e-3),
            replace(question, start=0.0 * start, periods=1, forcing=1e-6 * question.forcing),
        )
    references, own = in_time_references(model, questions, settings["reference"])
    rows = [
        time_row(study, setting, scene["body"], questions, references, repeats, patience)
        for study, setting in time_settings(model, settings)
    ]
    mesh_rows, mesh_own = meshes(scene, settings, repeats, patience)
    dataset = as_dataset(rows + mesh_rows, own | mesh_own)
    save_dataset(
        label(
            dataset,
            "cost_full_order",
            scene=model.name,
            method="full_order",
            settings=settings,
            hardware=description(),
            decay_periods=scene["record"]["periods"],
        ),
        cost,
        provenance,
    )


def with_time(
    model: FullOrder, steps: int, alpha: float, residual: float, initial: str = "equilibrium"
) -> FullOrder:
    return replace(
        model,
        steps_per_period=steps,
        initial_acceleration=initial,
        newmark=Newmark(alpha=alpha, tolerance=residual),
    )


def time_settings(model: FullOrder, settings: dict):
    """(study, model) for each time step of each scheme, then for each residual."""
    for scheme in settings["schemes"]:
        for steps in settings["steps_per_period"]:
            yield (
                "step",
                with_time(
                    model,
                    steps,
                    scheme["alpha"],
                    model.newmark.tolerance,
                    scheme["initial_acceleration"],
                ),
            )
    own = -(-model.steps_per_period // SAMPLES) * SAMPLES
    for residual in settings["residuals"]:
        yield "residual", with_time(model, own, 0.0, residual)


def motion(model: FullOrder, question: Question) -> tuple[np.ndarray, float, str]:
    """(displacement (m, n) at SAMPLES instants a period, seconds, outcome): the whole decay, or the
    last period of a forced run.
    """
    steps = question.periods * model.steps_per_period
    every = model.steps_per_period // SAMPLES
    if question.forcing:
        record = Record(every=every, start=steps - model.steps_per_period)
        done = model.forced(
            np.array([question.forcing]),
            np.array([model.frequency]),
            steps,
            record,
            f"{model.name}: forced, T/{model.steps_per_period}",
        )
    else:
        done = model.run(
            question.start[:, None],
            np.array([model.period / model.steps_per_period]),
            steps,
            Record(every=every),
            f"{model.name}: decay, T/{model.steps_per_period}",
        )
    return done.displacement[0], done.seconds, done.outcomes[0]


def difference(mine: np.ndarray, reference: np.ndarray) -> float:
    """NMTE [%]."""
    return nmte_percent(np.linalg.norm(mine - reference, axis=1), reference)


def in_time_references(model: FullOrder, questions: dict, settings: dict) -> tuple[dict, dict]:
    """Question -> reference motion or None, and -> (its own error [%], its observed order)."""
    references, own = {}, {}
    for name, question in questions.items():
        steps, residual = settings["steps_per_period"], settings["residual"]
        fine, middle, coarse = (
            motion(with_time(model, steps // part, 0.0, residual), question) for part in (1, 2, 4)
        )
        references[name] = fine[0] if fine[2] == "ok" else None
        first, second = np.linalg.norm(coarse[0] - middle[0]), np.linalg.norm(middle[0] - fine[0])
        order = float(np.log2(first / second)) if second else np.nan
        # A release may excite modes that no step resolves: their order is less than two, and the
        # reference then no better than told.
        own[name] = (difference(middle[0], fine[0]) / (2 ** np.clip(order, 0.5, 2.0) - 1), order)
    return references, own


def time_row(
    study: str,
    model: FullOrder,
    body: dict,
    questions: dict,
    references: dict,
    repeats: int,
    patience: float,
) -> Row:
    row = Row(about(study, body["element"], body["cells"], model))
    for name, question in questions.items():

        def call():
            displacement, seconds, outcome = motion(model, question)
            return (displacement, outcome), seconds

        (displacement, outcome), seconds, calls = repeated(call, repeats, patience)
        known = references[name] is not None
        error = difference(displacement, references[name]) if known else np.nan
        row.answers[name] = (
            error,
            seconds,
            calls,
            outcome if known or outcome != "ok" else "reference_failed",
        )
    return row


def about(study: str, element: str, cells: list[int], model: FullOrder) -> dict:
    return {
        "study": study,
        "element": element,
        "columns": cells[0],
        "rows": cells[1],
        "free_dofs": model.space.size,
        "steps_per_period": model.steps_per_period,
        "alpha": model.newmark.alpha,
        "residual": model.newmark.tolerance,
        "initial_acceleration": model.initial_acceleration,
    }


def meshes(scene: dict, settings: dict, repeats: int, patience: float) -> tuple[list[Row], dict]:
    """A row for each mesh, and question -> (own error of the finest one [%], NaN)."""
    finest = settings["reference_mesh"]
    element, cells = finest["element"], finest["cells"]
    reference, half = (
        mesh_row(scene, element, size, settings, 1, 0.0)[0].names
        for size in (cells, [max(1, count // 2) for count in cells])
    )
    rows, own = [], {}
    keys = dict(zip(OF_MESH, ("first_frequency", "modal_amplitude")))
    for kind, sizes in settings["meshes"].items():
        for size in sizes:
            row, seconds = mesh_row(scene, kind, size, settings, repeats, patience)
            for name, key in keys.items():
                error, ended = 100 * abs(row.names[key] / reference[key] - 1), seconds[name][2]
                row.answers[name] = (
                    error,
                    *seconds[name][:2],
                    ended if np.isfinite(reference[key]) or ended != "ok" else "reference_failed",
                )
            rows.append(row)
    for name, key in keys.items():
        own[name] = (100 * abs(half[key] / reference[key] - 1), np.nan)
    return rows, own


def mesh_row(
    scene: dict, element: str, cells: list[int], settings: dict, repeats: int, patience: float
) -> tuple[Row, dict[str, tuple]]:
    """The first frequency and the forced response of a mesh, and question -> (seconds, calls,
    outcome); `skipped` where it has no node for an effect of the scene.
    """
    try:
        return solved(scene, element, cells, settings, repeats, patience)
    except SceneError:
        names = {
            "study": "mesh",
            "element": element,
            "columns": cells[0],
            "rows": cells[1],
            "initial_acceleration": "equilibrium",
            "first_frequency": np.nan,
            "modal_amplitude": np.nan,
        }
        return Row(names), dict.fromkeys(OF_MESH, (np.nan, 0, "skipped"))


def solved(
    scene: dict, element: str, cells: list[int], settings: dict, repeats: int, patience: float
) -> tuple[Row, dict[str, tuple]]:
    def assembled():
        began = perf_counter()
        body = space.build(
            {**scene["body"], "element": element, "cells": list(cells), "probes": {}}
        )
        term = effects.assemble(body, scene["effects"])
        return (body, term, *eigenmodes(term, 1)), perf_counter() - began

    assembled()  # imports and compiles
    (body, term, (omega, *_), (phi, *_)), seconds, calls = repeated(assembled, repeats, patience)
    ratio = 0.0 if term.damping is None else float(phi @ (term.damping @ phi)) / (2 * omega)
    time = scene["time"]
    model = FullOrder(
        f"{element} {cells[0]} x {cells[1]}",
        body,
        term,
        Newmark(alpha=time["alpha"], tolerance=time["residual"]),
        settings["mesh_steps_per_period"],
        1,
        "equilibrium",
        omega * np.sqrt(1 - ratio**2),
        linearised(term)[0],
    )
    steps = settings["mesh_periods"] * model.steps_per_period
    record, forcing = (
        Record(start=steps - model.steps_per_period),
        float(scene["experiments"]["forced"]["forcing"]),
    )
    model.forced(np.array([forcing]), np.array([model.frequency]), 2, Record(), model.name)

    def driven():
        done = model.forced(
            np.array([forcing]), np.array([model.frequency]), steps, record, model.name
        )
        return done, done.seconds

    done, driven_seconds, driven_calls = repeated(driven, repeats, patience)
    names = about("mesh", element, cells, model) | {
        "first_frequency": float(omega),
        "modal_amplitude": float(np.abs(done.displacement[0] @ (term.mass @ phi)).max()),
    }
    return Row(names), {
        "frequency": (seconds, calls, "ok"),
        "response": (driven_seconds, driven_calls, done.outcomes[0]),
    }


def as_dataset(rows: list[Row], own: dict[str, tuple[float, float]]) -> xr.Dataset:
    """One entry a setting and question; a question that a setting was not asked has the outcome
    `not asked`.
    """

    def column(index: int, missing) -> list[list]:
        return [
            [row.answers.get(name, (missing,) * 4)[index] for name in QUESTIONS] for row in rows
        ]

    dims = ("setting", "question")
    variables = {
        name: variable(
            "setting", np.array([row.names.get(name, np.nan) for row in rows], float), *said
        )
        for name, said in NUMBERS.items()
    }
    variables |= {
        name: variable(
            "setting", np.array([row.names[name] for row in rows], dtype=object), "1", said
        )
        for name, said in WORDS.items()
    }
    return xr.Dataset(
        variables
        | {
            "error": variable(
                dims, np.array(column(0, np.nan), float), "percent", "error against the reference"
            ),
            "seconds": variable(
                dims,
                np.array(column(1, np.nan), float),
                "s",
                "median wall time of the run; of the frequency: assembly and eigenmodes",
            ),
            "calls": variable(dims, np.array(column(2, 0), float), "1", "runs behind the median"),
            "outcome": variable(
                dims, np.array(column(3, "not asked"), dtype=object), "1", "how the run ended"
            ),
            "reference_error": variable(
                "question",
                np.array([own[name][0] for name in QUESTIONS]),
                "percent",
                "estimated error of the reference",
            ),
            "reference_order": variable(
                "question",
                np.array([own[name][1] for name in QUESTIONS]),
                "1",
                "observed order of the reference, from three of its steps",
            ),
        },
        coords={
            "question": variable(
                "question",
                np.array(QUESTIONS, dtype=object),
                "1",
                "what is compared with the reference",
            )
        },
    )
