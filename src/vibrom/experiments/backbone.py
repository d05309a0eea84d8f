"""Backbone of a decay by peak finding and fitting: instantaneous frequency and damping against
amplitude.

Zero crossings by linear interpolation give half periods T/2, so omega = pi / (t_{k+1} - t_k); the
maximum of |x| between two crossings, refined by the parabola through three samples, gives the
amplitude A; damping follows from its slope, zeta = -(d ln A / dt) / omega; all smoothed by a moving
mean of 4. Source: Jin, Chen, Brake, Song, J. Vib. Acoust. 142(5) (2020) 051111.
"""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from vibrom.artefacts.data import outcome_variables, variable
from vibrom.experiments import Experiment, Given
from vibrom.models.measures import backbone_error, crossings
from vibrom.models.model import Model

MEAN_OF = 4


@dataclass(frozen=True)
class Backbone(Experiment):
    """Has no settings."""

    scores = {"frequency_error_percent": "percent"}
    reads = ("decay",)
    truth = "backbone"
    of_model = False
    job = "answers"

    def ask(self, model: Model | None, given: Given) -> xr.Dataset:
        """The backbone at every probe of the model's own decay."""
        decay = given.answers["decay"]
        curves = [
            peak_finding_and_fitting(decay["time"].values, x)
            for x in decay["probe_displacement"].values
        ]
        padded = np.full((3, len(curves), max(len(curve[0]) for curve in curves)), np.nan)
        for index, curve in enumerate(curves):
            padded[:, index, : len(curve[0])] = curve
        dims = ("probe", "peak")
        return xr.Dataset(
            {
                "amplitude": variable(dims, padded[0], "m", "amplitude of each half period"),
                "angular_frequency": variable(
                    dims, padded[1], "rad s-1", "instantaneous angular frequency"
                ),
                "damping_ratio": variable(dims, padded[2], "1", "instantaneous damping ratio"),
                **outcome_variables(str(decay["outcome"].item()), float(decay["failed_at"])),
            },
            coords={"probe": given.probe},
        )

    def score(self, answer: xr.Dataset, truth: xr.Dataset) -> dict[str, float]:
        """Error of the frequency at the first probe over the amplitudes that both reach."""
        return {"frequency_error_percent": backbone_error(*map(first_probe, (answer, truth)))}


def first_probe(backbone: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """(amplitude [m], angular frequency [rad/s]) at the first probe."""
    curve = [backbone[name].values[0] for name in ("amplitude", "angular_frequency")]
    finite = np.isfinite(curve[0])
    return curve[0][finite], curve[1][finite]


def peak_finding_and_fitting(
    time: np.ndarray, x: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(amplitude, angular frequency [rad/s], damping ratio), one entry a half period; empty where
    there are too few.
    """
    finite = np.isfinite(x)
    time, x = time[finite], x[finite]
    crossing, before = crossings(time, x)
    count = len(crossing) - 1
    if count < MEAN_OF + 2:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    amplitude, instant = np.empty(count), np.empty(count)
    for k in range(count):
        inside = slice(before[k] + 1, before[k + 1] + 1)
        top = before[k] + 1 + int(np.abs(x[inside]).argmax())
        left, middle, right = np.abs(x[[top - 1, top, min(top + 1, len(x) - 1)]])
        bend = left - 2 * middle + right
        shift = 0.5 * (left - right) / bend if bend < 0 else 0.0
        amplitude[k] = middle - 0.25 * (left - right) * shift
        instant[k] = time[top] + shift * (time[1] - time[0])
    frequency = np.pi / np.diff(crossing)
    slope = np.gradient(np.log(amplitude), instant)
    window = np.ones(MEAN_OF) / MEAN_OF
    amplitude, frequency, slope = (
        np.convolve(values, window, mode="valid") for values in (amplitude, frequency, slope)
    )
    return amplitude, frequency, -slope / frequency
