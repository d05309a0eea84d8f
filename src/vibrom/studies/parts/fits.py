"""Models that a study fits to the training decay of a scene, or to its equations of motion, each
recipe once.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from statistics import median
from typing import Any

import numpy as np

from vibrom.artefacts.outcome import Outcome
from vibrom.methods import method_from_settings
from vibrom.models.full_order import FullOrder
from vibrom.models.method import Method
from vibrom.models.recorded import structure, trajectory
from vibrom.models.rom import Rom, rom_from_dataset
from vibrom.models.training import (
    Clock,
    MethodError,
    Training,
    TrainingDiverged,
    Trajectory,
    Underdetermined,
)
from vibrom.studies import Case, Fitted
from vibrom.studies.parts.timing import Measured, repeated
from vibrom.term import Term


@dataclass(frozen=True)
class Recipe:
    """How a model is fitted."""

    kind: str | None  # the method's file; None: fitted outside, and not here
    settings: Mapping[str, Any]
    thin: int = 1  # train on every k-th sample
    periods: int | None = None  # train on the first k periods; None: on all
    start: Recipe | None = None  # of the model that this one starts from

    def method(self) -> Method:
        """The method with these settings; a MethodError where they do not go together."""
        if self.kind is None:
            raise MethodError("the method is fitted outside; vary its integrator alone")
        return method_from_settings(self.kind, dict(self.settings))

    @property
    def key(self) -> str:
        """The same for recipes that make the same model."""
        settings = self.settings if self.kind is None else asdict(self.method())
        start = self.start and self.start.key
        return json.dumps([self.kind, settings, self.thin, self.periods, start], sort_keys=True)


@dataclass(frozen=True)
class Fit:
    """A model, or the outcome that stands for it, and what it took."""

    rom: Rom | None
    outcome: Outcome
    data: float = 0.0  # s, of the training data
    mapping: float = 0.0  # s, that of a model to start from included
    dynamics: float = 0.0  # s
    fits: int = 1  # behind the median
    answers: Mapping[str, Measured] = field(default_factory=dict)  # that are known

    @classmethod
    def of_run(cls, model: Fitted, answers: Mapping[str, Measured] | None = None) -> Fit:
        """A model of the run."""
        record, outcome = model.record, model.outcome
        rom = rom_from_dataset(record) if outcome.has_value else None
        data, mapping, dynamics = (
            float(record[f"{part}_seconds"]) for part in ("data", "mapping", "dynamics")
        )
        return cls(rom, outcome, data, mapping, dynamics, answers=answers or {})

    @property
    def record(self) -> dict[str, float]:
        """The entries of a record."""
        seconds = {name: getattr(self, name) for name in ("data", "mapping", "dynamics")}
        return {f"{name}_seconds": value for name, value in seconds.items()} | {"fits": self.fits}


class Fits:
    """The training data of a scene, and the models that were fitted to it."""

    def __init__(self, case: Case, repeats: int, patience: float):
        self.repeats, self.patience = repeats, patience
        train = case.full_order["train"]
        self.seconds, self.period = float(train["seconds"]), float(train["period"])
        self.recorded = Outcome(str(train["outcome"].item())).has_value
        self.record, self.case = trajectory(train, lazy=True), case
        self.known: dict[str, Fit] = {}

    def add(self, recipe: Recipe, model: Fitted, answers: Mapping[str, Measured]) -> None:
        """A model that the run has fitted."""
        self.known[recipe.key] = Fit.of_run(model, answers)

    def of(self, recipe: Recipe) -> Fit:
        """The model of a recipe; `skipped` where its settings do not go together."""
        try:
            if recipe.key not in self.known:
                self.known[recipe.key] = self.fit(recipe)
            return self.known[recipe.key]
        except MethodError as error:
            print(f"{recipe.kind}: {dict(recipe.settings)} is skipped: {error}", file=sys.stderr)
            return Fit(None, Outcome.SKIPPED)

    def fit(self, recipe: Recipe) -> Fit:
        """Medians of a few fits; mapping and dynamics together are all that a fit takes."""
        method = recipe.method()
        training, data = self.equations(recipe) if method.of_equations else self.motion(recipe)
        start = None if recipe.start is None else self.of(recipe.start)
        fit = Fit(None, Outcome.OK, data, 0.0 if start is None else start.mapping)
        if not self.recorded and training.trajectories:
            return replace(fit, outcome=Outcome.REFERENCE_FAILED)
        if start is not None and start.rom is None:
            return replace(fit, outcome=start.outcome)
        training = replace(training, start=start and start.rom)
        clocks: list[Clock] = []

        def call() -> tuple[Rom, float]:
            clocks.append(Clock())
            rom = method.learn(replace(training, monitor=clocks[-1]))
            return rom, clocks[-1].spent("total")

        try:
            method.prepare(training.device)
            rom, total, fits = repeated(call, self.repeats, self.patience)
        except TrainingDiverged:
            return replace(fit, outcome=Outcome.TRAINING_DIVERGED)
        except Underdetermined:
            return replace(fit, outcome=Outcome.UNDERDETERMINED)
        dynamics = median(clock.spent("dynamics") for clock in clocks)
        mapping = fit.mapping + total - dynamics
        return replace(fit, rom=rom, mapping=mapping, dynamics=dynamics, fits=fits)

    def _training(self, *motion: Trajectory, term: Term | None = None) -> Training:
        case = self.case
        known = structure(case.structure)
        return Training(motion, known, seed=case.seed, device=case.device, term=term)

    def equations(self, recipe: Recipe) -> tuple[Training, float]:
        """The equations of motion, which no seconds were spent on."""
        if recipe.thin != 1 or recipe.periods is not None:
            raise MethodError("the method has no training data; vary its own settings")
        return self._training(term=self._term), 0.0

    @cached_property
    def _term(self) -> Term:
        return FullOrder.of_scene(dict(self.case.scene), self.case.structure).term

    def motion(self, recipe: Recipe) -> tuple[Training, float]:
        """The training motion that is used, and the seconds that its simulation took."""
        time, share = self.record.time - self.record.time[0], 1.0
        end = len(time)
        if recipe.periods is not None:
            length = recipe.periods * self.period
            end, share = max(2, int(np.searchsorted(time, length))), min(1.0, length / time[-1])
        kept = slice(0, end, recipe.thin)
        parts = ("time", "displacement", "velocity", "acceleration")
        motion = Trajectory(*(getattr(self.record, name)[kept] for name in parts))
        return self._training(motion), share * self.seconds
