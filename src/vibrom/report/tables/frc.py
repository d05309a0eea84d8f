"""Forced response curves in numbers

How many points of each curve have a value, the peak of the probe and where it lies (medians over
the seeds whose curve is whole), and the amplitude error against the full order, median and
largest over frequencies and then median over seeds; a failed point counts as infinitely wrong, and
a point at which the full order itself failed is left out. An amplitude is the largest value of y,
with its sign, in the last period. The thesis takes the same.

The .csv of this table has every point: amplitude of probe and tip, phase, outcome, time of
failure, and, where the artefact has it, half the distance from the smallest to the largest value
of the probe (``probe_half_range_m``), which is the amplitude of a motion that is not about y = 0.
Points that are ``not_steady`` count with their value; it still changed by more than the scene's
tolerance (``experiments.frc.steady``) in the last quarter of the run, and the .csv says by how much
of the amplitude (``change``).
"""

import numpy as np
import xarray as xr

from vibrom.artefacts.outcome import Tally
from vibrom.report import curves
from vibrom.report.collection import FULL_ORDER, answered, at_probe
from vibrom.report.columns import CASE, METHOD, OUTCOME, Column, hidden
from vibrom.report.scores import spread
from vibrom.report.table import Printed, printed

FAMILY = "models"
PLACE = 70
ASKED = "frc"  # where that is asked only
COLUMNS = (
    CASE,
    METHOD,
    Column("seed", whole=True),
    *hidden("omega_rad_per_s", "probe_amplitude_m", "tip_amplitude_m", "phase_rad"),
    OUTCOME,
    *hidden("failed_at_s"),
    Column("probe_half_range_m", optional=True),
    Column("change", optional=True),
)
SUMMARY = (
    CASE,
    METHOD,
    Column("points", "Points", whole=True),
    Column("points_with_value", "With a value", whole=True),
    Column("peak_probe_amplitude_m", "Peak of the probe [m]"),
    Column("peak_omega_rad_per_s", "at [rad/s]"),
    Column("median_amplitude_error_percent", "Median amplitude error [%]"),
    Column("largest_amplitude_error_percent", "Largest [%]"),
    OUTCOME,
)


def build(collection, scores):
    """One row a frequency, model and seed; amplitudes are missing where the run failed."""
    rows = []
    for scene, model in collection.models:
        truth = collection.find(scene, FULL_ORDER, "frc")
        for seed in collection.seeds(scene, model):
            curve = collection.find(scene, model, "frc", seed)
            if curve is not None:
                rows += points({"case": scene, "method": model, "seed": seed}, curve, truth)
    return rows


def points(whose: dict, curve: xr.Dataset, truth: xr.Dataset | None) -> list[dict]:
    """One row a frequency; a model that could not be fitted has the frequencies of the full order,
    and its outcome.
    """
    frequency = curves.frequencies(curve, truth)
    values = {
        "probe_amplitude_m": at_probe(curve, "amplitude"),
        "probe_half_range_m": at_probe(curve, "half_range"),
        "tip_amplitude_m": at_probe(curve, "amplitude", "tip"),
        "phase_rad": at_probe(curve, "phase"),
        "failed_at_s": curve["failed_at"].values,
        "change": curve["change"].values if "change" in curve else None,
    }
    if not answered(curve):
        values |= dict.fromkeys(values, np.nan) | {"failed_at_s": curve["failed_at"].values}
    columns = {
        name: np.broadcast_to(np.nan if value is None else value, frequency.shape)
        for name, value in values.items()
    }
    return [
        {
            **whose,
            "omega_rad_per_s": float(frequency[at]),
            **{name: float(column[at]) for name, column in columns.items()},
            "outcome": ended,
        }
        for at, ended in enumerate(curves.outcomes(curve, len(frequency)))
    ]


def shown(rows, columns) -> Printed:
    """One row a case and model: points with a value, peak, and error against the full order."""
    models = dict.fromkeys((row["case"], row["method"]) for row in rows)
    return printed([summary(rows, *model) for model in models], SUMMARY)


def summary(rows, case: str, method: str) -> dict:
    """Medians over the seeds of one model."""
    chosen = [row for row in rows if (row["case"], row["method"]) == (case, method)]
    truth = by_seed([row for row in rows if (row["case"], row["method"]) == (case, FULL_ORDER)])
    curves_of, heights, places = by_seed(chosen), [], []
    for omega, amplitude in curves_of:
        # Models fail at the peak first: a curve with gaps has none.
        whole = bool(np.isfinite(amplitude).all())
        heights.append(amplitude.max() if whole else np.nan)
        places.append(omega[amplitude.argmax()] if whole else np.nan)
    errors = curves.amplitude_errors(
        (amplitude for _, amplitude in curves_of), truth[0][1] if truth else None
    )
    return {
        "case": case,
        "method": method,
        "points": len(chosen),
        "points_with_value": int(sum(np.isfinite(row["probe_amplitude_m"]) for row in chosen)),
        "peak_probe_amplitude_m": spread(heights, worst=False).median,
        "peak_omega_rad_per_s": spread(places, worst=False).median,
        **{
            f"{which}_amplitude_error_percent": np.nan if method == FULL_ORDER else error.median
            for which, error in zip(("median", "largest"), errors)
        },
        "outcome": Tally(row["outcome"] for row in chosen),
    }


def by_seed(rows) -> list[tuple[np.ndarray, np.ndarray]]:
    """Frequencies [rad/s] and amplitudes of the probe [m] of each seed's curve."""
    seeds = dict.fromkeys(row["seed"] for row in rows)
    columns = ("omega_rad_per_s", "probe_amplitude_m")
    return [
        tuple(np.array([row[name] for row in rows if row["seed"] == seed]) for name in columns)
        for seed in seeds
    ]
