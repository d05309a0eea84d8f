"""An unseen decay: the model starts where the recorded motion starts and is left alone.

Source: thesis, section 3.3.1. Values after a failure are NaN.
"""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from vibrom.artefacts.data import outcome_variables, variable
from vibrom.artefacts.outcome import worst
from vibrom.config.kinds import Count
from vibrom.experiments import Experiment, Given
from vibrom.models.measures import nmte_percent, range_variable
from vibrom.models.model import Model, Watch
from vibrom.models.recorded import trajectories


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
        """The motion at the instants of the record; of each decay, where there are several."""
        test, probes = given.answers["test"], model.probes
        count = None if self.periods is None else self.periods * given.samples + 1
        records = [record.part(slice(count)) for record in trajectories(test)]
        runs = [
            model.motion(record.state[:1], None, Watch(record.time - record.time[0]))
            for record in records
        ]
        displacement = np.concatenate([run.displacement[0][0] for run in runs])
        true, state = (
            np.concatenate([getattr(record, what) for record in records])
            for what in ("displacement", "state")
        )
        failed_at = np.concatenate([run.failed_at for run in runs])
        ended, dims = worst(run.outcome[0] for run in runs), ("time", "coordinate")
        answer = {
            "displacement": variable(
                ("time", "dof"), displacement, "m", "displacement of each free dof"
            ),
            "probe_displacement": variable(
                ("probe", "time"), displacement[:, probes].T, "m", "displacement at the probes"
            ),
            "probe_true": variable(
                ("probe", "time"), true[:, probes].T, "m", "recorded displacement at the probes"
            ),
            **outcome_variables(
                ended,
                np.nan if np.isnan(failed_at).all() else np.nanmin(failed_at),
                sum(run.seconds for run in runs),
            ),
        }
        if runs[0].reduced is not None:
            reduced = np.concatenate([run.reduced[0][0] for run in runs if run.reduced])
            answer |= {
                "reduced": variable(dims, reduced, "1", "reduced coordinates"),
                "encoded": variable(
                    dims, model.coordinates(state), "1", "reduced coordinates of the record"
                ),
                **range_variable((), max(run.range_ratio[0] for run in runs)),
            }
        if len(records) > 1:
            part = np.repeat(np.arange(len(records)), [len(record.time) for record in records])
            answer["part"] = variable("time", part, "1", "number of the decay, from zero")
        instants = np.concatenate([record.time for record in records])
        time = variable("time", instants, "s", "time since release")
        return xr.Dataset(answer, coords={"time": time, "probe": given.probe})

    def _true(self, truth: xr.Dataset, given: int) -> np.ndarray:
        """The recorded displacement (m, n) at the instants of an answer of this length."""
        whole = trajectories(truth)
        count = given // len(whole) if self.periods is not None else None
        return np.concatenate([record.displacement[:count] for record in whole])

    def score(self, answer: xr.Dataset, truth: xr.Dataset) -> dict[str, float]:
        """NMTE over the decay, against the record and against the converged motion where that was
        made.
        """
        displacement = answer["displacement"].values
        true = self._true(truth, len(displacement))
        found = {"nmte_percent": nmte_percent(true, displacement)}
        if "converged_displacement" in truth:
            true = truth["converged_displacement"].values[: len(displacement)]
            found["converged_nmte_percent"] = nmte_percent(true, displacement)
        return found

    def stored(self, answer: xr.Dataset, truth: xr.Dataset) -> xr.Dataset:
        """With the norm of the error instead of all displacements."""
        displacement = answer["displacement"].values
        error = displacement - self._true(truth, len(displacement))
        return answer.drop_vars("displacement").assign(
            error=variable(
                "time", np.linalg.norm(error, axis=1), "m", "norm of the displacement error"
            )
        )
