"""What a finer mesh costs.

Meshes are compared by what does not depend on one: the first frequency, and the largest modal
coordinate |phi' M q| of the last period of a run that is forced at each mesh's own damped first
frequency, with as many steps to its period. Their reference is the finest mesh, whose own error is
taken to be its distance from the mesh half as fine (as for order one; the corners of the clamped
edge are singular).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np

from vibrom import effects
from vibrom.artefacts.outcome import Outcome
from vibrom.bodies import space
from vibrom.config.scene import Time
from vibrom.models.full_order import FullOrder
from vibrom.models.model import Drive, Watch
from vibrom.models.samples import Samples
from vibrom.solvers.full.modes import eigenmodes, linearised
from vibrom.solvers.full.newmark import Newmark
from vibrom.studies import Case
from vibrom.studies.cost import Cost
from vibrom.studies.parts.timing import Measured, repeated
from vibrom.term import SceneError, Term

# Question -> the number that answers it.
NUMBERS = {"frequency": "first_frequency", "response": "modal_amplitude"}
QUESTIONS = tuple(NUMBERS)


@dataclass(frozen=True)
class Mesh:
    """A meshed scene, and the numbers by which meshes are compared."""

    record: dict[str, Any]  # what it is, and its numbers
    answers: dict[str, Measured]  # by question, without an error

    def number(self, question: str) -> float:
        """NaN where the mesh has none."""
        return float(self.record.get(NUMBERS[question], np.nan))

    def against(self, truth: Mesh) -> dict[str, Measured]:
        """The answers with their errors."""
        found = {}
        for question, answer in self.answers.items():
            error = 100 * abs(self.number(question) / truth.number(question) - 1)
            if answer.outcome.has_value and not np.isfinite(truth.number(question)):
                answer = answer._replace(outcome=Outcome.REFERENCE_FAILED)
            found[question] = answer._replace(error=error)
        return found


def made(
    study: Cost, case: Case
) -> tuple[list[tuple[dict[str, Any], dict[str, Measured]]], dict[str, dict[str, float]]]:
    """What each mesh is, and its answers; and question -> the reference's own error [%]."""
    finest = study.full_order.reference_mesh
    columns, rows = finest.cells
    half = max(1, columns // 2), max(1, rows // 2)
    listed = [
        (element, cells) for element, sizes in study.full_order.meshes.items() for cells in sizes
    ]
    known = {}
    for mesh in [*listed, (finest.element, finest.cells), (finest.element, half)]:
        if mesh not in known:
            known[mesh] = solved(study, case, *mesh, repeats=study.repeats if mesh in listed else 1)
    truth, coarse = known[finest.element, finest.cells], known[finest.element, half]
    own = {
        name: {"reference_error": answer.error} for name, answer in coarse.against(truth).items()
    }
    return [(known[mesh].record, known[mesh].against(truth)) for mesh in listed], own


def solved(study: Cost, case: Case, element: str, cells: tuple[int, int], *, repeats: int) -> Mesh:
    """The first frequency and the forced response of a mesh; `skipped` where it has no node for an
    effect of the scene.
    """
    about = {"study": "mesh", "element": element, "columns": cells[0], "rows": cells[1]}
    about |= {"initial_acceleration": "equilibrium"}
    body = {**case.scene["body"], "element": element, "cells": list(cells), "probes": {}}

    def assembled() -> tuple[tuple[Term, float, np.ndarray], float]:
        began = perf_counter()
        term = effects.assemble(space.build(body), case.scene["effects"])
        (omega, *_), (phi, *_) = eigenmodes(term, 1)
        return (term, float(omega), phi), perf_counter() - began

    try:
        assembled()  # imports and compiles
        (term, omega, phi), seconds, calls = repeated(assembled, repeats, study.patience)
    except SceneError:
        return Mesh(about, dict.fromkeys(QUESTIONS, Measured(Outcome.SKIPPED)))
    model = meshed(study, case.scene["time"], term, omega, phi)
    about |= {
        "free_dofs": model.size,
        "steps_per_period": model.steps_per_period,
        "scheme": model.newmark.scheme,
        "alpha": model.newmark.alpha,
        "residual": model.newmark.tolerance,
        "first_frequency": omega,
    }
    forcing = float(case.settings("forced")["forcing"])
    driven(replace(model, steps_per_period=2), 0.0, 1)  # compiles
    (displacement, outcome), run_seconds, runs = repeated(
        lambda: driven(model, forcing, study.full_order.mesh_periods), repeats, study.patience
    )
    about["modal_amplitude"] = float(np.abs(Samples(((displacement,),)) @ (term.mass @ phi)).max())
    return Mesh(
        about,
        {
            "frequency": Measured(Outcome.OK, seconds=seconds, calls=calls),
            "response": Measured(outcome, seconds=run_seconds, calls=runs),
        },
    )


def meshed(
    study: Cost, time: Mapping[str, Any], term: Term, omega: float, phi: np.ndarray
) -> FullOrder:
    """The full order of a mesh with this first frequency [rad/s] and mode (n,)."""
    ratio = 0.0 if term.damping is None else float(phi @ (term.damping @ phi)) / (2 * omega)
    integration = Time.from_builtins(dict(time))
    return FullOrder(
        term=term,
        probes=np.zeros(0, np.int64),
        newmark=Newmark(
            integration.alpha, integration.scheme, integration.residual, integration.iterations
        ),
        steps_per_period=study.full_order.mesh_steps_per_period,
        initial_acceleration="equilibrium",
        frequency=omega * np.sqrt(1 - ratio**2),
        poles=np.zeros(0),
        rest=linearised(term)[0],
        title=f"mesh of {term.size} displacements",
    )


def driven(model: FullOrder, forcing: float, periods: int) -> tuple[tuple[Any, Outcome], float]:
    """Displacement (m, n) in the last period of a run from rest, its outcome, and seconds."""
    drive = Drive(np.array([forcing]), np.array([model.frequency]))
    steps = np.arange((periods - 1) * model.samples, periods * model.samples + 1)
    watch = Watch(model.period * steps / model.samples)
    run = model.motion(np.zeros((1, 2 * model.size)), drive, watch)
    return (run.displacement[0][0], Outcome(str(run.outcome[0]))), run.seconds
