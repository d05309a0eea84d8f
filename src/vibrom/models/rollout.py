"""Simulating a reduced-order model: decays, forced responses and sweeps are this one function of
its four.

    dz/dt = drift(z) + force_map(z, p) a sin(w t)
"""

from __future__ import annotations

import pkgutil
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Annotated

import numpy as np
from msgspec import Meta

from vibrom.artefacts.outcome import Outcome
from vibrom.config.kinds import Stepper, Tolerance
from vibrom.models.rom import Rom
from vibrom.models.training import MethodError
from vibrom.solvers.reduced import steppers

if TYPE_CHECKING:
    from vibrom.models.model import Signals
    from vibrom.solvers.reduced.field import VectorField
    from vibrom.solvers.reduced.records import Solution

LIMIT = 10.0  # of the training range: beyond it a run has diverged
# of the training range: beyond it a run has left the range; the margin covers the training data's
# own sampling
MARGIN = 1.01
STEPS = 200  # to a period of the fastest reduced coordinate, under signals of any kind


@dataclass(frozen=True)
class Integrator:
    """A method of `solvers.reduced.steppers` and what it goes by."""

    rtol: Tolerance = 1e-8  # of the state: the error of a step, or of an implicit one's iteration
    atol: Tolerance = 1e-10  # likewise, of the training range of each reduced coordinate
    method: Stepper = "dop853"
    # to a period of the fastest reduced coordinate, of methods that take equal steps
    steps: Annotated[int, Meta(ge=2)] = 40

    def __post_init__(self) -> None:
        known = sorted(module.name for module in pkgutil.iter_modules(steppers.__path__))
        if self.method not in known:
            raise MethodError(f"integrator.method is {self.method!r}; give {' or '.join(known)}")
        for name in ("rtol", "atol", "steps"):
            if not 0 < getattr(self, name) < np.inf:
                value = getattr(self, name)
                raise MethodError(f"integrator.{name} is {value!r}; give a positive number")


@dataclass(frozen=True)
class Drive:
    """The load times a sin(w t) in each of b runs."""

    load: np.ndarray  # p (n,) [N] per unit of the signal
    amplitude: np.ndarray  # a (b,) in the unit of the signal
    frequency: np.ndarray  # w (b,) [rad/s]


@dataclass(frozen=True)
class Rollout:
    """The motion of a reduced model in b runs."""

    reduced: np.ndarray  # (b, m, r), NaN after a failure
    outcome: list[Outcome]  # (b,)
    failed_at: np.ndarray  # (b,) [s], or when the run left the training range; NaN where it is ok
    range_ratio: np.ndarray  # (b,) the largest |z| over the largest in the training data
    seconds: float  # of wall time


def rollout(
    rom: Rom,
    start: np.ndarray,
    times: np.ndarray,
    integrator: Integrator,
    drive: Drive | None = None,
) -> Rollout:
    """z from `start` (b, r) at t = 0, sampled at `times` (b, m) ascending [s].

    Raises ArgumentError, a ValueError, where a shape or a value cannot be meant.
    """
    # Imported here: half of what a job without a rollout would spend on imports.
    from vibrom.solvers.reduced import records
    from vibrom.solvers.reduced.integrate import integrate

    reach = rom.reach
    stepper = import_module(f"{steppers.__name__}.{integrator.method}").stepper(
        _time_scale(reach), integrator.steps
    )
    forcing = None if drive is None else records.Forcing(drive.amplitude, drive.frequency)
    with _field(rom, None if drive is None else drive.load) as field:
        began = time.perf_counter()
        solution = integrate(
            stepper,
            field,
            start,
            times,
            records.Tolerance(integrator.rtol, integrator.atol * reach),
            records.Bounds(MARGIN * reach, LIMIT * reach),
            forcing,
        )
        seconds = time.perf_counter() - began
    return _ended(solution, reach, seconds)


def pushed(rom: Rom, start: np.ndarray, instants: np.ndarray, signals: Signals) -> Rollout:
    """z from `start` (b, r) at the first of `instants` (m,) [s], ascending, under loads with
    signals of any kind, which are taken as linear between the instants.

    Other steps than an integrator's: they end where the signals have corners, however small its
    tolerance, and are short enough beside the model's own motion that none is needed.
    """
    from vibrom.solvers.reduced import driven, records

    reach = rom.reach
    longest = 2.0 * np.pi * _time_scale(reach) / STEPS
    steps = np.maximum(np.ceil(np.diff(instants) / longest), 1.0).astype(np.int64)
    bounds, signal = records.Bounds(MARGIN * reach, LIMIT * reach), signals.value(instants)
    with ExitStack() as open_fields:
        fields = [open_fields.enter_context(_field(rom, load)) for load in signals.load]
        forces = [field.force for field in fields if field.force is not None]
        began = time.perf_counter()
        solution = driven.integrate(fields[0].drift, forces, start, instants, steps, signal, bounds)
        seconds = time.perf_counter() - began
    return _ended(solution, reach, seconds)


def _ended(solution: Solution, reach: np.ndarray, seconds: float) -> Rollout:
    """How each run ended, those among them that left the training range."""
    outcome = solution.outcome
    failed_at = np.where([item == Outcome.OK for item in outcome], np.nan, solution.ended_at)
    for run in np.flatnonzero(np.isnan(failed_at) & ~np.isnan(solution.left_at)):
        outcome[run], failed_at[run] = Outcome.LEFT_RANGE, solution.left_at[run]
    ratio = (solution.peak / reach).max(axis=1)
    return Rollout(solution.samples, outcome, failed_at, ratio, seconds)


def _time_scale(reach: np.ndarray) -> float:
    """1/w [s] of the fastest reduced coordinate: the ranges of z and of dz/dt differ by the
    frequency of the motion.
    """
    d = len(reach) // 2
    return float(np.min(reach[:d] / reach[d:]))


@contextmanager
def _field(rom: Rom, load: np.ndarray | None) -> Iterator[VectorField]:
    """The compiled field of the model, or one that calls its `drift` and `force_map`."""
    from vibrom.solvers.reduced.functions import field_of

    compiled = rom.field(load)
    if compiled is not None:
        yield compiled
        return
    force = None if load is None else lambda z: rom.force_map(z, load)
    with field_of(len(rom.reach), rom.drift, force) as field:
        yield field


def decode_displacement(
    rom: Rom, reduced: np.ndarray, dofs: np.ndarray | None = None, chunk: int = 4096
) -> np.ndarray:
    """Displacement (m, n), or (m, k) at `dofs`, of reduced states (m, r), a chunk at a time to
    bound the memory.
    """
    return np.concatenate(
        [
            rom.displacement(reduced[first : first + chunk], dofs)
            for first in range(0, len(reduced), chunk)
        ]
    )
