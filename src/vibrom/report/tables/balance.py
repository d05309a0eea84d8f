"""The work balance of every run

What the energy of the body changes by, less the work of the load, plus what damping takes, relative
to all energy that was there or went through: zero for the equations of motion. The full order's
runs break it by their numerical damping and the errors of their steps. The motions of the models
are inserted into the body's own energy: a model whose shapes are off a little may be off far in
energy, as a body is much stiffer along its length than across it. Largest value over the points of
a curve; over seeds the median, smallest and largest. Runs beyond the tolerance (``balance`` of the
scene's ``record`` and experiments, ``studies.trust.tolerance``) are ``unbalanced``; no value: the
run did not last, or a force has no potential.
"""

import numpy as np
import xarray as xr

from vibrom.artefacts.outcome import Outcome, Tally
from vibrom.report.collection import FULL_ORDER, by_method
from vibrom.report.columns import CASE, METHOD, OUTCOME, SEEDS, Column
from vibrom.report.scores import spread

FAMILY = "models"
PLACE = 95
ALSO = ["trust"]  # of the models
RUNS = ("train", "test", "forced", "frc")
COLUMNS = (
    CASE,
    METHOD,
    Column("run", "Run"),
    Column("balance_percent", "Work balance [%]", spread=True),
    SEEDS,
    OUTCOME,
)


def build(collection, scores):
    """One row a case, model and run."""
    rows = []
    for scene in collection.scenes:
        for run in RUNS:
            kept = collection.find(scene, FULL_ORDER, run)
            if kept is not None and "balance" in kept:
                value = largest(kept["balance"].values)
                words = np.ravel(kept["outcome"].values).tolist()
                rows.append(row(scene, FULL_ORDER, run, [value], words))
        study = collection.find(scene, FULL_ORDER, "trust")
        if study is not None and "decay_balance" in study:
            rows += of_models(scene, study)
    return rows


def of_models(scene: str, study: xr.Dataset) -> list[dict]:
    """The decay and the forced run of each method."""
    rows = []
    for method, chosen in by_method(study):
        for run in ("decay", "forced"):
            values, fits = chosen[f"{run}_balance"].values, chosen["outcome"].values
            broken = values > study.attrs["tolerance"]
            words = np.where(broken, Outcome.UNBALANCED, fits).tolist()
            rows.append(row(scene, method, run, values, words))
    return rows


def row(scene: str, method: str, run: str, values, outcomes: list[str]) -> dict:
    """`values` are fractions, one a seed."""
    columns = spread(100.0 * np.asarray(values), worst=True).columns("balance_percent")
    about = {"case": scene, "method": method, "run": run, "seeds": len(values)}
    return about | columns | {"outcome": Tally(outcomes)}


def largest(values: np.ndarray) -> float:
    """NaN where there is none."""
    return float(np.fmax.reduce(np.ravel(values), initial=np.nan))
