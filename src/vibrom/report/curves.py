"""Forced response curves: how each point ended, and the amplitude errors of a model's curves."""

from collections.abc import Iterable

import numpy as np
import xarray as xr

from vibrom.artefacts.outcome import Outcome, Tally
from vibrom.models.measures import curve_error
from vibrom.report.collection import FULL_ORDER, Collection, answered, at_probe
from vibrom.report.scores import NO_SPREAD, Spread, spread


def frequencies(curve: xr.Dataset, truth: xr.Dataset | None) -> np.ndarray:
    """Of the forcing (k,) [rad/s]; a model that could not be fitted has those of the full order."""
    whole = next((item for item in (curve, truth) if answered(item)), None)
    return np.zeros(0) if whole is None else whole["angular_frequency"].values


def outcomes(curve: xr.Dataset, points: int) -> list[Outcome]:
    """Of each point; a model that could not be fitted has one for all."""
    words = np.broadcast_to(curve["outcome"].values.astype(str), (points,))
    return [Outcome(word) for word in words]


def amplitude_errors(
    amplitudes: Iterable[np.ndarray], truth: np.ndarray | None
) -> tuple[Spread, Spread]:
    """Median and largest over the frequencies of each seed's curve (k,) against the full order's
    [%].
    """
    if truth is None:
        return NO_SPREAD, NO_SPREAD
    errors = [curve_error(seed, truth) for seed in amplitudes]
    return (
        spread((error.median_percent for error in errors), worst=True),
        spread((error.largest_percent for error in errors), worst=True),
    )


def error_of(collection: Collection, scene: str, method: str) -> Spread:
    """The median of a model of the run."""
    truth = collection.find(scene, FULL_ORDER, "frc")
    curves = [curve for curve in collection.every(scene, method, "frc") if curve is not None]
    if not answered(truth) or not curves:
        return NO_SPREAD
    known = at_probe(truth, "amplitude")
    lost = np.full(known.shape, np.nan)
    amplitudes = (at_probe(curve, "amplitude") if answered(curve) else lost for curve in curves)
    return amplitude_errors(amplitudes, known)[0]


def finished(curve: xr.Dataset) -> str:
    """`30 of 33; diverged` for a legend: points with a value, and how the others ended."""
    amplitude = at_probe(curve, "amplitude")
    lost = ~np.isfinite(amplitude)
    words = f"{int((~lost).sum())} of {len(amplitude)}"
    ended = np.array(outcomes(curve, len(amplitude)))[lost]
    return f"{words}; {Tally(ended)}" if lost.any() else words
