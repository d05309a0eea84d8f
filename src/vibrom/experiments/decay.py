"""An unseen decay: the model starts where the recorded motion starts and is left alone.

Source: thesis, section 3.3.1. Values after a failure are NaN.
"""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from vibrom.artefacts.data import outcome_variables, variable
from vibrom.config.kinds import Count
from vibrom.experiments import Experiment, Given
from vibrom.models.measures import nmte_percent
from vibrom.models.model import Model, Watch
from vibrom.models.recorded import trajectory


@dataclass(frozen=True)
class Decay(Experiment):
    """From the first state of the recorded test decay."""

    periods: Count | None = None  # of the damped first mode; None: as many as were recorded

    scores = {"nmte_percent": "percent", "converged_nmte_percent": "percent"}
    reads = ("test",)
    truth = "test"
    of_full_order = False  # its decay is the record itself
    job = "answers"

    def brief(self) -> "Decay":
        """One period."""
        return Decay(periods=1)

    def ask(self, model: Model, given: Given) -> xr.Dataset:
        """The motion at the instants of the record."""
        record, probes = trajectory(given.answers["test"]), model.probes
        count = None if self.periods is None else self.periods * given.samples + 1
        state, instants = record.state[:count], record.time[:count]
        run = model.motion(state[:1], None, Watch(instants - instants[0]))
        displacement, dims = run.displacement[0][0], ("time", "coordinate")
        answer = {
            "displacement": variable(
                ("time", "dof"), displacement, "m", "displacement of each free dof"
            ),
            "probe_displacement": variable(
                ("probe", "time"), displacement[:, probes].T, "m", "displacement at the probes"
            ),
            "probe_true": variable(
                ("probe", "time"),
                record.displacement[:count, probes].T,
                "m",
                "recorded displacement at the probes",
            ),
            **outcome_variables(run.outcome[0], run.failed_at[0], run.seconds),
        }
        if run.reduced is not None:
            answer |= {
                "reduced": variable(dims, run.reduced[0][0], "1", "reduced coordinates"),
                "encoded": variable(
                    dims, model.coordinates(state), "1", "reduced coordinates of the record"
                ),
                "range_ratio": variable(
                    (),
                    run.range_ratio[0],
                    "1",
                    "largest reduced coordinate over the largest in the training data",
                ),
            }
        time = variable("time", instants, "s", "time since release")
        return xr.Dataset(answer, coords={"time": time, "probe": given.probe})

    def score(self, answer: xr.Dataset, truth: xr.Dataset) -> dict[str, float]:
        """NMTE over the decay, against the record and against the converged motion where that was
        made.
        """
        displacement = answer["displacement"].values
        true = trajectory(truth).displacement[: len(displacement)]
        found = {"nmte_percent": nmte_percent(true, displacement)}
        if "converged_displacement" in truth:
            true = truth["converged_displacement"].values[: len(displacement)]
            found["converged_nmte_percent"] = nmte_percent(true, displacement)
        return found

    def stored(self, answer: xr.Dataset, truth: xr.Dataset) -> xr.Dataset:
        """With the norm of the error instead of all displacements."""
        displacement = answer["displacement"].values
        error = displacement - trajectory(truth).displacement[: len(displacement)]
        return answer.drop_vars("displacement").assign(
            error=variable(
                "time", np.linalg.norm(error, axis=1), "m", "norm of the displacement error"
            )
        )
