"""The grid of hard cases, and how one reduced model gets through it.

Forced from rest at every level and frequency of the grid; let go from random states that lie as far
as `beyond` times the training range out; and forced from such states at the scene's own level.
Every run ends with an outcome: `ok` and `left_range` have gone all the way.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vibrom.models.rollout import Drive, Integrator, rollout
from vibrom.models.rom import Rom

KINDS = ("forced from rest", "released", "forced from a release")
SAMPLES, THIN = 32, 4  # samples of a period, and each how many of them is decoded for its energy


@dataclass(frozen=True)
class Cases:
    """One entry a run: kind (place in KINDS), forcing over the scene's, frequency over omega_d,
    radius of the release state over the training range (zero: from rest), and the draw of uniform
    numbers that its direction is made of.
    """

    kind: np.ndarray
    forcing: np.ndarray
    frequency: np.ndarray
    radius: np.ndarray
    draw: np.ndarray

    def start(self, reach: np.ndarray) -> np.ndarray:
        """Z (b, r): each oscillator at its own angle, all at the radius."""
        angle = 2 * np.pi * ((self.draw[:, None] + np.sqrt(2.0) * np.arange(len(reach) // 2)) % 1.0)
        return self.radius[:, None] * np.concatenate([np.cos(angle), np.sin(angle)], axis=1) * reach


def cases(
    forcing: list[float], frequency: np.ndarray, releases: int, beyond: float, seed: int = 0
) -> Cases:
    """The same for every model: `releases` states let go, and as many forced."""
    rng = np.random.default_rng(seed)
    level, rate = (part.ravel() for part in np.meshgrid(forcing, frequency, indexing="ij"))
    from_rest, unforced, forced = len(level), np.zeros(releases), np.ones(releases)
    return Cases(
        np.repeat([0, 1, 2], [from_rest, releases, releases]),
        np.concatenate([level, unforced, forced]),
        np.concatenate([rate, forced, rng.uniform(frequency.min(), frequency.max(), releases)]),
        np.concatenate([np.zeros(from_rest), rng.uniform(0.0, beyond, 2 * releases)]),
        np.concatenate([np.zeros(from_rest), rng.uniform(0.0, 1.0, 2 * releases)]),
    )


def survive(
    rom: Rom,
    chosen: Cases,
    load: np.ndarray,
    forcing: float,
    omega: float,
    periods: int,
    integrator: Integrator,
):
    """Outcome (b,), failed_at (b,) in periods of the forcing (or when the run left its range),
    range_ratio (b,).
    """
    frequency = chosen.frequency * omega
    period = 2 * np.pi / frequency
    drive = Drive(load, chosen.forcing * forcing, frequency)
    run = rollout(rom, chosen.start(rom.reach), periods * period[:, None], integrator, drive)
    return np.array(run.outcome, dtype=object), run.failed_at / period, run.range_ratio


def let_go(
    rom: Rom, chosen: Cases, omega: float, periods: int, integrator: Integrator, energy_of
) -> tuple[np.ndarray, np.ndarray]:
    """Of the runs that are let go, for each period (releases, periods): the mean energy [J] of the
    decoded states, for which `energy_of` takes displacement and velocity (m, n), and the largest
    reduced position over its training range in this period and the next. NaN after a failure.

    Two periods, as a soft model swings more slowly than the structure, and not as far to one side
    as to the other.
    """
    start = chosen.start(rom.reach)[chosen.kind == 1]
    times = 2 * np.pi / omega * np.arange((periods + 1) * SAMPLES) / SAMPLES
    run = rollout(rom, start, np.tile(times, (len(start), 1)), integrator)
    largest = (
        (np.abs(run.reduced) / rom.reach)[..., : len(rom.reach) // 2]
        .max(axis=2)
        .reshape(len(start), periods + 1, SAMPLES)
        .max(axis=2)
    )
    some = run.reduced[:, : periods * SAMPLES : THIN]
    values = np.full(some.shape[:2], np.nan)
    alive = np.isfinite(some).all(axis=2)
    state = rom.decode(some[alive])
    n = state.shape[-1] // 2
    values[alive] = energy_of(state[:, :n], state[:, n:])
    return values.reshape(len(start), periods, -1).mean(axis=2), np.maximum(
        largest[:, :-1], largest[:, 1:]
    )


def rises(values: np.ndarray, tolerance: float = 0.01) -> np.ndarray:
    """(releases,): whether `values` (releases, periods) grew from one period to the next by more
    than `tolerance` of the largest, or ended early.

    A hundredth is twice what the samples miss of a maximum between them, (pi/32)^2/2.
    """
    grown = np.diff(values, axis=1) > tolerance * np.max(
        values, axis=1, keepdims=True, where=np.isfinite(values), initial=0.0
    )
    return grown.any(axis=1) | ~np.isfinite(values).all(axis=1)
