"""Simulating a reduced-order model: decays, forced responses and sweeps are this one function of
its four.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from vibrom.models.rom import Rom
from vibrom.models.training import MethodError

LIMIT = 10.0  # times the training range: beyond it a run has diverged
# times the training range: beyond it a run has left the range; the margin covers the training
# data's own sampling
MARGIN = 1.01

# of 1/omega: a twentieth of what the method takes later, and the mean step below which a run crawls
FIRST_STEP = 0.05


@dataclass(frozen=True)
class Integrator:
    """rtol relative; atol as a fraction of the training range of each reduced coordinate. `dop853`
    chooses its steps by them; `gauss`, which is implicit, takes `steps` equal ones to a period of
    the fastest reduced coordinate, and iterates to them.
    """

    rtol: float = 1e-8
    atol: float = 1e-10
    method: str = "dop853"
    steps: int = 40

    def __post_init__(self) -> None:
        if self.method not in ("dop853", "gauss"):
            raise MethodError(f"integrator.method is {self.method!r}; give dop853 or gauss")


@dataclass(frozen=True)
class Drive:
    """The load p (n,) [N] times amplitude sin(frequency t), one amplitude and one angular frequency
    [rad/s] for each of the b runs.
    """

    load: np.ndarray
    amplitude: np.ndarray
    frequency: np.ndarray


@dataclass(frozen=True)
class Rollout:
    """reduced (b, m, r), NaN after a failure; outcome and failed_at [s] of each run (or when it
    left the training range); range_ratio (b,): the largest |z| over the largest in the training
    data; seconds of wall time.
    """

    reduced: np.ndarray
    outcome: list[str]
    failed_at: np.ndarray
    range_ratio: np.ndarray
    seconds: float


def rollout(
    rom: Rom,
    start: np.ndarray,
    times: np.ndarray,
    integrator: Integrator,
    drive: Drive | None = None,
) -> Rollout:
    """Z from `start` (b, r) at t = 0, sampled at `times` (b, m) [s]; the fastest reduced coordinate
    sets the first step.
    """
    field = rom.field(None if drive is None else drive.load)
    # Reaches of z and of dz/dt differ by the frequency of the motion: their ratio is a time scale.
    tempo = float(np.min(rom.reach[: len(rom.reach) // 2] / rom.reach[len(rom.reach) // 2 :]))
    settings = dict(
        rtol=integrator.rtol,
        atol=integrator.atol * rom.reach,
        reach=MARGIN * rom.reach,
        limit=LIMIT * rom.reach,
    )
    steps = dict(
        first_step=FIRST_STEP * tempo, max_steps=int(times.max() / (FIRST_STEP * tempo)) + 1000
    )
    forcing = {} if drive is None else {"amplitude": drive.amplitude, "frequency": drive.frequency}
    # Imported here: half of what a job without a rollout would spend on imports.
    if integrator.method == "gauss":
        from vibrom.solvers.reduced.gauss import integrate

        if field is None:
            raise MethodError(
                f"integrator.method gauss needs compiled code, and {type(rom).__name__} has none (Rom.field); set method: dop853"
            )
        began = time.perf_counter()
        solution = integrate(
            field, start, times, **settings, **forcing, step=2 * np.pi * tempo / integrator.steps
        )
    elif field is None:
        from vibrom.solvers.reduced.dop853 import integrate

        began = time.perf_counter()
        solution = integrate(_numpy_field(rom, drive), start, times, **settings, **steps)
    else:
        from vibrom.solvers.reduced.dop853_loop import integrate

        began = time.perf_counter()
        solution = integrate(field, start, times, **settings, **steps, **forcing)
    outcome, failed_at = (
        list(solution.outcome),
        np.where(solution.outcome == "ok", np.nan, solution.ended_at),
    )
    for index, word in enumerate(outcome):
        if word == "ok" and not np.isnan(solution.left_at[index]):
            outcome[index], failed_at[index] = "left_range", solution.left_at[index]
    return Rollout(
        solution.samples,
        outcome,
        failed_at,
        (solution.peak / rom.reach).max(axis=1),
        time.perf_counter() - began,
    )


def _numpy_field(rom: Rom, drive: Drive | None):
    """dz/dt of the runs that are still going, from the four functions alone."""

    def free(t, z, run):
        return rom.drift(z)

    def driven(t, z, run):
        signal = drive.amplitude[run] * np.sin(drive.frequency[run] * t)
        return rom.drift(z) + rom.force_map(z, drive.load) * signal[:, None]

    return free if drive is None else driven


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
