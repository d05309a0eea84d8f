"""Backbone of a decay by peak finding and fitting: instantaneous frequency and damping against
amplitude.

Zero crossings by linear interpolation give half periods T/2, so omega = pi / (t_{k+1} - t_k); the
maximum of |x| between two crossings, refined by the parabola through three samples, gives the
amplitude A; damping follows from its slope, zeta = -(d ln A / dt) / omega; all smoothed by a moving
mean of 4. Source: Jin, Chen, Brake, Song, J. Vib. Acoust. 142(5) (2020) 051111.
"""

import numpy as np
import xarray as xr

from vibrom.artefacts.data import outcome_variables, scored, variable
from vibrom.models.rollout import Integrator

needs = ("decay", "test")
full_order = ("test",)
scores = {"frequency_error_percent": "percent"}
MEAN_OF = 4


def peak_finding_and_fitting(
    time: np.ndarray, x: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(amplitude, angular frequency [rad/s], damping ratio), one entry a half period; empty where
    there are too few.
    """
    finite = np.isfinite(x)
    time, x = time[finite], x[finite]
    (before,) = np.nonzero(np.signbit(x[:-1]) != np.signbit(x[1:]))
    crossing = time[before] - x[before] * (time[before + 1] - time[before]) / (
        x[before + 1] - x[before]
    )
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


def predict(artefacts: dict, integrator: Integrator) -> xr.Dataset:
    truth = artefacts["test"]
    source = artefacts.get("decay", truth)
    curves = [
        peak_finding_and_fitting(source["time"].values, x)
        for x in source["probe_displacement"].values
    ]
    longest = max(len(curve[0]) for curve in curves)
    padded = np.full((3, len(curves), longest), np.nan)
    for index, curve in enumerate(curves):
        padded[:, index, : len(curve[0])] = curve
    dims = ("probe", "peak")
    dataset = xr.Dataset(
        {
            "amplitude": variable(dims, padded[0], "m", "amplitude of each half period"),
            "angular_frequency": variable(
                dims, padded[1], "rad s-1", "instantaneous angular frequency"
            ),
            "damping_ratio": variable(dims, padded[2], "1", "instantaneous damping ratio"),
            **outcome_variables(str(source["outcome"].item()), float(source["failed_at"])),
        },
        coords={"probe": source["probe"].variable},
    )
    if source is truth:
        return scored(dataset, {}, {})
    true = peak_finding_and_fitting(truth["time"].values, truth["probe_displacement"].values[0])
    return scored(dataset, {"frequency_error_percent": frequency_error(curves[0], true)}, scores)


def frequency_error(curve: tuple[np.ndarray, ...], true: tuple[np.ndarray, ...]) -> float:
    """Mean of |omega - omega_true| / omega_true in percent over the amplitudes that both curves
    reach; NaN without a common one.
    """
    if not (len(curve[0]) and len(true[0])):
        return float("nan")
    order, order_true = np.argsort(curve[0]), np.argsort(true[0])
    common = true[0][order_true]
    common = common[(common >= curve[0].min()) & (common <= curve[0].max())]
    if len(common) == 0:
        return float("nan")
    model = np.interp(common, curve[0][order], curve[1][order])
    reference = np.interp(common, true[0][order_true], true[1][order_true])
    return float(100 * np.mean(np.abs(model / reference - 1)))
