"""Motions under a signal that was recorded beside them.

The signal u is filtered and delayed as the channels are. So each q_k, which is made of a channel
and its delays (`preparation`), moves under a signal of its own:

    u_k(t) = (u(t + k l) + u(t - k l)) / 2,    and the load acts on the copies k of all channels

They are measured from the mean of the whole recording, or from zero.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from vibrom.artefacts.data import variable
from vibrom.config.recorded import Preparation
from vibrom.models.training import Trajectory
from vibrom.recordings.filters import differentiated
from vibrom.recordings.preparation import Decays, evenly, means
from vibrom.recordings.samples import Samples

PAUSE = 10  # steps, between recordings that follow one another


@dataclass(frozen=True)
class Forced:
    """One recording, from its first usable sample on."""

    where: str
    role: str
    motion: Trajectory  # of all q_k, channel after channel; time in s of the recording
    signal: np.ndarray  # (m, K + 1) u_k
    notes: tuple[str, ...]


def prepare_forced(
    recordings: list[Samples], decays: Decays, settings: Preparation
) -> tuple[Forced, ...]:
    """Prepared as the decays of the same body were."""
    return tuple(_prepared(item, decays, settings) for item in recordings)


def _prepared(item: Samples, decays: Decays, settings: Preparation) -> Forced:
    even = evenly(item, decays.frequency, decays.step, settings)
    values, channels, notes = even.values.copy(), len(even.names), even.notes
    if settings.rest == "tail":
        mean = values[:, :channels].mean(axis=0)
        values[:, :channels] -= mean
        notes += (f"mean at {', '.join(f'{value:.3g}' for value in mean)} m",)
    states, lost, _ = differentiated(
        values, even.step, decays.frequency, settings.filter, decays.kept
    )
    pairs, lag = decays.delays // 2, round(decays.lag / even.step)
    q, v, a = (means(part[:, :channels], pairs, lag, item.where) for part in states)
    signal = means(states[0][:, channels:], pairs, lag, item.where)
    time = even.time[lost + pairs * lag :][: len(q)]
    return Forced(item.where, item.role, Trajectory(time, q, v, a), signal, notes)


def forced_variables(
    items: tuple[Forced, ...], load: np.ndarray, unit: str, copies: int
) -> dict[str, xr.Variable]:
    """The motions one after the other, their signals, and the load (c,) of the channels on each
    of their copies.
    """
    starts, first = [], 0.0
    for item in items:
        own = item.motion.time - item.motion.time[0]
        starts.append(first + own)
        first += own[-1] + PAUSE * own[1]
    lengths, sample = [len(own) for own in starts], "signal_sample"
    number = np.arange(len(items))
    calibrates = [item.role == "calibration" for item in items]
    q, v = (
        np.concatenate([getattr(item.motion, name) for item in items])
        for name in ("displacement", "velocity")
    )
    loads = np.stack([np.outer(load, one).ravel() for one in np.eye(copies)])
    return {
        "signal_time": variable(sample, np.concatenate(starts), "s", "time under the signal"),
        "signal_displacement": variable((sample, "dof"), q, "m", "displacement under the signal"),
        "signal_velocity": variable((sample, "dof"), v, "m s-1", "velocity under the signal"),
        "signal_value": variable(
            (sample, "delay"),
            np.concatenate([item.signal for item in items]),
            "1",
            "the signal, in its own unit, as the copies of a channel have it",
        ),
        "signal_part": variable(sample, np.repeat(number, lengths), "1", "number of the recording"),
        "signal_calibrates": variable(
            sample,
            np.repeat(np.array(calibrates, int), lengths),
            "1",
            "1: of the recording that tells the strength of the load",
        ),
        "signal_load": variable(
            ("delay", "dof"), loads, unit, "load on the copies of the channels, per unit of theirs"
        ),
    }
