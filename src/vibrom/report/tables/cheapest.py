"""The cheapest setting for an error

For each model and question the setting that has the wanted error for the least seconds: of one
run of the full order, the estimated error of the reference added to its own; of a method those of
training data, training and one answer. Models as configured count with the median over seeds, a
failed seed as infinitely wrong.
"""

import numpy as np
import xarray as xr

from vibrom.artefacts.outcome import Outcome
from vibrom.report import cost
from vibrom.report.collection import FULL_ORDER
from vibrom.report.columns import CASE, METHOD, OUTCOME, Column
from vibrom.report.table import REFERENCE, printed
from vibrom.studies.parts.work_precision import cheapest

FAMILY = "cost"
PLACE = 130
TARGETS, FULL_ORDER_TARGETS = (10.0, 5.0, 1.0), (1.0, 0.1, 0.01)  # %
COLUMNS = (
    CASE,
    METHOD,
    Column("question", "Evaluated"),
    Column("target_percent", "Error wanted [%]"),
    Column("error_percent", "Error [%]"),
    Column("offline_s", "Offline [s]"),
    Column("online_s", "Online [s]"),
    Column("setting", "Cheapest setting"),
    OUTCOME,
)


def shown(rows, columns):
    """An error that no setting has is no failure."""
    return printed(rows, columns, lambda row: REFERENCE if row["method"] == FULL_ORDER else "")


def build(collection, scores):
    """One row a case, model, question and error."""
    rows = []
    for scene, dataset in cost.studied(collection, "cost_full_order").items():
        for question in dataset["question"].values:
            rows += of_full_order(scene, dataset, str(question))
    found = cost.pooled(collection)
    for scene in dict.fromkeys(one.scene for one in found):
        mine = [one for one in found if one.scene == scene]
        for method, group in cost.of_methods(mine).items():
            for question in cost.EXPERIMENTS:
                rows += of_method(scene, method, group, question)
    return rows or cost.missing(collection, "cost_full_order")


def row(scene: str, method: str, question: str, target: float, setting: dict) -> dict:
    """The setting is empty where none has this error."""
    ended = Outcome.OK if setting else "not reached"
    identity = {"case": scene, "method": method, "question": question, "target_percent": target}
    return identity | setting | {"outcome": ended}


def of_full_order(scene: str, dataset: xr.Dataset, question: str) -> list[dict]:
    """A row a target."""
    part = dataset.sel(question=question)
    error = part["error"].values + float(part["reference_error"])
    seconds, rows = part["seconds"].values, []
    for target in FULL_ORDER_TARGETS:
        at, setting = cheapest(seconds, error, target), {}
        if at is not None:
            setting = {
                "error_percent": float(error[at]),
                "online_s": float(seconds[at]),
                "setting": described(dataset.isel(setting=at), question),
            }
        rows.append(row(scene, FULL_ORDER, question, target, setting))
    return rows


def of_method(scene: str, method: str, group: list[cost.Pooled], question: str) -> list[dict]:
    """A row a target."""
    error, online = (
        np.array([getattr(one, name)[question] for one in group]) for name in ("error", "online")
    )
    offline, rows = np.array([one.offline for one in group]), []
    for target in TARGETS:
        at, setting = cheapest(offline + online, error, target), {}
        if at is not None:
            setting = {
                "error_percent": float(error[at]),
                "offline_s": float(offline[at]),
                "online_s": float(online[at]),
                "setting": f"{group[at].varied} {group[at].set_to}".strip(),
            }
        rows.append(row(scene, method, question, target, setting))
    return rows


def described(setting: xr.Dataset, question: str) -> str:
    """A setting of the full order in words."""
    steps = f"T/{int(setting['steps_per_period'])}"
    if str(setting["study"].values) == "mesh":
        cells = f"{int(setting['columns'])} x {int(setting['rows'])}"
        mesh = f"{setting['element'].values} {cells}"
        return mesh if question == "frequency" else f"{mesh}, {steps}"
    scheme = str(setting["scheme"].values)
    return ("" if scheme == "newmark" else f"{scheme.replace('_', ' ')}, ") + (
        f"{steps}, alpha {float(setting['alpha']):g}, "
        f"start {setting['initial_acceleration'].values}, residual {float(setting['residual']):g}"
    )
