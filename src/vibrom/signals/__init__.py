"""One file a signal: a frozen dataclass of its settings whose `at(t)` gives u at instants t [s]
after the start.

Loads say under `signal` which drive them; several add up. What a signal's unit is, its load says.
"""

import importlib
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from vibrom.config.instance import instance, plug


class SignalError(ValueError):
    """Settings of a signal that cannot be meant; the message names the cure."""


Function = Callable[[np.ndarray], np.ndarray]


def load(name: str, settings: Mapping[str, Any]) -> Any:
    """The signal of this name: the one class of `signals/<name>.py` with an `at`."""
    kind = plug(importlib.import_module(f"vibrom.signals.{name}"), "at", SignalError)
    return instance(kind, settings, f"signal.{name}", SignalError)


def total(settings: Mapping[str, Mapping[str, Any]]) -> Function:
    """u(t), the sum of these signals."""
    parts = [load(name, own or {}) for name, own in settings.items()]
    return lambda instants: np.sum([part.at(instants) for part in parts], axis=0)
