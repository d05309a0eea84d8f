"""How far the equations of motion trust a model

No truth is needed here: a model's own motion is inserted into the equations of motion of the body,
and the displacement that would balance the residual, relative to the largest one of the motion, is
its error. A model may be trusted to the largest displacement at which this error stays within the
tolerance of the study (``studies.trust``), along ellipses where its first reduced oscillator moves;
zero where it never does. Beside it stand the errors in the first period of the model's own decay
from the test release, and at the edge of the training range, of the model that learns nothing: of
what it says itself that it may be trusted to. Medians over seeds.
"""

import numpy as np

from vibrom.artefacts.outcome import Outcome, Tally
from vibrom.report.collection import FULL_ORDER, by_method
from vibrom.report.columns import CASE, METHOD, OUTCOME, SEEDS, Column
from vibrom.report.scores import spread

FAMILY = "trust"
PLACE = 340
MEASURES = {
    "trusted_displacement_m": ("trusted_displacement", False),
    "trusted_probe_displacement_m": ("trusted_probe_displacement", False),
    "release_displacement_m": ("release_displacement", False),
    "release_error_percent": ("release_error", True),
    "range_error_percent": ("error", True),
}
COLUMNS = (
    CASE,
    METHOD,
    Column("trusted_displacement_m", "Trusted to [m]", spread=True),
    Column("trusted_probe_displacement_m", "of the probe [m]", spread=True),
    Column("release_displacement_m", "Test decay [m]", spread=True),
    Column("release_error_percent", "Error there [%]", spread=True),
    Column("range_error_percent", "Error at the edge of the range [%]", spread=True),
    SEEDS,
    OUTCOME,
)


def build(collection, scores):
    """One row a case and method."""
    rows = []
    for scene in collection.scenes:
        study = collection.find(scene, FULL_ORDER, "trust")
        if study is None:
            rows.append({"case": scene, "method": FULL_ORDER, "outcome": Outcome.NOT_RUN})
            continue
        edge = study.isel(amplitude=int(np.abs(study["amplitude"].values - 1.0).argmin()))
        for method, chosen in by_method(edge):
            row = {"case": scene, "method": method, "seeds": chosen.sizes["fit"]}
            for column, (name, worst) in MEASURES.items():
                row |= spread(chosen[name].values, worst=worst).columns(column)
            rows.append(row | {"outcome": Tally(chosen["outcome"].values)})
    return rows
