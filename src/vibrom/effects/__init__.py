"""One file an effect: a frozen dataclass of the scene's keys whose `assemble(space, base)` gives
the Term that it adds.

`base` is the sum of the effects before it. Their order is not that of the scene: `STAGE`, a
constant of the file, names what an effect adds first, and stages follow one another as
`vibrom.config.scene.STAGES`. An effect that a scene does not list is never imported; one that acts
more than once has a list of settings.

A load without a signal is what experiments drive: p a sin(w t), each with its own amplitude and
frequency. One with a `signal` stands still in all of them but `response`, where it acts with that
signal, alone or with such a sine on top. A load for both is listed twice, once without a signal.
"""

import importlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np

from vibrom.bodies.space import Space
from vibrom.config.instance import instance, plug
from vibrom.config.kinds import Signal
from vibrom.config.scene import STAGES, USUAL_STAGE
from vibrom.term import Driven, SceneError, Term

Entry = Mapping[str, Any] | Sequence[Mapping[str, Any]] | None


@dataclass(frozen=True, kw_only=True)
class Load:
    """What every load may say beside where it acts."""

    factor: float = 1.0  # times the load
    # what drives it in `response`, by name, which add up; none: what drives the experiments
    signal: Signal | None = None

    def acting(self, load: np.ndarray) -> Term:
        """The Term of this load (n,) [N per unit of the signal]."""
        if self.signal is None:
            return Term(load=self.factor * load)
        return Term(driven=(Driven(self.factor * load, self.signal),))


def assemble(space: Space, effects: Mapping[str, Entry]) -> Term:
    """The sum of the effects of a scene."""
    total = Term()
    for name in sorted(effects, key=_place):
        total = total + brought(name, effects[name], space, total)
    return total


def brought(name: str, entry: Entry, space: Space, base: Term) -> Term:
    """What a scene's entry adds to `base`: one effect, or several of a kind."""
    total = Term()
    for settings in entry if isinstance(entry, list) else [entry]:
        total = total + load(name, settings or {}).assemble(space, base + total)
    return total


def load(name: str, settings: Mapping[str, Any]) -> Any:
    """The effect of this name: the one class of `effects/<name>.py` that assembles."""
    kind = plug(_module(name), "assemble", SceneError)
    return instance(kind, settings, f"effects.{name}", SceneError)


def _module(name: str) -> ModuleType:
    return importlib.import_module(f"vibrom.effects.{name}")


def _place(name: str) -> tuple[int, str]:
    return STAGES.index(getattr(_module(name), "STAGE", USUAL_STAGE)), name
