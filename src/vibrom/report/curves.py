"""Forced response curves as a table with one row a frequency, model and seed, and their summary by
case and model.
"""

import numpy as np
import pandas as pd

from vibrom.report.collection import FULL_ORDER, UNSEEDED, Collection, answered, at_probe
from vibrom.report.scores import spread, tally

COLUMNS = (
    "case",
    "method",
    "seed",
    "omega_rad_per_s",
    "probe_amplitude_m",
    "tip_amplitude_m",
    "phase_rad",
    "outcome",
    "failed_at_s",
)


def table(collection: Collection) -> pd.DataFrame:
    """Every point of every curve; amplitudes are empty where the run failed, and `outcome` says
    how.
    """
    pieces = []
    for scene in collection.scenes:
        for model in [FULL_ORDER, *collection.methods]:
            for seed in [UNSEEDED] if model == FULL_ORDER else collection.seeds(scene, model):
                curve = collection.find(scene, model, "frc", seed)
                if curve is not None:
                    pieces.append(
                        points(curve, scene, model, seed, collection.find(scene, FULL_ORDER, "frc"))
                    )
    frame = (
        pd.concat(pieces, ignore_index=True)
        if pieces
        else pd.DataFrame({name: [] for name in COLUMNS})
    )
    return frame.astype({"seed": "Int64"})[list(COLUMNS)]


def points(curve, scene: str, model: str, seed: str, truth) -> pd.DataFrame:
    """One row a frequency; a model that could not be fitted has the frequencies of the full order,
    and its outcome.
    """
    frequency = (curve if answered(curve) else truth)["angular_frequency"].values
    amplitude, tip, phase = (
        at_probe(curve, *what) for what in (("amplitude",), ("amplitude", "tip"), ("phase",))
    )
    gone = np.full(len(frequency), np.nan)
    number = pd.NA if seed == UNSEEDED else int(seed.removeprefix("seed_"))
    return pd.DataFrame(
        {
            "case": scene,
            "method": model,
            "seed": pd.array([number] * len(frequency), dtype="Int64"),
            "omega_rad_per_s": frequency,
            "probe_amplitude_m": gone if amplitude is None else amplitude,
            "tip_amplitude_m": gone if tip is None else tip,
            "phase_rad": gone if phase is None else phase,
            "outcome": np.broadcast_to(curve["outcome"].values.astype(str), frequency.shape),
            "failed_at_s": np.broadcast_to(curve["failed_at"].values, frequency.shape),
        }
    )


def summary(points: pd.DataFrame) -> pd.DataFrame:
    """Points with a value, peak of the probe (median over seeds) and median amplitude error against
    the full order, for each case and model; a failed point counts as infinitely wrong, and one
    where the full order failed not at all.
    """
    rows = []
    for (case, method), chosen in points.groupby(["case", "method"], sort=False):
        truth = amplitudes(points[(points["case"] == case) & (points["method"] == FULL_ORDER)])
        peaks, places, errors = [], [], []
        for _, curve in chosen.groupby("seed", dropna=False, sort=False):
            amplitude = amplitudes(curve)
            whole = (
                amplitude.notna().all()
            )  # models fail at the peak first: a curve with gaps has none to tell
            peaks.append(amplitude.max() if whole else np.nan)
            places.append(amplitude.idxmax() if whole else np.nan)
            known = truth.dropna()  # where the full order failed there is nothing to compare with
            error = 100 * (amplitude.reindex(known.index) - known).abs() / known.abs()
            errors.append(error.fillna(np.inf).median())
        error = spread(np.array(errors), worst=True).median
        rows.append(
            {
                "case": case,
                "method": method,
                "points": len(chosen),
                "points_with_value": int(chosen["probe_amplitude_m"].notna().sum()),
                "peak_probe_amplitude_m": spread(np.array(peaks), worst=False).median,
                "peak_omega_rad_per_s": spread(np.array(places), worst=False).median,
                "median_amplitude_error_percent": np.nan if method == FULL_ORDER else error,
                "outcome": tally(chosen["outcome"]),
            }
        )
    return pd.DataFrame(rows)


def amplitudes(points: pd.DataFrame) -> pd.Series:
    """Amplitude of the probe [m] by frequency."""
    return points.set_index("omega_rad_per_s")["probe_amplitude_m"]


def finished(curve) -> str:
    """`33 of 33 points` and how the others ended, for a legend."""
    amplitude = at_probe(curve, "amplitude")
    outcomes = np.broadcast_to(curve["outcome"].values.astype(str), amplitude.shape)
    lost = ~np.isfinite(amplitude)
    words = f"{int((~lost).sum())} of {len(amplitude)}"
    return words if not lost.any() else f"{words}; {tally(outcomes[lost])}"
