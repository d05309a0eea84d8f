"""What a model costs: seconds offline (training data, mapping, dynamics) and online (one decay, one
forced run, one response curve).

Wall time of the computation alone: loading, compilation and warm-up are outside. Source of the
columns: thesis, section 3.5.
"""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from vibrom.artefacts.data import outcome_variables
from vibrom.artefacts.outcome import Outcome, worst
from vibrom.experiments import Experiment, Given
from vibrom.models.model import Model

# score -> the answer that it is read from, and the variable there
SOURCES = {
    "generate_training_data_s": ("fit", "data_seconds"),
    "obtain_mapping_s": ("fit", "mapping_seconds"),
    "obtain_dynamics_s": ("fit", "dynamics_seconds"),
    "decay_s": ("decay", "seconds"),
    "forced_s": ("forced", "seconds"),
    "frc_s": ("frc", "seconds"),
}


@dataclass(frozen=True)
class RunTimes(Experiment):
    """Has no settings."""

    scores = {
        "generate_training_data_s": "s",
        "obtain_mapping_s": "s",
        "obtain_dynamics_s": "s",
        "decay_s": "s",
        "forced_s": "s",
        "frc_s": "s",
    }
    reads = ("fit", "decay", "forced", "frc")
    of_model = False
    job = "answers"

    def ask(self, model: Model | None, given: Given) -> xr.Dataset:
        """What did not go all the way has no time: a model that blows up is not a fast one."""
        found = {
            name: given.answers[source]
            for name, (source, _) in SOURCES.items()
            if source in given.answers
        }
        ended = {name: worst(np.ravel(item["outcome"].values)) for name, item in found.items()}
        seconds = {
            name: item[SOURCES[name][1]].where(ended[name].has_value)
            for name, item in found.items()
        }
        failed = [outcome for outcome in ended.values() if not outcome.has_value]
        return xr.Dataset({**seconds, **outcome_variables(failed[0] if failed else Outcome.OK)})

    def score(self, answer: xr.Dataset, truth: xr.Dataset | None) -> dict[str, float]:
        """The seconds."""
        return {name: float(answer[name]) for name in self.scores if name in answer}
