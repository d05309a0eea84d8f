"""How well the model's own coordinates describe an unseen decay:  q against the displacement of
decode(encode(q, v)).

No dynamics is evaluated. Source: thesis, section 3.2.3.
"""

import time
from dataclasses import dataclass

import xarray as xr

from vibrom.artefacts.data import outcome_variables, variable
from vibrom.artefacts.outcome import Outcome
from vibrom.experiments import Experiment, Given
from vibrom.models.decoded import decoded
from vibrom.models.measures import distance_variable, nmte_percent
from vibrom.models.model import Model
from vibrom.models.recorded import trajectory
from vibrom.models.samples import Samples


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
        record = trajectory(given.answers["test"], lazy=True)
        began = time.perf_counter()
        encoded = Samples((record.columns("state"),)).map(model.coordinates)
        seconds = time.perf_counter() - began
        displacement, decoding = decoded(model, encoded[None])
        return xr.Dataset(
            {
                "displacement": variable(
                    ("time", "dof"), displacement[0], "m", "displacement of each free dof"
                ),
                "encoded": variable(
                    ("time", "coordinate"), encoded, "1", "reduced coordinates of the true motion"
                ),
                **outcome_variables(Outcome.OK, seconds=seconds + decoding),
            },
            coords={"time": variable("time", record.time, "s", "time since release")},
        )

    def score(self, answer: xr.Dataset, truth: xr.Dataset) -> dict[str, float]:
        """NMTE over the whole decay."""
        true = trajectory(truth, lazy=True).displacement
        return {"nmte_percent": nmte_percent(true, answer["displacement"].variable)}

    def stored(self, answer: xr.Dataset, truth: xr.Dataset) -> xr.Dataset:
        """With the norm of the error instead of all displacements."""
        true = trajectory(truth, lazy=True).displacement
        error = distance_variable(true, answer["displacement"].variable)
        return answer.drop_vars("displacement").assign(error)
