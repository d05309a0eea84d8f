"""Numbers that compare motions, each defined once: errors of trajectories and of response curves,
amplitude and phase of a periodic response, zero crossings; backbones.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from vibrom.artefacts.data import variable
from vibrom.models.samples import rows


def nmte_percent(truth: Any, model: Any) -> float:
    """Normalised mean-trajectory error:  NMTE = 100 mean_t |y - y_model| / max_t |y|  in percent.

    y and y_model (m, n), |.| the Euclidean norm over the n free displacements; NaN where the model
    failed before the end. Either may be a variable of a file, and is read a block at a time.
    Source: thesis, section 3.2.3.
    """
    largest = max(np.linalg.norm(part, axis=-1).max() for (part,) in rows(truth))
    return float(100.0 * distance(truth, model).mean() / largest)


def distance(truth: Any, model: Any) -> np.ndarray:
    """|y - y_model| (m,) of each row, of the same arrays."""
    return np.concatenate(
        [np.linalg.norm(one - other, axis=-1) for one, other in rows(truth, model)]
    )


def distance_variable(truth: Any, model: Any) -> dict[str, xr.Variable]:
    """The same as answers keep it, instead of all displacements."""
    words = "norm of the displacement error"
    return {"error": variable("time", distance(truth, model), "m", words)}


@dataclass(frozen=True)
class Periodic:
    """What whole periods of a response show, one entry for each leading index of the samples."""

    maximum: np.ndarray  # the largest value, with its sign
    minimum: np.ndarray  # the smallest value, with its sign
    phase: np.ndarray  # rad in (-2 pi, 0], of the first harmonic:  y ~ A sin(Omega t + phase)

    @property
    def half_range(self) -> np.ndarray:
        """Half the distance from the minimum to the maximum: the amplitude of a symmetric swing."""
        return 0.5 * (self.maximum - self.minimum)


def periodic(samples: np.ndarray) -> Periodic:
    """Of `samples` (..., m) of whole periods that start with a period of the forcing sin(Omega t).

    The thesis's amplitude is the maximum of y, not of |y|.
    """
    m = samples.shape[-1]
    harmonic = samples @ np.exp(-2j * np.pi * np.arange(m) / m)
    phase = np.angle(1j * harmonic)  # sin(x) = Im e^ix: its own harmonic is -i m / 2
    phase = np.where(phase > 0.0, phase - 2 * np.pi, phase)
    return Periodic(samples.max(axis=-1), samples.min(axis=-1), phase)


def range_variable(
    dims: tuple[str, ...] | str, ratio: np.ndarray | float
) -> dict[str, xr.Variable]:
    """How far a motion of a reduced model went, as answers keep it."""
    words = "largest reduced coordinate over the largest in the training data"
    return {"range_ratio": variable(dims, ratio, "1", words)}


def response_variables(
    dims: tuple[str, ...], shown: Periodic, largest: str = "amplitude"
) -> dict[str, xr.Variable]:
    """What a period of a response shows, as an artefact keeps it: the largest value, under the name
    `largest`, `minimum` and `half_range` [m], and the `phase` [rad] of the first harmonic relative
    to the forcing.
    """
    return {
        largest: variable(dims, shown.maximum, "m", "largest value of the period"),
        "minimum": variable(dims, shown.minimum, "m", "smallest value of the period"),
        "half_range": variable(
            dims, shown.half_range, "m", "half the range of the period, peak to peak"
        ),
        "phase": variable(
            dims, shown.phase, "rad", "phase of the first harmonic relative to the forcing"
        ),
    }


@dataclass(frozen=True)
class CurveError:
    """A response curve against the true one, point by point at the same frequencies."""

    median_percent: float  # median of |A/A_true - 1|; infinite where more than half have no value
    largest_percent: float  # of the same; infinite where a point has no value
    peak_percent: float  # A_max/A_true,max - 1, with its sign; NaN for a curve with gaps
    peak_steps: float  # frequencies between the two peaks; NaN for a curve with gaps
    completed: int  # points with a value


def curve_error(amplitude: np.ndarray, truth: np.ndarray) -> CurveError:
    """Of amplitudes (k,) [m] against `truth` (k,) [m].

    A point of the model that failed (NaN) counts as infinitely wrong; where the truth failed there
    is nothing to compare with. Models fail at the peak first, so that a curve with gaps has no
    peak.
    """
    known, nan = np.isfinite(truth), float("nan")
    completed = int(np.isfinite(amplitude).sum())
    if not known.any():
        return CurveError(nan, nan, nan, nan, completed)
    error = 100.0 * np.abs(amplitude[known] / truth[known] - 1.0)
    error = np.where(np.isfinite(error), error, np.inf)
    median, largest = float(np.median(error)), float(error.max())
    if not (np.isfinite(amplitude).all() and known.all()):
        return CurveError(median, largest, nan, nan, completed)
    peak = float(100.0 * (amplitude.max() / truth.max() - 1.0))
    steps = float(abs(int(amplitude.argmax()) - int(truth.argmax())))
    return CurveError(median, largest, peak, steps, completed)


def crossings(time: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Instants (k,) at which x (m,) changes sign, by linear interpolation between the samples at
    `time` (m,), and the sample (k,) before each. None where x is not finite throughout.
    """
    if not np.isfinite(x).all():
        return np.zeros(0), np.zeros(0, np.int64)
    (before,) = np.nonzero(np.signbit(x[:-1]) != np.signbit(x[1:]))
    rise = x[before + 1] - x[before]
    return time[before] - x[before] * (time[before + 1] - time[before]) / rise, before


def backbone_error(curve: tuple[np.ndarray, ...], true: tuple[np.ndarray, ...]) -> float:
    """Mean of |y/y_true - 1| in percent along the amplitudes a that both curves reach,

        1/(a_2 - a_1) int |y/y_true - 1| da,

    of curves (amplitude, y), where y is a frequency or a damping ratio, linear between points: how
    many points there are, and where the last ones fall, makes no difference. NaN without a common
    amplitude.
    """
    if not (len(curve[0]) and len(true[0])):
        return float("nan")
    order, order_true = (np.argsort(one[0], kind="stable") for one in (curve, true))
    amplitudes = curve[0], true[0]
    first, last = max(a.min() for a in amplitudes), min(a.max() for a in amplitudes)
    if first > last:
        return float("nan")
    at = np.unique(np.clip(np.concatenate(amplitudes), first, last))
    model = np.interp(at, curve[0][order], curve[1][order])
    reference = np.interp(at, true[0][order_true], true[1][order_true])
    error = 100.0 * np.abs(model / reference - 1.0)
    return float(np.trapezoid(error, at) / (last - first) if first < last else error[0])
