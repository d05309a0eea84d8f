"""An unseen decay: the model starts where the recorded motion starts and is left alone.

Source: thesis, section 3.3.1. Values after a failure are NaN.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from vibrom.artefacts.data import outcome_variables, variable
from vibrom.artefacts.outcome import worst
from vibrom.config.kinds import Count
from vibrom.experiments import Experiment, Given
from vibrom.models.measures import distance_variable, nmte_percent, range_variable
from vibrom.models.model import Model, Watch
from vibrom.models.recorded import trajectories
from vibrom.models.samples import Samples


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
        records = [record.part(slice(count)) for record in trajectories(test, lazy=True)]
        runs = [
            model.motion(record.part(slice(1)).state, None, Watch(record.time - record.time[0]))
            for record in records
        ]
        displacement = one_below_the_other([run.displacement[0][0] for run in runs])
        shapes, states = (
            Samples(tuple(record.columns(what) for record in records))
            for what in ("displacement", "state")
        )
        failed_at = np.concatenate([run.failed_at for run in runs])
        ended, dims = worst(run.outcome[0] for run in runs), ("time", "coordinate")
        answer = {
            "displacement": variable(
                ("time", "dof"), displacement, "m", "displacement of each free dof"
            ),
            **at_probes(displacement[:, probes], shapes.map(lambda block: block[:, probes])),
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
                    dims, states.map(model.coordinates), "1", "reduced coordinates of the record"
                ),
                **range_variable((), max(run.range_ratio[0] for run in runs)),
            }
        if len(records) > 1:
            part = np.repeat(np.arange(len(records)), [len(record.time) for record in records])
            answer["part"] = variable("time", part, "1", "number of the decay, from zero")
        instants = np.concatenate([record.time for record in records])
        time = variable("time", instants, "s", "time since release")
        return xr.Dataset(answer, coords={"time": time, "probe": given.probe})

    def _true(self, truth: xr.Dataset, given: int) -> Any:
        """The recorded displacement (m, n) at the instants of an answer of this length."""
        whole = trajectories(truth, lazy=True)
        count = given // len(whole) if self.periods is not None else None
        return one_below_the_other([record.displacement[:count] for record in whole])

    def score(self, answer: xr.Dataset, truth: xr.Dataset) -> dict[str, float]:
        """NMTE over the decay, against the record and against the converged motion where that was
        made.
        """
        displacement = answer["displacement"].variable
        true = self._true(truth, len(displacement))
        found = {"nmte_percent": nmte_percent(true, displacement)}
        if "converged_displacement" in truth:
            true = truth["converged_displacement"].variable[: len(displacement)]
            found["converged_nmte_percent"] = nmte_percent(true, displacement)
        return found

    def stored(self, answer: xr.Dataset, truth: xr.Dataset) -> xr.Dataset:
        """With the norm of the error instead of all displacements."""
        displacement = answer["displacement"].variable
        error = distance_variable(self._true(truth, len(displacement)), displacement)
        return answer.drop_vars("displacement").assign(error)


def at_probes(model: Any, true: np.ndarray) -> dict[str, xr.Variable]:
    """Displacements (m, k) of the model and of the record."""
    words = "displacement at the probes"
    return {
        "probe_displacement": variable(("probe", "time"), np.asarray(model).T, "m", words),
        "probe_true": variable(("probe", "time"), true.T, "m", f"recorded {words}"),
    }


def one_below_the_other(arrays: list[Any]) -> Any:
    """Several as one array; one alone as it is, wherever it lies."""
    return arrays[0] if len(arrays) == 1 else np.concatenate(arrays)
