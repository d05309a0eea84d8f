"""The full order at coarse steps, by several schemes

The full-order response curve at some of its frequencies with few steps a period, by Newmark's
method, the generalised-alpha method and the energy-momentum method, with gamma = 1/2 + alpha.
Errors are against the scene's own curve, at the scene's own forcing. Where a run has
no value Newton's iteration did not converge.
"""

import numpy as np

from vibrom.artefacts.outcome import Tally
from vibrom.models.measures import curve_error
from vibrom.report.collection import FULL_ORDER
from vibrom.report.columns import CASE, METHOD, OUTCOME, Column

FAMILY = "robustness"
PLACE = 330
VARIED = ("steps_per_period", "scheme", "forcing")
COLUMNS = (
    CASE,
    METHOD,
    Column("steps_per_period", "Steps a period", whole=True),
    Column("scheme", "Scheme"),
    Column("gamma", "γ [–]"),
    Column("forcing", "Forcing [of the scene's]"),
    Column("points", "Points", whole=True),
    Column("points_with_value", "With a value", whole=True),
    Column("median_amplitude_error_percent", "Median amplitude error [%]"),
    Column("peak_error_percent", "Peak error [%]"),
    Column("median_failure_periods", "Median failure [periods]"),
    Column("seconds", "Wall time [s]"),
    OUTCOME,
)


def build(collection, scores):
    """One row a case, number of steps, scheme and forcing."""
    rows = []
    for scene in collection.scenes:
        answer = collection.find(scene, FULL_ORDER, "robustness")
        if answer is not None:
            for index in np.ndindex(*(answer.sizes[name] for name in VARIED)):
                part = answer.isel(dict(zip(VARIED, index)))
                rows.append({"case": scene, "method": FULL_ORDER} | of_setting(part))
    return rows


def of_setting(part) -> dict:
    """One response curve; at another forcing than the scene's there is nothing to compare with."""
    error = curve_error(part["amplitude"].values, part["reference"].values)
    own = float(part["forcing"]) == 1.0
    failed_at = part["failed_at"].values
    failed_at = failed_at[np.isfinite(failed_at)]
    return {
        "steps_per_period": int(part["steps_per_period"]),
        "scheme": str(part["time_scheme"].values),
        "gamma": 0.5 + float(part["alpha"]),
        "forcing": float(part["forcing"]),
        "points": part.sizes["angular_frequency"],
        "points_with_value": error.completed,
        "median_amplitude_error_percent": finite(error.median_percent) if own else np.nan,
        "peak_error_percent": error.peak_percent if own else np.nan,
        "median_failure_periods": float(np.median(failed_at)) if failed_at.size else np.nan,
        "seconds": float(part["seconds"]),
        "outcome": Tally(part["outcome"].values.ravel()),
    }


def finite(value: float) -> float:
    """NaN for an infinite error: the median point failed."""
    return value if np.isfinite(value) else np.nan
