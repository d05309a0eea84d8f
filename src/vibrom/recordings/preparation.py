"""From samples to decaying motions that methods learn from.

samples -> equidistant -> displacement from rest -> filtered, differentiated -> from where the slow
motion begins -> delayed, with lag l:

    q_k(t) = (x(t + k l) + x(t - k l)) / 2,    k = 0 ... K,    of every channel x

With their velocities q_k', which hold the differences x(t + k l) - x(t - k l), these are the
2 K + 1 delays of Takens in other coordinates. A mode that vibrates has all q_k in phase, q_k =
cos(k omega l) x, as displacements of a body are: no method need know of delays.

Each step has a setting (`config.recorded.Preparation`), and its value may come from a rule; what
was chosen is in `chosen`, and what was done to a recording in its notes.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.signal import decimate

from vibrom.artefacts.files import DataError
from vibrom.config.recorded import Preparation
from vibrom.models.training import Trajectory
from vibrom.recordings.filters import differentiated, harmonics
from vibrom.recordings.samples import Samples, common_frequency, equidistant
from vibrom.recordings.slow import Slow, begins

OBSERVABLES = 5  # a manifold of two dimensions is embedded by 2 * 2 + 1 (Takens 1981)
WINDOW = 0.25  # periods, from the first delay to the last
TAIL = 0.1  # of a recording
STEADY = 0.01  # relative change of the amplitude over a recording, at least


@dataclass(frozen=True)
class Prepared:
    """One recording as a motion of all copies."""

    where: str
    role: str
    motion: Trajectory  # of all q_k, channel after channel; time in s of the recording
    slow: Slow
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Decays:
    """All recordings of a body, prepared alike."""

    prepared: tuple[Prepared, ...]
    names: tuple[str, ...]  # of the channels
    delays: int  # 2 K + 1 of each channel
    lag: float  # l, s
    frequency: float  # Hz, first line
    step: float  # s, between samples
    kept: int  # multiples of the first frequency, that the filter keeps
    chosen: dict[str, float | str] = field(default_factory=dict)  # what the rules found

    @property
    def probes(self) -> np.ndarray:
        """(c,) place of each channel itself, q_0."""
        return np.arange(len(self.names)) * (self.delays // 2 + 1)

    @property
    def in_phase(self) -> np.ndarray:
        """(K + 1,) cos(k omega l): what the q_k of a vibration are, over the channel."""
        return np.cos(2.0 * np.pi * self.frequency * self.lag * np.arange(self.delays // 2 + 1))

    def of(self, role: str) -> list[Prepared]:
        """Those for training, or for tests."""
        return [item for item in self.prepared if item.role == role]


def prepare(recordings: list[Samples], settings: Preparation, delays: int = 0) -> Decays:
    """Motions of recordings of one body; with so many delays whatever the settings say, where it is
    not zero.
    """
    frequency = common_frequency(recordings, settings.frequency)
    step = float(np.median([item.step for item in recordings]))
    even = [evenly(item, frequency, step, settings) for item in recordings]
    even = [at_rest(item, frequency, settings.rest) for item in even]
    for item in even:
        check_decays(item)
    found = [harmonics(item.values, item.step, frequency) for item in even]
    kept = settings.harmonics or max(found)
    delays = delays or settings.delays or delays_of(even[0].values.shape[1])
    if delays % 2 == 0:
        raise DataError(f"preparation.delays = {delays} is even; give an odd number")
    own = even[0].step
    apart = round((settings.lag or WINDOW / max(delays - 1, 1)) / (frequency * own))
    lag = max(1, apart) * own if delays > 1 else 0.0
    chosen: dict[str, float | str] = {
        "first_frequency_hz": frequency,
        "filter": settings.filter,
        "delays": delays,
        "lag_s": lag,
    }
    made = []
    for item in even:
        one, setting = motion_of(item, frequency, settings, kept)
        chosen |= setting
        made.append(delayed(one, delays // 2, round(lag / own)))
    names = recordings[0].names
    return Decays(tuple(made), names, delays, lag, frequency, step, kept, chosen)


def evenly(samples: Samples, frequency: float, step: float, settings: Preparation) -> Samples:
    """At equal steps, `step` [s] before samples are left out, without gaps."""
    even = equidistant(samples, 1.0 / frequency, settings.longest_gap, step)
    return thinned(even, frequency, settings)


def delays_of(channels: int) -> int:
    """The least odd number that makes five observables of so many channels."""
    return -(-OBSERVABLES // channels) // 2 * 2 + 1 if channels < OBSERVABLES else 1


def thinned(samples: Samples, frequency: float, settings: Preparation) -> Samples:
    """About so many samples a period at most; what they could not show is filtered out before."""
    every = round(1.0 / (frequency * samples.step) / settings.samples)
    if every < 2:
        return samples
    values = decimate(samples.values, every, ftype="fir", axis=0)
    time = samples.time[::every][: len(values)]
    return samples.noted(f"every {every}th sample kept", time=time, values=values)


def at_rest(samples: Samples, frequency: float, rule: str) -> Samples:
    """Displacements from the equilibrium: the mean of whole periods at the end, or the zero."""
    if rule == "zero":
        return samples
    period = 1.0 / (frequency * samples.step)
    count = round(max(1.0, np.floor(TAIL * len(samples.time) / period)) * period)
    mean = samples.values[-count:].mean(axis=0)
    shown = ", ".join(f"{value:.3g}" for value in mean)
    return samples.noted(f"rest at {shown} m", values=samples.values - mean)


def check_decays(samples: Samples) -> None:
    """Raises DataError where a motion is as large at its end as at its beginning."""
    size, tenth = np.linalg.norm(samples.values, axis=1), int(TAIL * len(samples.time))
    first, last = size[:tenth].max(), size[-tenth:].max()
    if abs(last / first - 1.0) < STEADY:
        raise DataError(
            f"{samples.where}: swings as far at its end as at its beginning; give a motion that is "
            "left alone and decays"
        )


def motion_of(
    samples: Samples, frequency: float, settings: Preparation, kept: int
) -> tuple[Prepared, dict[str, float]]:
    """Filtered and differentiated, from where the slow motion begins; and the filter's setting."""
    step = samples.step
    states, lost, found = differentiated(samples.values, step, frequency, settings.filter, kept)
    time = samples.time[lost : lost + len(states[0])]
    slow = begins(states, step, frequency, settings.fast_share)
    begin = slow.begin + time[0] if settings.start is None else settings.start
    later = time >= begin - 1e-9
    if later.sum() < 2 / (frequency * step):
        raise DataError(
            f"{samples.where}: less than two periods after start = {begin:.4g} s; set "
            "preparation.start earlier"
        )
    rule = "by the rule" if settings.start is None else "as set"
    notes = (*samples.notes, f"slow motion from {time[later][0]:.4g} s ({rule})")
    motion = Trajectory(time[later], *(part[later] for part in states))
    return Prepared(samples.where, samples.role, motion, slow, notes), found


def delayed(one: Prepared, pairs: int, lag: int) -> Prepared:
    """All q_k, the delays being `lag` samples apart."""
    motion = one.motion
    parts = [
        means(part, pairs, lag, one.where)
        for part in (motion.displacement, motion.velocity, motion.acceleration)
    ]
    time = motion.time[pairs * lag :][: len(parts[0])]
    return replace(one, motion=Trajectory(time, *parts))


def means(x: np.ndarray, pairs: int, lag: int, where: str) -> np.ndarray:
    """(m - 2 pairs lag, c (pairs + 1)) of x (m, c): q_k of each column, column after column."""
    middle = pairs * lag
    length = len(x) - 2 * middle
    if length < 2:
        raise DataError(f"{where}: too short for its delays; lower preparation.delays")

    def at(shift: int) -> np.ndarray:
        return x[middle + shift * lag :][:length]

    copies = [0.5 * (at(k) + at(-k)) for k in range(pairs + 1)]
    return np.stack(copies, axis=-1).reshape(length, -1)
