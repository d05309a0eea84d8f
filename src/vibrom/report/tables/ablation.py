"""Ablation: the effect of removing each term

Each effect of a scene is left out in turn, and the full-order model is evaluated again; in
parentheses stands the change. First frequency: undamped, about the rest state. Decay: a few
periods from the test release, released from the same place in space; the NMTE is that of the
motion without the effect against the motion with it, the frequency is the mean from the first to
the last passage through rest, the amplitude the largest in the last period. Forced: largest
displacement of the probe in the last of a number of periods from rest, at the forcing and the
damped first frequency of the whole scene; that is not yet the steady state. Time steps are those
of the whole scene.

Seconds a step are medians over many short decays in alternating order, loading and compilation
excluded: of the whole scene, without the effect, and the median of their ratios in each round;
the ratio of an effect that plays no part in a decay, such as a load, shows the scatter of these
measurements. Where the motion itself changes, so does the number of Newton iterations; without
state-dependent forces a step is one solve with a factor that is made once.

An effect that others need cannot be left out alone (needed; the table names them). Without a load
there is no forced response (unforced). Without mass on every displacement there is nothing to
integrate, and the forced amplitude is the static one (static). A body that loses its stiffness
has no_modes, one that collapses under its dead load no_equilibrium.
"""

from functools import partial

import numpy as np
import xarray as xr

from vibrom.artefacts.outcome import Outcome, Tally
from vibrom.report.collection import FULL_ORDER, probe_name, scalar
from vibrom.report.columns import CASE, OUTCOME, Column, Row, hidden, number, with_change
from vibrom.report.table import FAILED, REFERENCE, failed, printed

FAMILY = "ablation"
PLACE = 210
WHOLE = "nothing"  # the row of the whole scene: nothing is left out
# column: variable; beside each stands its change against the whole scene in percent
ANSWERS = {
    "omega_1_rad_per_s": "first_frequency",
    "decay_frequency_rad_per_s": "decay_frequency",
    "decay_amplitude_m": "decay_amplitude",
    "forced_amplitude_m": "forced_amplitude",
}


def changed(name: str, heading: str) -> tuple[Column, ...]:
    """A value, and its change."""

    def text(row: Row) -> str:
        return with_change(number(row[name]), row[f"{name}_change_percent"])

    return Column(name, heading, text=text), *hidden(f"{name}_change_percent")


COLUMNS = (
    CASE,
    Column("left_out", "Left out"),
    *changed("omega_1_rad_per_s", "ω1 [rad/s]"),
    Column("decay_nmte_percent", "Decay NMTE [%]"),
    *changed("decay_frequency_rad_per_s", "Decay frequency [rad/s]"),
    *changed("decay_amplitude_m", "Decay amplitude [m]"),
    *changed("forced_amplitude_m", "Forced amplitude [m]"),
    Column("microseconds_per_step_with", "Step with it [µs]"),
    Column("microseconds_per_step_without", "Step without it [µs]"),
    Column("seconds_ratio", "With / without [–]"),
    Column("iterations_per_step", "Iterations a step [–]"),
    OUTCOME,
    Column("needed_by", "Needed by"),
    Column("failed_at_s", "First failure [s]"),
)


def mark(row: Row) -> str:
    """The whole scene is the reference; an effect that cannot be left out is no failure."""
    if failed(Tally([row["outcome"]])):
        return FAILED
    return REFERENCE if row["left_out"] == WHOLE else ""


shown = partial(printed, marked=mark)


def build(collection, scores):
    """One row for each effect of each scene, after one for the whole scene. Amplitudes are those of
    the probe.
    """
    rows = []
    for scene in collection.scenes:
        study = collection.find(scene, FULL_ORDER, "ablation")
        if study is not None:
            study = study.sel(probe=probe_name(study))
            whole = study.sel(left_out=WHOLE)
            for left_out in study["left_out"].values:
                rows.append({"case": scene} | compared(whole, study.sel(left_out=left_out)))
    return rows


def compared(whole: xr.Dataset, less: xr.Dataset) -> dict:
    """The scene without one effect beside the whole scene."""
    row: dict = {
        "left_out": str(less["left_out"].item()),
        "decay_nmte_percent": float(less["decay_nmte"]),
        "microseconds_per_step_with": 1e6 * float(whole["seconds_per_step"]),
        "microseconds_per_step_without": 1e6 * float(less["seconds_per_step"]),
        "seconds_ratio": float(less["seconds_ratio"]),
        "iterations_per_step": float(less["iterations_per_step"]),
        "outcome": Outcome(str(less["outcome"].item())),
        "needed_by": str(scalar(less, "needed_by", "")),
        "failed_at_s": float(less["failed_at"]),
    }
    for column, name in ANSWERS.items():
        before, after = float(whole[name]), float(less[name])
        change = 100 * (after / before - 1) if before else np.nan
        row |= {column: after, f"{column}_change_percent": change}
    return row
