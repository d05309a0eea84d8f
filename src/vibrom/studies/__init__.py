"""One file a study: something is varied, and the full order or fitted models are evaluated again.

A file defines one frozen dataclass below `Study`, named like the file. Its fields are its settings,
the block `studies.<name>` of the configuration. Class constants, which are literals, say what its
jobs are; a kind of job is `scene`, one for each scene, of the full order; `model`, one for each
fitted model; or `models`, one for each scene, of all its fitted models.

    jobs         kind -> the artefact that a job of this kind makes
    reads        kind -> what the job reads besides the scene's structure and its fitted models:
                 `full_order/<name>`, an artefact of the full order, or the name of an experiment,
                 the answer of each of its fitted models
    experiments  those whose settings the study needs
    settings     kind -> the fields that a job depends on, and the only ones that it has; all of
                 them where nothing is said
    parts        kind -> module below vibrom that does the job with `made(study, case)`; a study
                 without it has the methods `of_scene`, `of_model` or `of_models` in its own file
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar, get_type_hints

import msgspec
import xarray as xr

from vibrom.artefacts.outcome import Outcome
from vibrom.config.errors import closest
from vibrom.config.kinds import Name
from vibrom.experiments import Experiment, Given, experiment, is_comparable

KINDS = ("scene", "model", "models")


class StudyError(ValueError):
    """A study that is not what its folder promises; the message names the cure."""


@dataclass(frozen=True)
class Fitted:
    """A fitted model of the run."""

    record: xr.Dataset  # what its fit stored
    answers: Mapping[str, xr.Dataset] = field(default_factory=dict)  # its own, by experiment

    @property
    def outcome(self) -> Outcome:
        """How its fit ended."""
        return Outcome(str(self.record["outcome"].item()))


@dataclass(frozen=True)
class Case:
    """What a job is given."""

    scene: Mapping[str, Any]  # the blocks body, effects, record, time and experiments
    structure: xr.Dataset
    full_order: Mapping[str, xr.Dataset] = field(default_factory=dict)  # what is read, by name
    fitted: tuple[Fitted, ...] = ()  # none of `scene`, one of `model`, all of `models`
    integrator: Mapping[str, Any] = field(default_factory=dict)  # of the run's reduced models
    # by name: kind (its file), settings, seeded, and start (the method that it starts from)
    methods: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    seed: int | None = None  # the first of the run, of models that are fitted in the study
    device: str = "cpu"  # where these are fitted

    def settings(self, name: str) -> Mapping[str, Any]:
        """An experiment's settings in this scene."""
        known: Mapping[str, Mapping[str, Any]] = self.scene["experiments"]
        if name not in known:
            cure = "add it to the scene's file, or leave the scene out of the study"
            raise StudyError(f"the scene has no experiments.{name}, which the study needs; {cure}")
        return known[name]

    def question(self, name: str) -> Experiment:
        """An experiment with the settings of this scene."""
        return experiment(name, self.settings(name))

    def truth(self, name: str) -> Any:
        """The dataset that answers to an experiment are compared with; None where there is none."""
        truth = self.question(name).truth
        return None if truth is None else self.full_order[truth]

    def is_comparable(self, name: str) -> bool:
        """Did the full-order run go all the way that answers are compared with?"""
        return is_comparable(self.truth(name))

    @property
    def given(self) -> Given:
        """What an experiment is given."""
        time = self.scene["time"]
        return Given(self.structure, time["steps_per_period"] // time["every"], self.full_order)


@dataclass(frozen=True)
class Study:
    """The fields of a class below are its settings."""

    # those that are studied, of those of the run; null: all of these
    scenes: list[Name] | None = field(default=None, kw_only=True)

    jobs: ClassVar[Mapping[str, str]] = {}
    reads: ClassVar[Mapping[str, tuple[str, ...]]] = {}
    experiments: ClassVar[tuple[str, ...]] = ()
    settings: ClassVar[Mapping[str, tuple[str, ...]]] = {}
    parts: ClassVar[Mapping[str, str]] = {}

    def of_scene(self, case: Case) -> xr.Dataset:
        """The artefact of a scene."""
        return self._part("scene", case)

    def of_model(self, case: Case) -> xr.Dataset:
        """The artefact of a fitted model."""
        return self._part("model", case)

    def of_models(self, case: Case) -> xr.Dataset:
        """The artefact of all fitted models of a scene."""
        return self._part("models", case)

    def job(self, kind: str, case: Case) -> xr.Dataset:
        """The artefact of a job of this kind."""
        return {"scene": self.of_scene, "model": self.of_model, "models": self.of_models}[kind](
            case
        )

    def _part(self, kind: str, case: Case) -> xr.Dataset:
        """By a module that is imported by its name: what other kinds need is not behind it."""
        if kind not in self.parts:
            name = type(self).__name__
            raise StudyError(f"{name} has neither of_{kind} nor a part for it; write one of them")
        made: xr.Dataset = importlib.import_module(f"vibrom.{self.parts[kind]}").made(self, case)
        return made


def plug(name: str) -> type[Study]:
    """The one class below Study that `studies/<name>.py` defines."""
    module = importlib.import_module(f"vibrom.studies.{name}")
    found = [
        item
        for item in vars(module).values()
        if isinstance(item, type) and issubclass(item, Study) and item.__module__ == module.__name__
    ]
    if len(found) != 1 or found[0].__name__.lower() != name.replace("_", ""):
        names = ", ".join(item.__name__ for item in found) or "no study"
        cure = "define exactly one subclass of Study, and name it like the file"
        raise StudyError(f"studies/{name}.py defines {names}; {cure}")
    if unknown := sorted(set(found[0].jobs) - set(KINDS)):
        raise StudyError(
            f"studies/{name}.py: jobs: {unknown[0]!r} is no kind of job; "
            f"choose from {', '.join(KINDS)}"
        )
    return found[0]


def study(name: str, settings: Mapping[str, Any]) -> Study:
    """The study of this name with these settings; those that a job does not depend on stay away."""
    kind = plug(name)
    types, known = get_type_hints(kind, include_extras=True), [item.name for item in fields(kind)]
    made = object.__new__(kind)
    for key, value in settings.items():
        if key not in known:
            raise StudyError(f"studies.{name}.{key} is no setting; {closest(key, known)}")
        try:
            object.__setattr__(made, key, msgspec.convert(value, types[key]))
        except msgspec.ValidationError as wrong:
            raise StudyError(f"studies.{name}.{key}: {wrong}; change it") from wrong
    return made
