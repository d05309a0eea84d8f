"""What each effect of a scene is worth: the answers and the seconds of the scene without it beside
those of the whole scene.
"""

import numpy as np
import pandas as pd
import xarray as xr

from vibrom.report.collection import FULL_ORDER, Collection, probe_name

WHOLE = "nothing"  # the row of the whole scene: nothing is left out
# column -> variable; beside each stands its change against the whole scene in percent
ANSWERS = {
    "omega_1_rad_per_s": "first_frequency",
    "decay_frequency_rad_per_s": "decay_frequency",
    "decay_amplitude_m": "decay_amplitude",
    "forced_amplitude_m": "forced_amplitude",
}
CHANGE = "_change_percent"


def table(collection: Collection) -> pd.DataFrame:
    """One row for each effect of each scene, after one for the whole scene. Amplitudes are those of
    the probe.
    """
    rows = []
    for scene in collection.scenes:
        worth = collection.find(scene, FULL_ORDER, "effects")
        if worth is not None:
            rows += of_scene(scene, worth)
    return pd.DataFrame(rows, columns=columns())


def columns() -> list[str]:
    answers = [column for answer in ANSWERS for column in (answer, f"{answer}{CHANGE}")]
    return [
        "case",
        "left_out",
        *answers[:2],
        "decay_nmte_percent",
        *answers[2:],
        "microseconds_per_step_with",
        "microseconds_per_step_without",
        "seconds_ratio",
        "iterations_per_step",
        "outcome",
        "failed_at_s",
    ]


def of_scene(scene: str, worth: xr.Dataset) -> list[dict]:
    probe, rows = [str(name) for name in worth["probe"].values].index(probe_name(worth)), []
    worth = worth.isel(probe=probe)
    whole = worth.sel(left_out=WHOLE)
    for left_out in worth["left_out"].values:
        less = worth.sel(left_out=left_out)
        row = {
            "case": scene,
            "left_out": str(left_out),
            "decay_nmte_percent": float(less["decay_nmte"]),
        }
        for column, name in ANSWERS.items():
            before, after = float(whole[name]), float(less[name])
            row |= {
                column: after,
                f"{column}{CHANGE}": 100 * (after / before - 1) if before else np.nan,
            }
        seconds, less_seconds = float(whole["seconds_per_step"]), float(less["seconds_per_step"])
        rows.append(
            row
            | {
                "microseconds_per_step_with": 1e6 * seconds,
                "microseconds_per_step_without": 1e6 * less_seconds,
                "seconds_ratio": float(less["seconds_ratio"]),
                "iterations_per_step": float(less["iterations_per_step"]),
                "outcome": str(less["outcome"].item()),
                "failed_at_s": float(less["failed_at"]),
            }
        )
    return rows


def failed(outcome: str) -> bool:
    """Whether the solver gave up; an effect that cannot be left out, or leaves a body that is
    still, is no failure.
    """
    return outcome in ("no_convergence", "no_equilibrium")
