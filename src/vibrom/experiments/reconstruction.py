"""How well the model's own coordinates describe an unseen decay:  q against the displacement of
decode(encode(q, v)).

No dynamics is evaluated. Source: thesis, section 3.2.3.
"""

import time
from dataclasses import dataclass

import numpy as np
import xarray as xr

from vibrom.artefacts.data import outcome_variables, variable
from vibrom.artefacts.outcome import Outcome
from vibrom.experiments import Experiment, Given
from vibrom.models.measures import nmte_percent
from vibrom.models.model import Model
from vibrom.models.recorded import trajectory


@dataclass(frozen=True)
class Reconstruction(Experiment):
    """Has no settings."""

    scores = {"nmte_percent": "percent"}
    reads = ("test",)
    truth = "test"
    of_full_order = False
    job = "answers"

    def ask(self, model: Model, given: Given) -> xr.Dataset:
        """Reduced coordinates of the true motion, and the displacements that they stand for."""
        record = trajectory(given.answers["test"])
        began = time.perf_counter()
        encoded = model.coordinates(record.state)
        displacement = model.decoded(encoded)
        seconds = time.perf_counter() - began
        return xr.Dataset(
            {
                "displacement": variable(
                    ("time", "dof"), displacement, "m", "displacement of each free dof"
                ),
                "encoded": variable(
                    ("time", "coordinate"), encoded, "1", "reduced coordinates of the true motion"
                ),
                **outcome_variables(Outcome.OK, seconds=seconds),
            },
            coords={"time": variable("time", record.time, "s", "time since release")},
        )

    def score(self, answer: xr.Dataset, truth: xr.Dataset) -> dict[str, float]:
        """NMTE over the whole decay."""
        true = trajectory(truth).displacement
        return {"nmte_percent": nmte_percent(true, answer["displacement"].values)}

    def stored(self, answer: xr.Dataset, truth: xr.Dataset) -> xr.Dataset:
        """With the norm of the error instead of all displacements."""
        error = answer["displacement"].values - trajectory(truth).displacement
        return answer.drop_vars("displacement").assign(
            error=variable(
                "time", np.linalg.norm(error, axis=1), "m", "norm of the displacement error"
            )
        )
