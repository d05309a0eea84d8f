"""Recorded channels at equal steps of time.

Instants that are nearly equidistant are taken as such; others, and samples that are missing, are
filled in by the spline of degree five through the samples that are there. What a gap hides is not
made up: one that is longer than a small part of a period is refused.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.signal import periodogram

from vibrom.artefacts.files import DataError
from vibrom.config.recorded import METRES, SECONDS, RecordedScene, Recording
from vibrom.recordings import files

TIMES = ("time", "t", "Time", "T")
JITTER = 1e-2  # of a step: instants that are written with few digits
LEAST = 8  # samples of a period
SHORTEST = 10  # periods
APART = 2.0  # ratio of first frequencies of recordings of one body, at most


@dataclass(frozen=True)
class Samples:
    """One recorded motion."""

    where: str  # file and role, for messages
    role: str
    time: np.ndarray  # (m,) s; instants of the recording, ascending
    # (m, c) m, NaN where a sample is missing; last, the signal in its own unit where there is one
    values: np.ndarray
    names: tuple[str, ...]  # of the channels
    notes: tuple[str, ...] = ()  # what was done to it

    @property
    def step(self) -> float:
        """Between samples [s]."""
        return float(np.median(np.diff(self.time)))

    def noted(
        self, note: str, time: np.ndarray | None = None, values: np.ndarray | None = None
    ) -> Samples:
        """The same with other instants or values, and why."""
        return replace(
            self,
            time=self.time if time is None else time,
            values=self.values if values is None else values,
            notes=(*self.notes, note),
        )


def load(scene: RecordedScene) -> list[Samples]:
    """All recordings of a scene in SI units, with the channels' names of the scene."""
    found = [loaded(item, scene) for item in scene.recordings]
    first = found[0]
    for other in found[1:]:
        if len(other.names) != len(first.names):
            raise DataError(
                f"{other.where}: {len(other.names)} channels, but {first.where} has "
                f"{len(first.names)}; name the same `channels` for both"
            )
    if len(set(first.names)) == len(first.names):
        found = [reordered(item, first.names) for item in found]
    names = scene.channels or first.names
    if len(names) != len(first.names):
        raise DataError(
            f"channels names {len(names)}, but {first.where} has {len(first.names)}; name each "
            "channel once"
        )
    return [replace(item, names=tuple(names)) for item in found]


def reordered(samples: Samples, names: tuple[str, ...]) -> Samples:
    """With its channels in the order of these names, if it has all of them."""
    if samples.names == names or set(samples.names) != set(names):
        return samples
    order = [samples.names.index(name) for name in names]
    order += range(len(names), samples.values.shape[1])
    made = samples.noted("channels in the order of the first recording")
    return replace(made, names=names, values=samples.values[:, order])


def loaded(item: Recording, scene: RecordedScene) -> Samples:
    """One recording, sorted and cut, with gaps as they are."""
    where = f"{item.file} ({item.role})"
    arrays = files.read(item.file)
    for name in (item.time, *item.channels, item.signal):
        if name is not None:
            files.array(item.file, name)
    if len(arrays) == 1 and not item.channels and item.time is None and item.signal is None:
        arrays = split(next(iter(arrays.values())), item.step is not None)
    time_name = item.time or next((name for name in TIMES if name in arrays), None)
    if time_name is None and item.step is None and len(arrays) > 1:
        time_name = next(iter(arrays))
    time = None if time_name is None else np.ravel(arrays[time_name])
    chosen = item.channels or [name for name in arrays if name not in (time_name, item.signal)]
    parts, names = [], []
    for name in chosen:
        block = oriented(arrays[name], None if time is None else len(time), where, name)
        parts.append(block)
        several = block.shape[1] > 1
        names += [f"{name}_{k + 1}" if several else name for k in range(block.shape[1])]
    if not parts:
        raise DataError(f"{where}: no channel beside the instants; name `channels`")
    if len({len(part) for part in parts}) > 1:
        lengths = ", ".join(f"{name} {len(part)}" for name, part in zip(chosen, parts))
        raise DataError(f"{where}: channels of different lengths ({lengths}); name those to use")
    values = np.hstack(parts) * METRES[scene.length_unit]
    if item.signal is not None:
        values = np.column_stack([values, signal_of(arrays[item.signal], len(values), where)])
    values[np.isinf(values)] = np.nan
    if time is None:
        if item.step is None:
            raise DataError(
                f"{where}: no instants; name `time`, or give the `step` between samples"
            )
        time = item.step * np.arange(len(values))
    samples = Samples(where, item.role, time, values, tuple(clean(name) for name in names))
    return in_order(part_of(samples, item), SECONDS[scene.time_unit])


def signal_of(values: np.ndarray, length: int, where: str) -> np.ndarray:
    """(m,) in its own unit."""
    if values.size != length:
        raise DataError(f"{where}: {values.size} samples of the signal, but {length} of the motion")
    return values.ravel()


def split(array: np.ndarray, has_step: bool) -> dict[str, np.ndarray]:
    """One array: its first column, or row, is the time where it only rises."""
    block = np.atleast_2d(array)
    block = block if block.shape[0] >= block.shape[1] else block.T
    rises = block.shape[1] > 1 and bool((np.diff(block[:, 0]) > 0).all())
    if rises and not has_step:
        return {"time": block[:, 0], "channel": block[:, 1:]}
    return {"channel": block}


def oriented(values: np.ndarray, length: int | None, where: str, name: str) -> np.ndarray:
    """(m, c) with time along the first axis: the one that is as long as the instants, or longer."""
    values = np.squeeze(values)
    if values.ndim == 0 or values.ndim > 2:
        raise DataError(f"{where}: {name} has {values.ndim} axes; give one or two")
    block = values[:, None] if values.ndim == 1 else values
    if length is None:
        return block if block.shape[0] >= block.shape[1] else block.T
    if block.shape[0] == length:
        return block
    if block.shape[1] == length:
        return block.T
    shape = " x ".join(map(str, values.shape))
    raise DataError(f"{where}: {name} is {shape}, but there are {length} instants; correct one")


def clean(name: str) -> str:
    """A channel's name as names of probes are, without a unit in brackets."""
    name = re.sub(r"\s*[\[(][^\[(]*[\])]\s*$", "", name)
    kept = "".join(letter if letter.isalnum() else "_" for letter in name).strip("_")
    return kept[:60] or "channel"


def part_of(samples: Samples, item: Recording) -> Samples:
    """From `begin` to `end`, in the unit of the file, and what has no instant."""
    begin, end = (
        default if value is None else value
        for value, default in ((item.begin, -np.inf), (item.end, np.inf))
    )
    kept = ~((samples.time < begin) | (samples.time > end))  # without an instant: see `in_order`
    if not kept.any():
        span = f"{np.nanmin(samples.time):g} to {np.nanmax(samples.time):g}"
        raise DataError(f"{samples.where}: nothing between begin and end; its time is {span}")
    return replace(samples, time=samples.time[kept], values=samples.values[kept])


def in_order(samples: Samples, unit: float) -> Samples:
    """Ascending instants in s, each once."""
    known = np.isfinite(samples.time)
    time, values = samples.time[known] * unit, samples.values[known]
    if len(time) < 2:
        raise DataError(f"{samples.where}: {len(time)} samples with an instant; give a longer one")
    made = replace(samples, time=time, values=values)
    if not known.all():
        made = made.noted(f"{np.sum(~known)} samples without an instant left out")
    if (np.diff(time) > 0).all():
        return made
    time, first = np.unique(time, return_index=True)
    words = "instants put in order" if len(time) == len(values) else "repeated instants left out"
    if len(time) < 0.9 * len(values):
        raise DataError(
            f"{samples.where}: {len(values) - len(time)} of {len(values)} instants are repeated; "
            "name the right `time`, or give one motion a recording"
        )
    return made.noted(words, time=time, values=values[first])


def equidistant(samples: Samples, period: float, longest_gap: float, wanted: float) -> Samples:
    """At equal steps, those `wanted` [s] where its own differ, without missing samples. Raises
    DataError for too long a gap [periods], too few samples of a period and too few periods.
    """
    own, span = samples.step, samples.time[-1] - samples.time[0]
    step = own if abs(own / wanted - 1.0) * span < JITTER * own else wanted
    where, missing = samples.where, int(np.isnan(samples.values).any(axis=1).sum())
    if period < LEAST * step:
        raise DataError(
            f"{where}: {period / step:.1f} samples of a period; record at least {LEAST}, or "
            "correct preparation.frequency"
        )
    if span < SHORTEST * period:
        raise DataError(
            f"{where}: {span / period:.1f} periods of {period:.3g} s; record at least {SHORTEST}, "
            "or correct time_unit"
        )
    columns = samples.values.T
    for column in columns:
        there = samples.time[np.isfinite(column)]
        gaps = np.diff(np.concatenate([samples.time[:1], there, samples.time[-1:]]))
        longest = float(gaps.max(initial=0.0))
        if longest > max(longest_gap * period, 1.5 * step):
            at = np.concatenate([samples.time[:1], there])[int(gaps.argmax())]
            raise DataError(
                f"{where}: no sample for {longest:.3g} s after {at:.4g} s, more than longest_gap = "
                f"{longest_gap:g} periods; use the part before or after it (begin, end)"
            )
    even = samples.time[0] + step * np.arange(round(span / step) + 1)
    off = len(even) != len(samples.time) or np.abs(even - samples.time).max() > JITTER * step
    if not missing and not off:
        return replace(samples, time=even)
    even = even[even <= samples.time[-1]]
    filled = [
        make_interp_spline(samples.time[known], column[known], k=5)(even)
        for column, known in zip(columns, np.isfinite(columns))
    ]
    words = [f"{missing} missing samples filled in"] if missing else []
    words += [f"resampled at {step:.4g} s"] if off else []
    return samples.noted(", ".join(words), time=even, values=np.stack(filled, axis=1))


def first_frequency(samples: Samples) -> float:
    """The highest line [Hz] of the power of all channels."""
    even = np.arange(samples.time[0], samples.time[-1], samples.step)
    columns = [
        np.interp(even, samples.time[known], column[known])
        for column, known in zip(samples.values.T, np.isfinite(samples.values.T))
        if known.any()
    ]
    if not columns:
        raise DataError(f"{samples.where}: no channel holds a number; name `channels`")
    frequency, power = periodogram(
        np.stack(columns), 1.0 / samples.step, window="hann", detrend="linear"
    )
    total = power.sum(axis=0)
    if len(total) < 4 or not total[2:].any():
        raise DataError(f"{samples.where}: does not move; give a recording of a decay")
    top = 2 + int(total[2:].argmax())  # below are drift and what the window spreads of it
    around = slice(top - 1, top + 2)  # the centre of a line that lies between two frequencies
    return float((frequency[around] * total[around]).sum() / total[around].sum())


def common_frequency(recordings: list[Samples], given: float | None) -> float:
    """The first frequency [Hz] of a body: given, or the middle one of its recordings. DataError
    where one of them is far from it.
    """
    found = np.array([first_frequency(item) for item in recordings])
    order = found.argsort()
    usual = int(order[len(order) // 2])
    middle = float(found[usual]) if given is None else given
    off = np.maximum(found / middle, middle / found)
    if given is None and off.max() > APART:
        far = int(off.argmax())
        raise DataError(
            f"{recordings[far].where}: its first frequency is {found[far]:.4g} Hz, that of "
            f"{recordings[usual].where} {middle:.4g} Hz; correct time_unit, or the time of one file"
        )
    return middle
