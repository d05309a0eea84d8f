"""A scene of kind `recorded`: motions that someone measured or simulated elsewhere, as files.

It has no body and no effects. Files say what moved; `preparation` says how states, velocities and
accelerations are made of that.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from msgspec import Meta

from vibrom.config.kinds import Count, Name, NonNegative, Positive, Whole
from vibrom.config.scene import Block

KIND = "recorded"  # the key `kind` of such a scene
# Keys of scenes with a body, which may be laid over all scenes of a run.
OF_BODIES = ("body", "effects", "releases", "record", "time")
# train and test: decays. forced: a motion under a signal that was recorded too, which models
# predict. calibration: another such motion, which tells how strong the load is.
Role = Literal["train", "test", "forced", "calibration"]
UNDER_A_SIGNAL = ("forced", "calibration")
TimeUnit = Literal["s", "ms", "us", "min"]
LengthUnit = Literal["m", "cm", "mm", "um", "in"]
SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0}
METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": 0.0254}


class Recording(Block, frozen=True):
    """One motion in a file: a decay, or one under a signal. Data are named as the file has them: a
    column or variable, `xData{1,2}` an entry of a cell, `a.b` a field.
    """

    file: str  # .csv, .tsv, .txt, .dat, .npy, .npz, .mat or .nc, seen from where the run is started
    role: Role  # what it is used for
    # the instants; none where the first column or the variable `time` or `t` has them
    time: str | None = None
    # the displacements; none: all that the file holds beside the instants
    channels: tuple[str, ...] = ()
    signal: str | None = None  # what drove it, of the roles forced and calibration
    step: Positive | None = None  # in time units, between samples of a file without instants
    begin: float | None = None  # in time units, of the part that is used
    end: float | None = None  # in time units, of the part that is used


class Operators(Block, frozen=True):
    """Matrices of the linear motion of the channels, where they are known: M q'' + C q' + K q."""

    file: str  # .npz, .mat or .nc
    mass: str = "M"  # kg
    stiffness: str = "K"  # N/m
    damping: str | None = None  # kg/s


class Response(Block, frozen=True):
    """A measured response curve: amplitudes under harmonic forcing of one strength."""

    file: str  # .csv, .npz, .mat or .nc
    frequency: str  # its frequencies, in the order in which they were driven
    amplitude: str  # its amplitudes, in the unit of length
    unit: Literal["rad/s", "Hz"] = "rad/s"  # of the frequencies
    channel: Name | None = None  # whose amplitudes; none: the first one's


class Forcing(Block, frozen=True):
    """What drives the body: a known load, or one whose strength a measurement tells."""

    # of each channel, per unit of the signal: N where operators are known, else the acceleration
    # that it gives the channel, m/s2; none: all channels alike, the strength from a recording with
    # the role calibration, or from `response`
    load: tuple[float, ...] | None = None
    response: Response | None = None  # a measured response curve, which models are compared with
    # number of the response's point that tells the strength, as the file counts them from one; 0:
    # that of the largest amplitude
    calibrate: Whole = 0


class Preparation(Block, frozen=True):
    """From samples to states."""

    frequency: Positive | None = None  # Hz, of the slow motion; none: that of the highest line
    rest: Literal["tail", "zero"] = "tail"  # equilibrium: the mean of the last tenth, or the zero
    longest_gap: NonNegative = 0.1  # in periods, that is filled in
    # regularised: least squares with a penalty on differences; savitzky_golay: polynomials that
    # move along; none: only differences
    filter: Literal["regularised", "savitzky_golay", "none"] = "regularised"
    # of the first frequency, that the filter keeps; 0: those that stand out of the noise
    harmonics: Whole = 0
    # s, where the slow motion begins; none: where the rule finds it
    start: NonNegative | None = None
    # of the acceleration's power, that dynamics fitted to what follows do not explain: where the
    # slow motion begins there is no more, or no more than four times the least
    fast_share: Positive = 1e-4
    # instants whose samples make a state, an odd number; none: five observables in all (Takens)
    delays: Count | None = None
    lag: Positive | None = None  # in periods, between them; none: together a quarter of a period
    samples: Count = 200  # of a period, that are kept at most, about


class RecordedScene(Block, frozen=True):
    """One file of config/scenes whose `kind` is `recorded`."""

    kind: Literal["recorded"]
    name: Name  # the file's
    description: str
    recordings: Annotated[tuple[Recording, ...], Meta(min_length=2)]  # for training and for tests
    channels: tuple[Name, ...] = ()  # their names; none: those of the files
    time_unit: TimeUnit = "s"  # of the instants in the files
    length_unit: LengthUnit = "m"  # of the displacements in the files
    operators: Operators | None = None  # of the linear motion
    forcing: Forcing | None = None  # of forced motions
    preparation: Preparation = Preparation()
    experiments: dict[str, dict[str, Any]] = {}  # settings, by experiment


def files_of(scene: dict[str, Any]) -> dict[tuple, str]:
    """Where each file of a scene stands in it, and the file."""
    blocks: dict[tuple, Any] = {
        ("recordings", k): item for k, item in enumerate(scene["recordings"])
    }
    blocks[("operators",)] = scene.get("operators")
    blocks[("forcing", "response")] = (scene.get("forcing") or {}).get("response")
    return {(*path, "file"): block["file"] for path, block in blocks.items() if block}
