"""Models that a study fits to the training decay of a scene, each recipe once."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np

from vibrom.artefacts.outcome import Outcome
from vibrom.methods import method_from_settings
from vibrom.models.method import Method
from vibrom.models.recorded import structure, trajectory
from vibrom.models.rom import Rom, rom_from_dataset
from vibrom.models.training import MethodError, Monitor, Training, TrainingDiverged, Trajectory
from vibrom.studies import Case, Fitted
from vibrom.studies.parts.timing import Measured, repeated


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
    def of_run(
        cls, model: Fitted, data: float, answers: Mapping[str, Measured] | None = None
    ) -> Fit:
        """A model of the run whose training data took `data` seconds."""
        record, outcome = model.record, model.outcome
        rom = rom_from_dataset(record) if outcome.has_value else None
        mapping, dynamics = (float(record[f"{part}_seconds"]) for part in ("mapping", "dynamics"))
        return cls(rom, outcome, data, mapping, dynamics, answers=answers or {})

    @property
    def record(self) -> dict[str, float]:
        """The entries of a record."""
        seconds = {name: getattr(self, name) for name in ("data", "mapping", "dynamics")}
        return {f"{name}_seconds": value for name, value in seconds.items()} | {"fits": self.fits}


class Clock(Monitor):
    """Seconds of each phase of a fit."""

    def __init__(self) -> None:
        self.seconds = {"mapping": 0.0, "dynamics": 0.0}

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Adds to a phase."""
        began = perf_counter()
        try:
            yield
        finally:
            self.seconds[name] += perf_counter() - began


class Fits:
    """The training data of a scene, and the models that were fitted to it."""

    def __init__(self, case: Case, repeats: int, patience: float):
        self.repeats, self.patience = repeats, patience
        train = case.full_order["train"]
        self.seconds, self.period = float(train["seconds"]), float(train["period"])
        self.recorded = Outcome(str(train["outcome"].item())).has_value
        self.motion = trajectory(train)
        self.training = Training(
            (self.motion,), structure(case.structure), seed=case.seed, device=case.device
        )
        self.known: dict[str, Fit] = {}
        self.warm: set[str | None] = set()

    def add(self, recipe: Recipe, model: Fitted, answers: Mapping[str, Measured]) -> None:
        """A model that the run has fitted."""
        self.known[recipe.key] = Fit.of_run(model, self.seconds, answers)

    def of(self, recipe: Recipe) -> Fit:
        """The model of a recipe; `skipped` where its settings do not go together."""
        try:
            if recipe.key not in self.known:
                self.known[recipe.key] = self._fit(recipe)
            return self.known[recipe.key]
        except MethodError as error:
            print(f"{recipe.kind}: {dict(recipe.settings)} is skipped: {error}", file=sys.stderr)
            return Fit(None, Outcome.SKIPPED, self._selected(recipe)[1])

    def _fit(self, recipe: Recipe) -> Fit:
        """Medians of a few fits, after one that loads libraries at their first use."""
        motion, data = self._selected(recipe)
        start = None if recipe.start is None else self.of(recipe.start)
        fit = Fit(None, Outcome.OK, data, 0.0 if start is None else start.mapping)
        if not self.recorded:
            return replace(fit, outcome=Outcome.REFERENCE_FAILED)
        if start is not None and start.rom is None:
            return replace(fit, outcome=start.outcome)
        training = replace(self.training, trajectories=(motion,), start=start and start.rom)
        clocks: list[Clock] = []

        def call() -> tuple[Rom, float]:
            clocks.append(Clock())
            return learnt(recipe.method(), training, clocks[-1])

        try:
            if recipe.kind not in self.warm:
                learnt(_brief(recipe).method(), training, Clock())
                self.warm.add(recipe.kind)
            rom, _, fits = repeated(call, self.repeats, self.patience)
        except TrainingDiverged:
            return replace(fit, outcome=Outcome.TRAINING_DIVERGED)
        mapping, dynamics = (
            median(clock.seconds[name] for clock in clocks) for name in ("mapping", "dynamics")
        )
        mapping += fit.mapping
        return replace(fit, rom=rom, mapping=mapping, dynamics=dynamics, fits=fits)

    def _selected(self, recipe: Recipe) -> tuple[Trajectory, float]:
        """The training motion that is used, and the seconds that its simulation took."""
        time, share = self.motion.time - self.motion.time[0], 1.0
        end = len(time)
        if recipe.periods is not None:
            length = recipe.periods * self.period
            end, share = max(2, int(np.searchsorted(time, length))), min(1.0, length / time[-1])
        kept = slice(0, end, recipe.thin)
        parts = ("time", "displacement", "velocity", "acceleration")
        return Trajectory(*(getattr(self.motion, name)[kept] for name in parts)), (
            share * self.seconds
        )


def learnt(method: Method, training: Training, clock: Clock) -> tuple[Rom, float]:
    """A fitted model and the seconds that it took; what is in no phase counts as dynamics."""
    began = perf_counter()
    rom = method.learn(replace(training, monitor=clock))
    seconds = perf_counter() - began
    clock.seconds["dynamics"] = seconds - clock.seconds["mapping"]
    return rom, seconds


def _brief(recipe: Recipe) -> Recipe:
    """The same in one epoch, where there are epochs."""
    if "epochs" not in asdict(recipe.method()):
        return recipe
    return replace(recipe, settings={**recipe.settings, "epochs": 1})
