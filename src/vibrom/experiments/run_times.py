"""What a model costs: seconds offline (training data, mapping, dynamics) and online (one decay, one
forced run, one response curve).

Wall time of the computation alone: loading, compilation and warm-up are outside. Source of the
columns: thesis, section 3.5.
"""

import numpy as np
import xarray as xr

from vibrom.artefacts.data import FINISHED, outcome_variables, scored
from vibrom.models.rollout import Integrator

needs = ("train", "rom", "decay", "forced", "frc")
full_order = ("test", "forced", "frc")
scores = dict.fromkeys(
    (
        "generate_training_data_s",
        "obtain_mapping_s",
        "obtain_dynamics_s",
        "decay_s",
        "forced_s",
        "frc_s",
    ),
    "s",
)


def predict(artefacts: dict, integrator: Integrator) -> xr.Dataset:
    """What did not go all the way has no time: a model that blows up is not a fast one."""
    failures = []

    def seconds(name: str, variable: str = "seconds") -> float:
        bad = [
            word
            for word in np.unique(artefacts[name]["outcome"].values.astype(str))
            if word not in FINISHED
        ]
        failures.extend(bad)
        return float("nan") if bad else float(artefacts[name][variable])

    found = {
        "decay_s": seconds("decay" if "decay" in artefacts else "test"),
        "forced_s": seconds("forced"),
        "frc_s": seconds("frc"),
    }
    if "train" in artefacts:
        found |= {
            "generate_training_data_s": seconds("train"),
            "obtain_mapping_s": seconds("rom", "mapping_seconds"),
            "obtain_dynamics_s": seconds("rom", "dynamics_seconds"),
        }
    units = {name: unit for name, unit in scores.items() if name in found}  # in their order
    return scored(xr.Dataset(outcome_variables(failures[0] if failures else "ok")), found, units)
