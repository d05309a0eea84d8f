"""Response curves with all their branches, as tables and figures take them."""

import numpy as np
import xarray as xr

from vibrom.models.curves import Curve
from vibrom.report.collection import FULL_ORDER, Collection, answered, at_probe


def curve(dataset: xr.Dataset | None) -> Curve | None:
    """The periodic motions of an answer, at the probe; None where there is no motion."""
    if dataset is None or not answered(dataset):
        return None
    amplitude = at_probe(dataset, "maximum")
    if amplitude is None or not np.isfinite(amplitude).any():
        return None
    branch, frequency, stable, kind = (
        dataset[name].values for name in ("branch", "angular_frequency", "stable", "kind")
    )
    return Curve(branch, frequency, amplitude, stable.astype(bool), kind.astype(str))


def scenes(collection: Collection, name: str = "branches") -> list[str]:
    """Those whose full order was evaluated."""
    return [
        scene for scene in collection.scenes if collection.find(scene, FULL_ORDER, name) is not None
    ]
