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
    "A. Schouten, Leveraging Autoencoders To Enhance Model Order Reduction for Non-linear "
    "Mechanical Dynamical Systems, MSc thesis, Delft University of Technology, October 2024"
)
STATES = {
    ("small", "test"): 1,
    ("small", "train"): 2,
    ("large", "test"): 2,
    ("large", "train"): 3,
    ("folding", "test"): 4,
    ("folding", "train"): 5,
}


@cache
def table(name: str) -> pd.DataFrame:
    """One published table as it was typed; an empty cell is a number that is not printed."""
    with (files("vibrom.thesis") / "tables" / f"{name}.csv").open(encoding="utf-8") as file:
        return pd.read_csv(file, keep_default_na=False, na_values=[""])


def _number(name: str, column: str, **where: str) -> float:
    """The cell of a table in the row where these columns have these values; NaN where it has no
    such row.
    """
    frame = table(name)
    for key, value in where.items():
        frame = frame[frame[key] == value]
    return float(frame[column].iloc[0]) if len(frame) else np.nan


def percent(name: str, case: str, method: str) -> tuple[float, str]:
    """NMTE [%] in table `reconstruction`, `decay` or `forced`, and `fails` where the thesis prints
    that instead.
    """
    frame = table(name).set_index("method")
    if case not in frame.columns or method not in frame.index:
        return np.nan, ""
    cell = frame.loc[method, case]
    return (np.nan, "fails") if cell == "fails" else (float(cell), "")


def eigenvalue(case: str, method: str) -> tuple[float, float]:
    """Real part [1/s] and imaginary part [rad/s]."""
    return (
        _number("eigenvalues", "real_per_s", case=case, method=method),
        _number("eigenvalues", "imaginary_rad_per_s", case=case, method=method),
    )


def run_time(quantity: str, case: str, method: str) -> float:
    """Seconds; the thesis prints one number for its three cases."""
    known = case in set(table("eigenvalues")["case"])
    return _number("run_times", quantity, method=method) if known else np.nan


def release(case: str, role: str) -> float:
    """Initial displacement of the probe [m], role `train` or `test`."""
    return _number("releases", "probe_m", case=case, role=role)


def state(case: str, role: str) -> pd.Series:
    """The release state of a case in a reference reproduction: probe, tip, tip_x [m], and the
    forced run behind it.
    """
    return table("states").set_index("state").loc[STATES[case, role]]
