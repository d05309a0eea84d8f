"""A fitted model -> stability.nc: the grid of hard cases, energies of decays, and what becomes of
the scene's own questions.

Each guard is asked with the first integrator, and each integrator with the first guard; the other
pairs are `not run`.
"""

import json

import numpy as np
import xarray as xr

from vibrom.artefacts.data import label, open_dataset, save_dataset, variable
from vibrom.experiments import decay, eigenvalues, forced, frc
from vibrom.models.energy import energy
from vibrom.models.full_order import build
from vibrom.models.recorded import structure as operators
from vibrom.models.recorded import trajectory
from vibrom.models.rollout import Integrator
from vibrom.models.rom import Guards, rom_from_dataset
from vibrom.models.training import MethodError, Training
from vibrom.studies import grid

PERIODS = (
    50  # that energies are followed over: with one percent of damping they fall to a five-hundredth
)


def run(
    *,
    structure: str,
    train: str,
    test: str,
    forced_run: str,
    curve: str,
    rom: str,
    output: str,
    scene: dict,
    scene_name: str,
    method: str,
    seed: int | None,
    stability: dict,
    provenance: dict,
) -> None:
    known, fitted = open_dataset(structure, "structure"), open_dataset(rom, "rom")
    asked = {
        "structure": known,
        "train": open_dataset(train, "trajectory"),
        "test": open_dataset(test, "trajectory"),
        "forced": open_dataset(forced_run, "forced"),
        "frc": open_dataset(curve, "frc"),
    }
    sweep = stability["frequency"]
    chosen = grid.cases(
        stability["forcing"],
        np.linspace(sweep["from"], sweep["to"], sweep["count"]),
        stability["releases"],
        stability["beyond"],
    )
    integrators = {
        name: Integrator(**settings) for name, settings in stability["integrators"].items()
    }
    results = Results(
        list(stability["guards"]),
        list(integrators),
        chosen,
        asked["frc"]["angular_frequency"].values,
    )
    unfit = str(fitted["outcome"].item())
    model = build(scene, structure) if unfit == "ok" else None
    forcing, load, first = (
        float(scene["experiments"]["frc"]["forcing"]),
        known["load"].values,
        next(iter(integrators)),
    )
    training = Training((trajectory(asked["train"]),), structure=operators(known))
    for place, (guard, settings) in enumerate(stability["guards"].items()):
        reason = unfit
        if unfit == "ok":
            try:
                guarded = rom_from_dataset(fitted).guarded(Guards(**settings), training)
                reason = "ok"
            except MethodError as error:
                reason, results.reasons[guard] = "skipped", str(error)
        for at, (name, integrator) in enumerate(integrators.items()):
            here = place, at
            if guard != next(iter(stability["guards"])) and name != first:
                continue
            if reason != "ok":
                results.outcome[here] = results.frc_outcome[here] = reason
                continue
            results.outcome[here], results.failed_at[here], results.range_ratio[here] = (
                grid.survive(
                    guarded,
                    chosen,
                    load,
                    forcing,
                    model.frequency,
                    stability["periods"],
                    integrator,
                )
            )
            results.scene(here, guarded, asked, integrator)
        if reason == "ok":
            results.energy[place], results.envelope[place] = grid.let_go(
                guarded,
                chosen,
                model.frequency,
                PERIODS,
                integrators[first],
                lambda q, v: energy(model.term, q, v, model.rest),
            )
    save_dataset(
        label(
            results.dataset(),
            "stability",
            scene=scene_name,
            method=method,
            seed=seed,
            periods=stability["periods"],
            reasons=json.dumps(results.reasons),
            settings=json.dumps(stability, sort_keys=True),
        ),
        output,
        provenance,
    )


class Results:
    """Arrays by guard and integrator, filled one model after the other."""

    def __init__(
        self, guards: list[str], integrators: list[str], cases: grid.Cases, frequency: np.ndarray
    ):
        self.guards, self.integrators, self.cases, self.frequency, self.reasons = (
            guards,
            integrators,
            cases,
            frequency,
            {},
        )
        pair, runs, curve = (len(guards), len(integrators)), len(cases.kind), len(frequency)
        self.outcome, self.frc_outcome = (
            np.full((*pair, runs), "not run", dtype=object),
            np.full((*pair, curve), "not run", dtype=object),
        )
        self.failed_at, self.range_ratio, self.frc_amplitude = (
            np.full((*pair, runs), np.nan),
            np.full((*pair, runs), np.nan),
            np.full((*pair, curve), np.nan),
        )
        self.decay_nmte, self.forced_nmte, self.real_part = (
            np.full(pair, np.nan),
            np.full(pair, np.nan),
            np.full(pair, np.nan),
        )
        self.energy, self.envelope = (
            np.full((len(guards), int((cases.kind == 1).sum()), PERIODS), np.nan) for _ in range(2)
        )

    def scene(self, here: tuple[int, int], rom, asked: dict, integrator: Integrator) -> None:
        """The questions that the scene asks anyway."""
        given = {"rom": rom, **asked}
        curve = frc.predict(given, integrator)
        self.frc_amplitude[here], self.frc_outcome[here] = (
            curve["amplitude"].values[0],
            curve["outcome"].values,
        )
        self.real_part[here] = float(
            eigenvalues.predict(given, integrator)["score_value"].sel(score="real_per_s")
        )
        for name, module, reference in (
            ("decay_nmte", decay, "test"),
            ("forced_nmte", forced, "forced"),
        ):
            if str(asked[reference]["outcome"].item()) == "ok":
                getattr(self, name)[here] = float(
                    module.predict(given, integrator)["score_value"].sel(score="nmte_percent")
                )

    def dataset(self) -> xr.Dataset:
        pair, kinds = ("guard", "integrator"), np.array(grid.KINDS, dtype=object)
        return xr.Dataset(
            {
                "outcome": variable((*pair, "run"), self.outcome, "1", "how the run ended"),
                "failed_at": variable(
                    (*pair, "run"),
                    self.failed_at,
                    "1",
                    "periods of the forcing until the run failed or first left the training range",
                ),
                "range_ratio": variable(
                    (*pair, "run"),
                    self.range_ratio,
                    "1",
                    "largest reduced coordinate over the largest in the training data",
                ),
                "kind": variable("run", kinds[self.cases.kind], "1", "what the run was asked"),
                "forcing": variable(
                    "run", self.cases.forcing, "1", "forcing amplitude over the scene's"
                ),
                "frequency": variable(
                    "run",
                    self.cases.frequency,
                    "1",
                    "forcing frequency over the damped first frequency",
                ),
                "radius": variable(
                    "run",
                    self.cases.radius,
                    "1",
                    "distance of the start from rest over the training range",
                ),
                "energy": variable(
                    ("guard", "release", "period"),
                    self.energy,
                    "J",
                    "mechanical energy of the decoded state over that at rest, mean over each period after release",
                ),
                "envelope": variable(
                    ("guard", "release", "period"),
                    self.envelope,
                    "1",
                    "largest reduced position over its training range, in each period after release and the next",
                ),
                "frc_amplitude": variable(
                    (*pair, "angular_frequency"),
                    self.frc_amplitude,
                    "m",
                    "amplitude of the first probe on the scene's response curve",
                ),
                "frc_outcome": variable(
                    (*pair, "angular_frequency"),
                    self.frc_outcome,
                    "1",
                    "how the run of the response curve ended",
                ),
                "decay_nmte": variable(
                    pair, self.decay_nmte, "percent", "NMTE of the unseen decay"
                ),
                "forced_nmte": variable(
                    pair, self.forced_nmte, "percent", "NMTE of the forced run, last period"
                ),
                "real_part": variable(
                    pair,
                    self.real_part,
                    "s-1",
                    "real part of the first pair of eigenvalues at rest",
                ),
            },
            coords={
                "guard": variable(
                    "guard", np.array(self.guards, dtype=object), "1", "guard of the fitted model"
                ),
                "integrator": variable(
                    "integrator",
                    np.array(self.integrators, dtype=object),
                    "1",
                    "integrator of the reduced model",
                ),
                "angular_frequency": variable(
                    "angular_frequency",
                    self.frequency,
                    "rad s-1",
                    "angular frequency of the forcing",
                ),
            },
        )
