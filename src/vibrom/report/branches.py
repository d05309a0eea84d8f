"""Response curves with all their branches, as tables and figures take them."""

import numpy as np
import xarray as xr

from vibrom.models.curves import Curve, curve_of
from vibrom.models.recorded import damped_frequency
from vibrom.report.collection import FULL_ORDER, Collection, answered, at_probe

ERRORS = {  # headings of the scores that all curves with branches have
    "bistable_width_error_percent": "Bistable width [%]",
    "stable_amplitude_error_percent": "Stable parts [%]",
    "unstable_amplitude_error_percent": "Unstable parts [%]",
    "wrong_stable_motions": "Wrong number of stable motions [–]",
}


def curve(dataset: xr.Dataset | None) -> Curve | None:
    """The periodic motions of an answer, at the probe; None where there is no motion."""
    if dataset is None or not answered(dataset):
        return None
    amplitude = at_probe(dataset, "maximum")
    if amplitude is None or not np.isfinite(amplitude).any():
        return None
    return curve_of(dataset, amplitude)


def scenes(collection: Collection, name: str = "branches") -> list[str]:
    """Those whose full order was evaluated."""
    return [
        scene for scene in collection.scenes if collection.find(scene, FULL_ORDER, name) is not None
    ]


def landmark(collection: Collection, scene: str, name: str) -> float | None:
    """A number of the full order's curve, frequencies in terms of the damped first one; None where
    the scene takes no part, NaN where the curve has no such thing.
    """
    dataset = collection.find(scene, FULL_ORDER, "branches")
    if dataset is None:
        return None
    found = curve(dataset)
    if found is None:
        return np.nan
    scale = damped_frequency(collection.find(scene, FULL_ORDER, "structure"))
    folds = [*np.sort(found.parameter[found.folds])[::-1], np.nan, np.nan]
    numbers = {
        "main folds": len(found.folds),
        "upper fold": folds[0] / scale,
        "lower fold": folds[1] / scale,
        "peak": found.amplitude.max(),
        "peak frequency": found.parameter[found.peak] / scale,
        "stable peak": found.amplitude[found.stable].max(initial=0.0),
        "motions": len(found.parameter),
    }
    return float(numbers[name])
