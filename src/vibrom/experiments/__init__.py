"""One file an experiment: a question put to any model, and the numbers that score the answer.

A file defines one frozen dataclass below `Experiment`. Its fields are its settings: a scene's
`experiments.<name>` block. Class constants, which are literals, say what it reads:

    scores         name -> unit of the numbers that `score` gives
    reads          artefacts besides the scene's structure: `train` and `test`, the recorded decays;
                   `fit`, the fitted model's record; or another experiment, meaning the same model's
                   answer to it
    truth          what answers are compared with: `test`, or an experiment, meaning the full
                   order's answer to it; None where there is nothing to compare with
    of_full_order  whether the full order is evaluated too
    of_model       whether a model is evaluated; False where only other answers are read
    where_set      whether a scene takes part only if its file has a block of the experiment's name
    job            the job in which a model is asked it together with others: a short answer takes
                   less than a process of its own; None: a job of its own, and an edit of the
                   experiment makes no other answer again
"""

from __future__ import annotations

import dataclasses
import importlib
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import xarray as xr

from vibrom.artefacts.outcome import Outcome
from vibrom.models.model import Model


@dataclass(frozen=True)
class Given:
    """What is known of a scene when a model is evaluated in it."""

    structure: xr.Dataset
    samples: int  # of a period, that the full order stores
    answers: Mapping[str, xr.Dataset]  # what the experiment reads, by name
    title: str = ""  # of bars of progress: whose answer this is, and a colon

    @property
    def probe(self) -> xr.Variable:
        """Names of the probes, as a coordinate."""
        return self.structure["probe"].variable


@dataclass(frozen=True)
class Experiment(ABC):
    """A question. Its fields are settings."""

    scores: ClassVar[Mapping[str, str]] = {}
    reads: ClassVar[tuple[str, ...]] = ()
    truth: ClassVar[str | None] = None
    of_full_order: ClassVar[bool] = True
    of_model: ClassVar[bool] = True
    where_set: ClassVar[bool] = False
    job: ClassVar[str | None] = None

    @abstractmethod
    def ask(self, model: Model, given: Given) -> xr.Dataset:
        """The model's answer, with `outcome`, `failed_at` and `seconds`."""

    def score(self, answer: xr.Dataset, truth: xr.Dataset) -> dict[str, float]:
        """The numbers of `scores`; `truth` has the shape of an answer or of a recorded decay."""
        return {}

    def stored(self, answer: xr.Dataset, truth: xr.Dataset) -> xr.Dataset:
        """What is kept of an answer once it is scored, with what the truth adds to it."""
        return answer

    def brief(self) -> Self:
        """The same question, as short as it can be: evaluated first, so that it compiles."""
        return self


def plug(name: str) -> type[Experiment]:
    """The one class below Experiment that `experiments/<name>.py` defines."""
    module = importlib.import_module(f"vibrom.experiments.{name}")
    found = [
        item
        for item in vars(module).values()
        if isinstance(item, type)
        and issubclass(item, Experiment)
        and item.__module__ == module.__name__
    ]
    if len(found) != 1:
        raise ExperimentError(
            f"experiments/{name}.py defines {len(found)} experiments; define exactly one subclass "
            "of Experiment"
        )
    return found[0]


def experiment(name: str, settings: Mapping[str, Any] | None = None) -> Experiment:
    """The experiment of this name, with these settings."""
    kind = plug(name)
    known = {item.name for item in dataclasses.fields(kind)}
    if unknown := sorted(set(settings or {}) - known):
        raise ExperimentError(
            f"experiments.{name}.{unknown[0]} is no setting; choose from {', '.join(sorted(known))}"
        )
    return kind(**(settings or {}))


class ExperimentError(ValueError):
    """An experiment that is not what its folder promises; the message names the cure."""


def at_rest(model: Model, runs: int = 1) -> np.ndarray:
    """`runs` states (runs, 2n) at rest."""
    return np.zeros((runs, 2 * model.size))


def is_comparable(truth: xr.Dataset | None) -> bool:
    """Did the full-order run go all the way that answers are compared with? Of many runs each point
    has an outcome of its own.
    """
    if truth is None or truth["outcome"].ndim:
        return True
    return Outcome(str(truth["outcome"].item())).has_value
