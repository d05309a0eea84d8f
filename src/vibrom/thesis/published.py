"""The published numbers, to be printed beside ours.

A. Schouten, Leveraging Autoencoders To Enhance Model Order Reduction for Non-linear Mechanical
Dynamical Systems, MSc thesis, Delft University of Technology, October 2024: Tables 3.2 to 3.6, the
eigenvalues of the full-order model in section 3.2.2 and the initial displacements in section 3.1.1.
Its "tip" is the y displacement of the node at x = 0.525 m on the bottom edge, which is called probe
here.
"""

from functools import cache
from importlib.resources import files

import numpy as np
import pandas as pd

SOURCE = (
    "A. Schouten, Leveraging Autoencoders To Enhance Model Order Reduction for Non-linear Mechanical Dynamical "
    "Systems, MSc thesis, Delft University of Technology, October 2024"
)
LABELS = {
    "full_order": "Full order",
    "modal_projection": "Modal projection",
    "decoupled_autoencoder": "Decoupled AE",
    "sindy_autoencoder": "SINDy AE",
    "ssmlearn": "SSMLearn",
    "split": "SPLIT",
    "split_plus": "SPLIT+",
}
STATES = {
    ("small", "test"): 1,
    ("small", "train"): 2,
    ("large", "test"): 2,
    ("large", "train"): 3,
    ("folding", "test"): 4,
    ("folding", "train"): 5,
}
RUN_TIMES = (
    "generate_training_data_s",
    "obtain_mapping_s",
    "obtain_dynamics_s",
    "decay_s",
    "forced_s",
    "frc_s",
)


def label(method: str) -> str:
    """The thesis's name of a method, a variant's with what its own name adds (`SSMLearn 11`); a
    method that it does not know keeps its own.
    """
    known = max(
        (name for name in LABELS if f"{method}_".startswith(f"{name}_")), key=len, default=""
    )
    return LABELS.get(known, "") + method.removeprefix(known).replace("_", " ")


@cache
def table(name: str) -> pd.DataFrame:
    """One published table as it was typed."""
    with (files("vibrom.thesis") / "tables" / f"{name}.csv").open(encoding="utf-8") as file:
        return pd.read_csv(file)


def percent(name: str, case: str, method: str) -> tuple[float, str]:
    """NMTE [%] in table `reconstruction`, `decay` or `forced`, and `fails` where the thesis prints
    that instead.
    """
    frame = table(name)
    cells = frame.loc[frame["method"] == method, case] if case in frame.columns else []
    if len(cells) == 0:
        return np.nan, ""
    text = str(cells.iloc[0])
    return (np.nan, "fails") if text == "fails" else (float(text), "")


def eigenvalue(case: str, method: str) -> tuple[float, float]:
    """Real part [1/s] and imaginary part [rad/s]."""
    frame = table("eigenvalues")
    row = frame[(frame["method"] == method) & (frame["case"] == case)]
    if not len(row):
        return np.nan, np.nan
    return float(row["real_per_s"].iloc[0]), float(row["imaginary_rad_per_s"].iloc[0])


def run_time(quantity: str, case: str, method: str) -> float:
    """Seconds; the thesis prints one number for its three cases."""
    frame = table("run_times")
    row = frame[frame["method"] == method]
    known = case in set(table("eigenvalues")["case"])
    return float(row[quantity].iloc[0]) if len(row) and known else np.nan


def release(case: str, role: str) -> float:
    """Initial displacement of the probe [m], role `train` or `test`."""
    frame = table("releases")
    row = frame[(frame["case"] == case) & (frame["role"] == role)]
    return float(row["probe_m"].iloc[0]) if len(row) else np.nan


def state(case: str, role: str) -> pd.Series:
    """The release state of a case in a reference reproduction: probe, tip, tip_x [m], and the
    forced run behind it.
    """
    return table("states").set_index("state").loc[STATES[case, role]]
