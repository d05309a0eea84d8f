"""What a model costs: seconds offline (training data, mapping, dynamics) and online (one decay, one forced run, one response curve).

Wall time of the computation alone: loading, compilation and warm-up are outside. Source of the columns: thesis, section 3.5.
"""

import xarray as xr

from vibrom.data import outcome_variables, scored
from vibrom.rollout import Integrator

needs = ("train", "rom", "decay", "forced", "frc")
full_order = ("test", "forced", "frc")


def predict(artefacts: dict, integrator: Integrator) -> xr.Dataset:
    def seconds(name: str, variable: str = "seconds") -> tuple[float, str]:
        return float(artefacts[name][variable]), "s"

    scores = {"decay_s": seconds("decay" if "decay" in artefacts else "test"), "forced_s": seconds("forced"), "frc_s": seconds("frc")}
    if "train" in artefacts:
        offline = {"generate_training_data_s": seconds("train"), "obtain_mapping_s": seconds("rom", "mapping_seconds"),
                   "obtain_dynamics_s": seconds("rom", "dynamics_seconds")}
        scores = offline | scores
    return scored(xr.Dataset(outcome_variables("ok")), scores)
