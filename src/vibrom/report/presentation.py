"""Tables for reading: four digits, median and range over seeds in one cell, headers in words; as
HTML and as LaTeX.

The .csv keeps every column at full precision; what is printed here is the same table, folded.
"""

import numpy as np
import pandas as pd
from markupsafe import escape

from vibrom.report import cost, curves, effects
from vibrom.report.collection import FULL_ORDER
from vibrom.thesis import published as thesis

GONE = "–"
WORDS = {
    "case": "Case",
    "method": "Model",
    "outcome": "Outcome",
    "seeds": "Seeds",
    "failed_at_s": "First failure [s]",
    "left_range_at_s": "Left range [s]",
    "quantity": "Quantity",
    "value": "Ours",
    "unit": "Unit",
    "bound": "Bound",
    "met": "Met",
    "source": "Source",
    "nmte_percent": "NMTE [%]",
    "amplitude_error_percent": "Amplitude error [%]",
    "thesis_percent": "Thesis NMTE [%]",
    "real_per_s": "Real part [1/s]",
    "imaginary_rad_per_s": "Imaginary part [rad/s]",
    "thesis_real_per_s": "Thesis real [1/s]",
    "thesis_imaginary_rad_per_s": "Thesis imaginary [rad/s]",
    "generate_training_data_s": "Training data [s]",
    "obtain_mapping_s": "Mapping [s]",
    "obtain_dynamics_s": "Dynamics [s]",
    "decay_s": "Decay [s]",
    "forced_s": "Forced run [s]",
    "frc_s": "Response curve [s]",
    "points": "Points",
    "points_with_value": "With a value",
    "peak_probe_amplitude_m": "Peak of the probe [m]",
    "peak_omega_rad_per_s": "at [rad/s]",
    "median_amplitude_error_percent": "Median amplitude error [%]",
    "study": "Varied",
    "columns": "Columns",
    "rows": "Rows",
    "steps_per_period": "Steps a period",
    "alpha": "Numerical damping [–]",
    "initial_acceleration": "Initial acceleration",
    "residual": "Residual [–]",
    "seed": "Seed",
    "varied": "Varied",
    "set_to": "Set to",
    "target_percent": "Error wanted [%]",
    "error_percent": "Error [%]",
    "setting": "Cheapest setting",
    "question": "Asked for",
    "decay_error_percent": "Decay [%]",
    "forced_error_percent": "Forced run [%]",
    "frc_error_percent": "Response curve [%]",
    "omega_1_error_percent": "ω1 [%]",
    "response_error_percent": "Forced amplitude [%]",
    "assembly_s": "Assembly, modes [s]",
    "response_s": "Forced run [s]",
    "data_s": "Training data [s]",
    "mapping_s": "Mapping [s]",
    "dynamics_s": "Dynamics [s]",
    "offline_s": "Offline [s]",
    "online_s": "Online [s]",
    "decays": "Decays",
    "forced_runs": "Forced runs",
    "sweeps": "Response curves",
    **{
        f"thesis_{name}": f"Thesis: {said}"
        for name, said in (
            ("offline_s", "offline [s]"),
            ("decays", "decays"),
            ("forced_runs", "forced runs"),
            ("sweeps", "response curves"),
        )
    },
    "guard": "Guard",
    "integrator": "Integrator",
    "runs": "Runs",
    "ok": "ok",
    "left_range": "Left range",
    "diverged": "Diverged",
    "step_underflow": "Step underflow",
    "no_convergence": "No convergence",
    "not_asked": "Not asked",
    "held_percent": "Held [%]",
    "held_low_percent": "95 % from",
    "held_high_percent": "to",
    "median_failure_periods": "Median failure [periods]",
    "largest_range_ratio": "Farthest, of the range",
    "peak_error_percent": "Peak error [%]",
    "peak_steps": "Peak off by [frequencies]",
    "decay_nmte_percent": "Decay NMTE [%]",
    "forced_nmte_percent": "Forced NMTE [%]",
    "energy_rises": "Energy rose in",
    "envelope_rises": "Amplitude rose in",
    "gamma": "γ",
    "forcing": "Forcing, of the scene's",
    "seconds": "Wall time [s]",
    "length_m": "Length [m]",
    "height_m": "Height [m]",
    "width_m": "Width [m]",
    "young_modulus_pa": "Young's modulus [Pa]",
    "poisson_ratio": "Poisson's ratio [–]",
    "density_kg_per_m3": "Density [kg/m³]",
    "damping_ratio": "Damping ratio, first mode [–]",
    "element": "Element",
    "cells": "Cells",
    "elements": "Elements",
    "free_dofs": "Free dofs",
    "effects": "Effects",
    "omega_1_quadratic_rad_per_s": "ω1 with quadratic elements [rad/s]",
    "left_out": "Left out",
    "decay_nmte_percent": "Decay NMTE [%]",
    "decay_frequency_rad_per_s": "Decay frequency [rad/s]",
    "decay_amplitude_m": "Decay amplitude [m]",
    "forced_amplitude_m": "Forced amplitude [m]",
    "microseconds_per_step_with": "Step with it [µs]",
    "microseconds_per_step_without": "Step without it [µs]",
    "seconds_ratio": "With / without",
    "iterations_per_step": "Iterations a step",
    **{f"omega_{k}_rad_per_s": f"ω{k} [rad/s]" for k in range(1, 10)},
    **{f"{role}_probe_m": f"{role.capitalize()} release, probe [m]" for role in ("train", "test")},
    **{f"{role}_tip_m": f"{role.capitalize()} release, tip [m]" for role in ("train", "test")},
    **{
        f"thesis_{role}_probe_m": f"{role.capitalize()} release, probe, thesis [m]"
        for role in ("train", "test")
    },
}


def number(value, digits: int = 4) -> str:
    """Four significant digits without exponents where they are not needed."""
    if isinstance(value, str):
        return value
    if value is None or pd.isna(value):
        return GONE
    if isinstance(value, (int, np.integer)):
        return str(value)
    size = abs(value)
    if value == 0:
        return "0"
    if size >= 1e6 or size < 1e-4:
        return f"{value:.{digits - 1}e}"
    return f"{value:.{max(0, digits - 1 - int(np.floor(np.log10(size))))}f}"


def printed(value) -> str:
    """A number as it was given, six digits at most."""
    return (
        value
        if isinstance(value, str)
        else GONE
        if value is None or pd.isna(value)
        else f"{value:.6g}"
    )


def folded(frame: pd.DataFrame, stem: str, digits: int = 4) -> list[str]:
    """`median (min to max)`; the range only where seeds differ."""
    cells = []
    for middle, low, high in zip(frame[stem], frame[f"{stem}_min"], frame[f"{stem}_max"]):
        several = pd.notna(low) and (pd.isna(high) or low != high)
        top = number(high, digits) if pd.notna(high) else "failed"
        median = number(middle, digits)
        cells.append(f"{median} ({number(low, digits)} to {top})" if several else median)
    return cells


def with_change(value: str, change: float) -> str:
    """`0.3563 (+62 %)`; nothing beside a value that stays what it was to half a hundredth of a
    percent.
    """
    if pd.isna(change) or abs(change) < 0.005:
        return value
    return f"{value} ({change:+.0f} %)" if abs(change) >= 10 else f"{value} ({change:+.2g} %)"


def readable(name: str, frame: pd.DataFrame) -> pd.DataFrame:
    """The printed form of a table, all text."""
    if name == "frc":
        frame = curves.summary(frame)
    if name == "beam":
        return on_its_side(frame)
    out: dict[str, list[str]] = {}
    for column in frame.columns:
        stem = column.removesuffix("_min").removesuffix("_max")
        if stem != column and stem in frame.columns or column.endswith("_outcome"):
            continue
        if (
            column.startswith("thesis_")
            and column.removeprefix("thesis_") in thesis.RUN_TIMES
            or column.endswith(effects.CHANGE)
        ):
            continue  # printed in the cell of our own time, or of what changes
        several = f"{column}_min" in frame.columns
        digits = (
            6 if name in ("eigenvalues", "checks") else 4
        )  # they differ from one another in the fourth
        values = (
            folded(frame, column, digits)
            if several
            else [number(value, digits) for value in frame[column]]
        )
        if column + effects.CHANGE in frame.columns:
            values = [
                with_change(value, change)
                for value, change in zip(values, frame[column + effects.CHANGE])
            ]
        if column == "method":
            values = [thesis.label(value) for value in frame[column]]
        if column == "nmte_percent":
            reference = [
                method == FULL_ORDER and value == "0"
                for value, method in zip(values, frame["method"])
            ]
            values = ["reference" if known else value for value, known in zip(values, reference)]
        if column.startswith("thesis_"):
            values = [printed(value) for value in frame[column]]
        if column == "thesis_percent":
            verdicts = frame["thesis_outcome"].fillna("")
            values = [verdict or value for value, verdict in zip(values, verdicts)]
        asked = column.removesuffix("_error_percent")
        if (
            asked != column and f"{asked}_outcome" in frame.columns
        ):  # where there is no value the cell says why
            why = frame[f"{asked}_outcome"].astype(object).fillna(GONE)
            values = [word if value == GONE else value for value, word in zip(values, why)]
        if name == "break_even" and column in cost.QUESTIONS.values():
            values = [printed(value) for value in frame[column]]
        if name == "break_even":
            values = ["never" if value == "inf" else value for value in values]
        if f"thesis_{column}" in frame.columns and column in thesis.RUN_TIMES:
            published = frame[f"thesis_{column}"]
            values = [
                text if pd.isna(old) else f"{text} [{printed(old)}]"
                for text, old in zip(values, published)
            ]
        out[WORDS.get(column, column)] = values
    return pd.DataFrame(out)


def on_its_side(frame: pd.DataFrame) -> pd.DataFrame:
    """Properties down, cases across."""
    kept = [column for column in frame.columns if column not in ("case", "method", "outcome")]
    sides = {
        str(row["case"]): [printed(row[column]).replace("_", " ") for column in kept]
        for _, row in frame.iterrows()
    }
    return pd.DataFrame({"Property": [WORDS.get(column, column) for column in kept], **sides})


def marks(name: str, frame: pd.DataFrame) -> list[str]:
    """One CSS class a printed row: `failed` where a seed has no value or a check is not met,
    `reference` for the full order, or none.
    """
    if name == "beam":
        return [""] * len(on_its_side(frame))
    if name == "checks":
        return ["failed" if met == "no" else "" for met in frame["met"]]
    if name == "effects":
        return [
            "failed"
            if effects.failed(outcome)
            else "reference"
            if left_out == effects.WHOLE
            else ""
            for outcome, left_out in zip(frame["outcome"], frame["left_out"])
        ]
    rows = curves.summary(frame) if name == "frc" else frame
    classes = ["reference" if method == FULL_ORDER else "" for method in rows["method"]]
    return [
        "failed" if failed(str(outcome)) else other
        for outcome, other in zip(rows["outcome"], classes)
    ]


def failed(tally: str) -> bool:
    """Whether `ok 2, diverged 1` names an ending without a value."""
    return any(
        part.rstrip("0123456789 ") not in ("ok", "left_range", "not run", "not reached")
        for part in tally.split(", ")
    )


def to_html(name: str, frame: pd.DataFrame) -> str:
    """A `<table>` and nothing around it."""
    text = readable(name, frame)
    head = "".join(f"<th>{escape(str(column))}</th>" for column in text.columns)
    lines = [
        f'<table class="data" data-name="{escape(name)}">',
        f"<thead><tr>{head}</tr></thead>",
        "<tbody>",
    ]
    for cells, mark in zip(text.itertuples(index=False), marks(name, frame)):
        flag = f' class="{mark}"' if mark else ""
        lines.append(f"<tr{flag}>{''.join(f'<td>{escape(str(cell))}</td>' for cell in cells)}</tr>")
    return "\n".join([*lines, "</tbody>", "</table>"]) + "\n"


def to_tex(name: str, frame: pd.DataFrame) -> str:
    """A booktabs `tabular`."""
    text = readable(name, frame)
    style = (
        text.style.hide(axis="index").format(escape="latex").format_index(escape="latex", axis=1)
    )
    tex = style.to_latex(hrules=True, column_format="l" * len(text.columns))
    for sign, command in {
        "ω": r"$\omega$",
        "γ": r"$\gamma$",
        "³": r"\textsuperscript{3}",
        GONE: "--",
    }.items():
        tex = tex.replace(sign, command)
    return tex
