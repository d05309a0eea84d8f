"""Backbone of a decay by peak finding and fitting: instantaneous frequency and damping against
amplitude.

Zero crossings by linear interpolation give half periods T/2, so omega = pi / (t_{k+1} - t_k); the
maximum of |x| between two crossings, refined by the parabola through three samples, gives the
amplitude A; damping follows from its slope, zeta = -(d ln A / dt) / omega; all smoothed by a moving
mean of n = 4 half periods. Their scatter s tells how sure a mean is: with a confidence of 95 % it
is within t s / sqrt(n), t the quantile of Student's distribution, if half periods err
independently.
Source: Jin, Chen, Brake, Song, J. Vib. Acoust. 142(5) (2020) 051111.
"""

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.lib.stride_tricks import sliding_window_view
from scipy.special import stdtrit

from vibrom.artefacts.data import outcome_variables, variable
from vibrom.config.kinds import Count
from vibrom.experiments import Experiment, Given
from vibrom.models.measures import backbone_error, crossings
from vibrom.models.model import Model

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Backbone(Experiment):
    """Of the recorded decay, and of each model's."""

    half_periods: Count = 4  # in a mean; noise asks for more, a fast change of frequency for fewer

    scores = {"frequency_error_percent": "percent"}
    reads = ("decay",)
    truth = "backbone"
    of_model = False
    job = "answers"

    def ask(self, model: Model | None, given: Given) -> xr.Dataset:
        """The backbone at every probe of the model's own decay."""
        decay = given.answers["decay"]
        curves = [self._curve(decay, x) for x in decay["probe_displacement"].values]
        padded = np.full((5, len(curves), max(len(curve[0]) for curve in curves)), np.nan)
        for index, curve in enumerate(curves):
            padded[:, index, : len(curve[0])] = curve
        about = {
            "amplitude": ("m", "amplitude of each half period"),
            "angular_frequency": ("rad s-1", "instantaneous angular frequency"),
            "damping_ratio": ("1", "instantaneous damping ratio"),
            "angular_frequency_uncertainty": ("rad s-1", "half the 95 % interval of the frequency"),
            "damping_ratio_uncertainty": ("1", "half the 95 % interval of the damping ratio"),
        }
        found = {
            name: variable(("probe", "peak"), values, *words)
            for (name, words), values in zip(about.items(), padded)
        }
        found |= outcome_variables(str(decay["outcome"].item()), float(decay["failed_at"]))
        return xr.Dataset(found, coords={"probe": given.probe})

    def _curve(self, decay: xr.Dataset, x: np.ndarray) -> np.ndarray:
        """(5, k) at one probe; several decays that follow one another are looked at one by one."""
        time = decay["time"].values
        part = decay["part"].values if "part" in decay else np.zeros(len(time))
        each = [
            peak_finding_and_fitting(time[part == k], x[part == k], self.half_periods)
            for k in np.unique(part)
        ]
        return np.concatenate([np.stack(curve) for curve in each], axis=1)

    def score(self, answer: xr.Dataset, truth: xr.Dataset) -> dict[str, float]:
        """Error of the frequency at the first probe over the amplitudes that both reach."""
        return {"frequency_error_percent": backbone_error(*map(first_probe, (answer, truth)))}


def first_probe(backbone: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """(amplitude [m], angular frequency [rad/s]) at the first probe."""
    curve = [backbone[name].values[0] for name in ("amplitude", "angular_frequency")]
    finite = np.isfinite(curve[0])
    return curve[0][finite], curve[1][finite]


def peak_finding_and_fitting(
    time: np.ndarray, x: np.ndarray, mean_of: int = 4
) -> tuple[np.ndarray, ...]:
    """(amplitude, angular frequency [rad/s], damping ratio, uncertainties of the last two), one
    entry a half period; empty where there are too few.
    """
    finite = np.isfinite(x)
    time, x = time[finite], x[finite]
    crossing, before = crossings(time, x)
    count = len(crossing) - 1
    if count < mean_of + 2:
        return tuple(np.zeros((5, 0)))
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
    window = np.ones(mean_of) / mean_of
    sure = [half_interval(values, mean_of) for values in (frequency, slope)]
    amplitude, frequency, slope = (
        np.convolve(values, window, mode="valid") for values in (amplitude, frequency, slope)
    )
    return amplitude, frequency, -slope / frequency, sure[0], sure[1] / frequency


def half_interval(values: np.ndarray, mean_of: int) -> np.ndarray:
    """Half the interval of each moving mean, with a confidence of 95 %; NaN of one value."""
    if mean_of == 1:
        return np.full(len(values), np.nan)
    scatter = sliding_window_view(values, mean_of).std(axis=1, ddof=1)
    quantile = stdtrit(mean_of - 1, 0.5 + 0.5 * CONFIDENCE)  # of Student's t
    return quantile * scatter / np.sqrt(mean_of)
