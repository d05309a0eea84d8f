"""How robust a fitted model is: the grid of demanding runs, energies of decays, and what becomes of
the scene's own questions.

Each guard is evaluated with the first integrator, and each integrator with the first guard; the
other pairs are `not_run`. What a pair has in common with the run, or with a pair before it, is read
and not computed again.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import xarray as xr

from vibrom.artefacts.data import variable
from vibrom.artefacts.outcome import Outcome
from vibrom.models.energy import energy
from vibrom.models.full_order import FullOrder
from vibrom.models.recorded import structure, trajectory
from vibrom.models.reduced import Reduced
from vibrom.models.rollout import Integrator
from vibrom.models.rom import Rom, rom_from_dataset
from vibrom.models.training import MethodError, Training, Underdetermined
from vibrom.studies import Case, Fitted
from vibrom.studies.parts import certificate, grid
from vibrom.studies.parts.records import Column, stacked, text
from vibrom.studies.robustness import Robustness

PERIODS = (
    50  # of decays, for their energy: with one percent of damping they fall to a five-hundredth
)
RUN, CURVE, DECAY = ("run",), ("angular_frequency",), ("release", "period")
PAIR = {
    "outcome": Column("1", "how the run ended", RUN, missing=Outcome.NOT_RUN),
    "failed_at": Column(
        "1", "periods of the forcing until the run failed or first left the training range", RUN
    ),
    "range_ratio": Column(
        "1", "largest reduced coordinate over the largest in the training data", RUN
    ),
    "frc_amplitude": Column(
        "m", "amplitude of the first probe on the scene's response curve", CURVE
    ),
    "frc_outcome": Column(
        "1", "how the run of the response curve ended", CURVE, missing=Outcome.NOT_RUN
    ),
    "decay_nmte": Column("percent", "NMTE of the unseen decay"),
    "forced_nmte": Column("percent", "NMTE of the forced run, last period"),
    "real_part": Column("s-1", "real part of the first pair of eigenvalues at rest"),
}
# Variable -> the experiment and its score.
SCORES = {
    "decay_nmte": ("decay", "nmte_percent"),
    "forced_nmte": ("forced", "nmte_percent"),
    "real_part": ("eigenvalues", "real_per_s"),
}
GUARD = {
    "energy": Column(
        "J",
        "mechanical energy of the decoded state over that at rest, mean over each period after "
        "release",
        DECAY,
    ),
    "envelope": Column(
        "1",
        "largest reduced position over its training range, in each period after release and the "
        "next",
        DECAY,
    ),
    "least_damping": Column("1", "least damping ratio anywhere; negative: it may gain energy"),
    "least_turning": Column("1", "least turning of the phase anywhere; one of a linear oscillator"),
}


def made(study: Robustness, case: Case) -> xr.Dataset:
    """Pairs of guard and integrator, and decays with each guard."""
    chosen = grid.cases(
        study.forcing,
        np.linspace(study.frequency.lowest, study.frequency.highest, study.frequency.count),
        study.releases,
        study.beyond,
    )
    pairs, reasons = evaluated(study, case, chosen)
    first = next(iter(study.integrators))
    curve = case.full_order["frc"]["angular_frequency"].variable
    sizes = {"run": len(chosen.kind), CURVE[0]: curve.size}
    sizes |= {"release": study.releases, "period": PERIODS}
    guards = {"guard": len(study.guards)}
    along = guards | {"integrator": len(study.integrators)}
    return xr.Dataset(
        stacked(pairs.values(), along, PAIR, sizes)
        | stacked([pairs[guard, first] for guard in study.guards], guards, GUARD, sizes)
        | about(chosen),
        coords={
            "guard": text("guard", list(study.guards), "guard of the fitted model"),
            "integrator": text("integrator", list(study.integrators), "integrator of the model"),
            CURVE[0]: curve,
        },
        attrs={"periods": study.periods, "reasons": json.dumps(reasons)},
    )


def evaluated(
    study: Robustness, case: Case, chosen: grid.Cases
) -> tuple[dict[tuple[str, str], dict[str, Any]], dict[str, str]]:
    """(guard, integrator) -> record, of all pairs, and why models lack a guard or an integrator."""
    models, reasons = guarded(study, case)
    pairs: dict[tuple[str, str], dict[str, Any]] = {}
    known: dict[tuple[int, Integrator], dict[str, Any]] = {}
    first_guard, first = next(iter(study.guards)), next(iter(study.integrators))
    for guard, name in product(study.guards, study.integrators):
        model, integrator = models[guard], study.integrators[name]
        key = id(model), integrator
        if guard != first_guard and name != first:
            pairs[guard, name] = {}
        elif isinstance(model, Outcome):
            pairs[guard, name] = absent(model)
        elif key in known:
            pairs[guard, name] = known[key]
        else:
            try:
                known[key] = Bench(study, case, chosen).record(model, integrator)
            except MethodError as error:
                known[key], reasons[name] = absent(Outcome.UNSUPPORTED), str(error)
            pairs[guard, name] = known[key]
    return pairs, reasons


def guarded(study: Robustness, case: Case) -> tuple[dict[str, Rom | Outcome], dict[str, str]]:
    """Guard -> the model with it, or the outcome that stands for it; and guard -> why it has none.
    Guards that make the same model give the same object.
    """
    (fitted,) = case.fitted
    if not fitted.outcome.has_value:
        return dict.fromkeys(study.guards, fitted.outcome), {}
    motion, known = trajectory(case.full_order["train"], lazy=True), structure(case.structure)
    rom, training = rom_from_dataset(fitted.record), Training((motion,), known)
    models: dict[str, Rom | Outcome] = {}
    reasons, distinct = {}, [rom]
    for guard, settings in study.guards.items():
        try:
            made = rom.guarded(settings, training)
        except MethodError as error:
            short = isinstance(error, Underdetermined)
            models[guard] = Outcome.UNDERDETERMINED if short else Outcome.UNSUPPORTED
            reasons[guard] = str(error)
            continue
        alike = [one for one in distinct if one is made or same(one, made)]
        distinct += [] if alike else [made]
        models[guard] = alike[0] if alike else made
    return models, reasons


def same(one: Rom, other: Rom) -> bool:
    """Are these the same model, to the last bit?"""
    return bool(one.to_dataset().identical(other.to_dataset()))


def absent(outcome: Outcome) -> dict[str, Any]:
    """The record of a pair without a model."""
    return {"outcome": outcome, "frc_outcome": outcome}


def about(chosen: grid.Cases) -> dict[str, xr.Variable]:
    """What the runs are."""
    kinds = np.array(grid.KINDS, dtype=object)[chosen.kind]
    numbers = {
        "forcing": (chosen.forcing, "forcing amplitude over the scene's"),
        "frequency": (chosen.frequency, "forcing frequency over the damped first frequency"),
        "radius": (chosen.radius, "distance of the start from rest over the training range"),
    }
    return {"kind": text("run", kinds, "what is done to the model")} | {
        name: variable("run", values, "1", said) for name, (values, said) in numbers.items()
    }


@dataclass(frozen=True)
class Bench:
    """What a model is put through."""

    study: Robustness
    case: Case
    chosen: grid.Cases

    def record(self, rom: Rom, integrator: Integrator) -> dict[str, Any]:
        """Of a model with an integrator."""
        model = Reduced.of_scene(rom, self.case.structure, integrator)
        forcing, periods = float(self.case.settings("frc")["forcing"]), self.study.periods
        ended = grid.ended(model, self.chosen, forcing, periods)
        record = dict(zip(("outcome", "failed_at", "range_ratio"), ended))
        (fitted,) = self.case.fitted
        of_run = integrator == Integrator(**self.case.integrator)
        if of_run and same(rom, rom_from_dataset(fitted.record)):
            record |= self.answers_of_run(fitted)
        else:
            record |= self.answers(model)
        if integrator == next(iter(self.study.integrators.values())):
            full = FullOrder.of_scene(dict(self.case.scene), self.case.structure)

            def energy_of(displacement: np.ndarray, velocity: np.ndarray) -> np.ndarray:
                return energy(full.term, displacement, velocity, full.rest)

            decays = grid.decays(model, self.chosen, PERIODS, energy_of)
            record |= dict(zip(("energy", "envelope"), decays))
            damping, turning = certificate.least(rom)
            record |= {"least_damping": np.asarray(damping), "least_turning": np.asarray(turning)}
        return record

    def answers_of_run(self, fitted: Fitted) -> dict[str, Any]:
        """What the run has of the scene's questions."""
        curve = fitted.answers["frc"]
        record: dict[str, Any] = {"frc_outcome": curve["outcome"].values}
        if curve.attrs.get("answered", 0):
            record["frc_amplitude"] = curve["amplitude"].values[0]
        for name, (question, score) in SCORES.items():
            record[name] = float(fitted.answers[question]["score_value"].sel(score=score))
        return record

    def answers(self, model: Reduced) -> dict[str, Any]:
        """The same of a model that the run does not have."""
        given = self.case.given
        curve = self.case.question("frc").ask(model, given)
        record: dict[str, Any] = {
            "frc_outcome": curve["outcome"].values,
            "frc_amplitude": curve["amplitude"].values[0],
        }
        for name, (question, score) in SCORES.items():
            if self.case.is_comparable(question):
                asked, truth = self.case.question(question), self.case.truth(question)
                record[name] = asked.score(asked.ask(model, given), truth)[score]
        return record
