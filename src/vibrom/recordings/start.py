"""The file of a scene for recordings that nobody has described yet: `vibrom record FILE ...`.

What is in the files is found by their names and shapes; what cannot be found is a comment to be
read. The last recording is for tests, or the one before it where the last swings farthest: models
predict what lies within what they have learnt from. A single recording is cut in the middle.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
from msgspec.structs import replace

from vibrom.artefacts.files import DataError, write
from vibrom.config.recorded import (
    METRES,
    SECONDS,
    UNDER_A_SIGNAL,
    RecordedScene,
    Recording,
)
from vibrom.recordings import files, samples

TIMES = ("time", "t", "zeit", "seconds", "sec")  # names of instants, without their unit
PAIR = re.compile(r"(.+)\{(\d+),1\}")  # x{1,1} instants, x{1,2} channels, x{2,1} instants, ...
UNIT = re.compile(r"[\[(/]\s*(\w+)\s*[\])]?\s*$")  # time [ms], x (mm), x / mm
FORCED = "measured_forcing: {}"
TEXT = """\
# Written by `vibrom record`; see docs/walks/measurement.md for what each key does.
kind: recorded
description: {description}

# In which unit the files have their instants ({times}) and displacements ({lengths}).
time_unit: {time_unit}
length_unit: {length_unit}

# What is learnt from (train) and what predictions are compared with (test). `begin` and `end`, in
# the unit of the file, use a part of a recording. A motion under a `signal` that was recorded too
# is predicted (forced), or tells how strong the load is (calibration).
recordings:
{recordings}

# From samples to states. Every entry has a rule; the lines in comments are what may be set.
preparation:
  filter: regularised     # savitzky_golay, or none
  # start: 0.5            # s, where the slow motion begins; see the figure slow_motion
  # harmonics: 3          # of the first frequency, that the filter keeps
  # delays: 5             # instants whose samples make a state
  # frequency: 10.0       # Hz, of the slow motion, where another line is higher

# What drives the body, where that is known: `load`, one entry a channel. Where only a response was
# measured, one of its points tells how strong the load is, unless a recording does.
# forcing:
#   response: {{file: sweep.csv, frequency: omega, amplitude: amplitude, unit: rad/s}}

experiments:
  backbone: {{half_periods: 8}}   # in a mean of frequency and damping
  {forced:29} # with a recording under a signal
  # measured_response: {{}}       # with a response
"""


def written(
    paths: list[Path],
    out: Path,
    step: float | None = None,
    forced: tuple[Path, ...] = (),
    signal: str | None = None,
) -> str:
    """Writes the scene's file and says in a few lines what was found; `step`, in the unit of time,
    is that between samples of files without instants. Files of `forced` hold motions under the
    signal of this name. Raises DataError where the files cannot be used, or the scene is there
    already.
    """
    if out.exists():
        raise DataError(f"{out}: is there already; choose another name or remove it")
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_.-]*\.yaml", out.name):
        raise DataError(f"{out}: the name of a scene has letters, digits, '_', '-' and '.yaml'")
    found = [entry for path in paths for entry in recordings_in(path, step)]
    if bool(forced) != bool(signal):
        raise DataError("give --forced FILE and --signal NAME together, the column that drove it")
    time_unit, length_unit = units(paths)
    scene = described(found, time_unit, length_unit)
    under = [under_signal(entry, signal) for path in forced for entry in recordings_in(path, step)]
    scene = replace(scene, recordings=(*scene.recordings, *under))
    loaded = samples.load(scene)
    alone = [item for item in loaded if item.role not in UNDER_A_SIGNAL]
    frequency = samples.common_frequency(alone, None)
    write(out, text(scene, paths))
    lines = [
        f"{out}: a scene of {len(loaded)} recordings, first frequency {frequency:.4g} Hz",
        *(
            f"  {item.where}: {counted(len(item.names), 'channel')}, {len(item.time)} samples, "
            f"{(item.time[-1] - item.time[0]) * frequency:.0f} periods of "
            f"{1.0 / (item.step * frequency):.0f} samples"
            for item in loaded
        ),
        f"Run it: snakemake --cores 2 --config 'scenes=[{out.stem}]'",
    ]
    return "\n".join(lines)


def counted(number: int, what: str) -> str:
    """1 channel, 2 channels."""
    return f"{number} {what}{'s' if number != 1 else ''}"


def recordings_in(path: Path, step: float | None = None) -> list[Recording]:
    """Those of one file, all for training."""
    if step is not None and not 0.0 < step < np.inf:
        raise DataError(f"step = {step:g}: give the time between samples, more than zero")
    arrays = files.read(path)
    pairs = [
        (name, f"{match[1]}{{{match[2]},2}}")
        for name in arrays
        if (match := PAIR.fullmatch(name)) and f"{match[1]}{{{match[2]},2}}" in arrays
    ]
    if pairs:
        return [
            Recording(file=str(path), role="train", time=time, channels=(channels,))
            for time, channels in pairs
        ]
    if len(arrays) == 1:
        return [Recording(file=str(path), role="train", step=step)]
    longest = max(max(values.shape, default=1) for values in arrays.values())
    time = None if step else time_in(path, arrays)
    length = arrays[time].size if time else longest
    channels = [
        name
        for name, values in arrays.items()
        if name != time and length in values.shape and not rises(values)
    ]
    return [Recording(file=str(path), role="train", time=time, channels=tuple(channels), step=step)]


def under_signal(entry: Recording, signal: str | None) -> Recording:
    """The same as a motion under a signal."""
    channels = tuple(name for name in entry.channels if name != signal)
    return replace(entry, role="forced", channels=channels, signal=signal)


def time_in(path: Path, arrays: files.Arrays) -> str:
    """The name of the instants: one that says so, else the first array that rises."""
    rising = [name for name, values in arrays.items() if rises(values)]
    named = [name for name in rising if samples.clean(name).lower() in TIMES]
    if not rising:
        known = ", ".join(arrays)
        raise DataError(
            f"{path}: no instants among {known}; give the time between samples as step (--step)"
        )
    return (named or rising)[0]


def rises(values: np.ndarray) -> bool:
    """Could these be instants, or a counter?"""
    rising = np.diff(values[np.isfinite(values)])
    return values.size in values.shape and len(rising) > 1 and bool((rising > 0).all())


def units(paths: list[Path]) -> tuple[str, str]:
    """Of time and length, as the names in the files say; s and m where they do not."""
    said = [word for path in paths for word in (*files.read(path), *files.units(path))]
    found = [match[1] for word in said if (match := UNIT.search(word))]
    time = next((word for word in found if word in SECONDS), "s")
    return time, next((word for word in found if word in METRES), "m")


def described(found: list[Recording], time_unit: str, length_unit: str) -> RecordedScene:
    """The scene of these recordings, with roles."""
    plain = [item.to_builtins() for item in found]
    for place, item in enumerate(plain):
        if item in plain[:place]:
            raise DataError(f"{item['file']}: is given twice; a test needs a motion of its own")
    if len(plain) == 1:
        # Read in seconds whatever the unit is: `begin` and `end` are in the file's.
        one = samples.loaded(found[0], scene_of(plain * 2, "s", length_unit))
        middle = float(one.time[len(one.time) // 2])
        plain = [plain[0] | {"end": middle}, plain[0] | {"begin": middle}]
    swings = [
        np.nanmax(np.nanmax(item.values, axis=0) - np.nanmin(item.values, axis=0))
        for item in samples.load(scene_of(plain, "s", length_unit))
    ]
    plain[-1 if np.argmax(swings) < len(swings) - 1 else -2]["role"] = "test"
    return scene_of(plain, time_unit, length_unit)


def scene_of(recordings: list[dict], time_unit: str, length_unit: str) -> RecordedScene:
    """With defaults for all else."""
    given = {"kind": "recorded", "name": "new", "description": "", "recordings": recordings}
    return RecordedScene.from_builtins(given | {"time_unit": time_unit, "length_unit": length_unit})


def text(scene: RecordedScene, paths: list[Path]) -> str:
    """The file, with comments."""
    rows = []
    for item in scene.recordings:
        entry = {
            key: value for key, value in item.to_builtins().items() if value not in ((), [], None)
        }
        pairs = ", ".join(f"{key}: {json.dumps(value)}" for key, value in entry.items())
        rows.append(f"  - {{{pairs}}}")
    names = ", ".join(path.name for path in paths)
    return TEXT.format(
        description=json.dumps(f"recorded motion of {names}"),
        times=", ".join(SECONDS),
        lengths=", ".join(METRES),
        time_unit=scene.time_unit,
        length_unit=scene.length_unit,
        recordings="\n".join(rows),
        forced=("" if any(item.signal for item in scene.recordings) else "# ") + FORCED,
    )
