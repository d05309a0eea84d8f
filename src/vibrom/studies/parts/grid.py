"""The grid of demanding runs, and how a reduced model gets through it.

Forced from rest at every level and frequency; released from random states as far as `beyond` times
the training range out; and forced from such states at the scene's own level. Every run ends with an
outcome; those with a value have gone all the way.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vibrom.models.reduced import Reduced
from vibrom.models.rollout import Drive, Rollout, rollout

KINDS = ("forced from rest", "released", "forced from a release")
RELEASED = 1  # place in KINDS
SAMPLES = 32  # of a period, of a decay
DECODED = 8  # of these, for their energy


@dataclass(frozen=True)
class Cases:
    """One entry a run."""

    kind: np.ndarray  # place in KINDS
    forcing: np.ndarray  # amplitude, times the scene's
    frequency: np.ndarray  # of the forcing, times the damped first frequency
    radius: np.ndarray  # of the release state, divided by the training range; zero: from rest
    draw: np.ndarray  # uniform in [0, 1), of which the direction of the release state is made

    def start(self, reach: np.ndarray) -> np.ndarray:
        """Reduced coordinates (b, r): each oscillator at its own angle, all at the radius."""
        angle = 2 * np.pi * ((self.draw[:, None] + np.sqrt(2.0) * np.arange(len(reach) // 2)) % 1.0)
        return self.radius[:, None] * np.concatenate([np.cos(angle), np.sin(angle)], axis=1) * reach


def cases(
    forcing: list[float], frequency: np.ndarray, releases: int, beyond: float, seed: int = 0
) -> Cases:
    """The same for every model: `releases` states that are released, and as many forced."""
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


def ended(
    model: Reduced, chosen: Cases, forcing: float, periods: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Outcome (b,), failed_at (b,) in periods of the forcing, and range_ratio (b,) after `periods`.

    What is released is left alone: that its force would be zero need not be computed.
    """
    outcome = np.empty(len(chosen.kind), dtype=object)
    failed_at, ratio = (np.empty(len(chosen.kind)) for _ in range(2))
    frequency = chosen.frequency * model.frequency
    period, start = 2 * np.pi / frequency, chosen.start(model.rom.reach)
    released = chosen.kind == RELEASED
    for runs, driven in ((~released, True), (released, False)):
        drive = Drive(model.load, chosen.forcing[runs] * forcing, frequency[runs])
        times = periods * period[runs, None]
        run = rollout(model.rom, start[runs], times, model.integrator, drive if driven else None)
        outcome[runs] = [str(word) for word in run.outcome]
        failed_at[runs], ratio[runs] = run.failed_at / period[runs], run.range_ratio
    return outcome, failed_at, ratio


def decays(
    model: Reduced,
    chosen: Cases,
    periods: int,
    energy_of: Callable[[np.ndarray, np.ndarray], np.ndarray],
) -> tuple[np.ndarray, np.ndarray]:
    """Of the runs that are released, for each period (releases, periods): the mean energy [J] of
    the decoded states, for which `energy_of` takes displacement and velocity (m, n), and the
    largest reduced position over its training range in this period and the next. NaN after a
    failure.

    Two periods, as a soft model swings more slowly than the structure, and not as far to one side
    as to the other.
    """
    start = chosen.start(model.rom.reach)[chosen.kind == RELEASED]
    times = 2 * np.pi / model.frequency * np.arange((periods + 1) * SAMPLES) / SAMPLES
    run = rollout(model.rom, start, np.tile(times, (len(start), 1)), model.integrator)
    largest = _largest(run, model.rom.reach).reshape(len(start), periods + 1, SAMPLES).max(axis=2)
    some = run.reduced[:, : periods * SAMPLES : SAMPLES // DECODED]
    values = np.full(some.shape[:2], np.nan)
    alive = np.isfinite(some).all(axis=2)
    displacement, velocity = np.split(model.rom.decode(some[alive]), 2, axis=-1)
    values[alive] = energy_of(displacement, velocity)
    mean = values.reshape(len(start), periods, -1).mean(axis=2)
    return mean, np.maximum(largest[:, :-1], largest[:, 1:])


def _largest(run: Rollout, reach: np.ndarray) -> np.ndarray:
    """The largest position over its training range (b, m)."""
    position: np.ndarray = (np.abs(run.reduced) / reach)[..., : len(reach) // 2].max(axis=2)
    return position


def rises(values: np.ndarray, tolerance: float = 0.01) -> np.ndarray:
    """(releases,): whether `values` (releases, periods) grew from one period to the next by more
    than `tolerance` of the largest, or ended early.

    A hundredth is twice what the samples miss of a maximum between them, (pi/32)^2/2.
    """
    grown = np.diff(values, axis=1) > tolerance * np.max(
        values, axis=1, keepdims=True, where=np.isfinite(values), initial=0.0
    )
    return grown.any(axis=1) | ~np.isfinite(values).all(axis=1)
