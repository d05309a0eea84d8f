"""The response to a forcing at the damped first frequency, from rest; the error is that of the last
period.

Source: thesis, section 3.4.1. Reduced models never saw a forced motion.
"""

from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from vibrom.artefacts.data import outcome_variables, variable
from vibrom.config.kinds import Count, Positive, Tolerance
from vibrom.experiments import Experiment, Given, at_rest
from vibrom.models.balance import balance_variable, checked
from vibrom.models.measures import distance, nmte_percent, range_variable
from vibrom.models.model import Drive, Model, Watch
from vibrom.models.steady import change, change_variable, judged, strobe

THIN = 2  # the whole motion is kept at every second of the instants of a period


@dataclass(frozen=True)
class Forced(Experiment):
    """One amplitude, one frequency."""

    forcing: Positive  # amplitude, times the scene's load
    periods: Count = 200
    steady: Tolerance = 0.001  # of the amplitude: what the last quarter of a run may still change
    balance: Tolerance = 0.01  # relative error of energy, work and losses, where that is known

    scores = {"nmte_percent": "percent", "amplitude_error_percent": "percent"}
    truth = "forced"
    job = "answers"

    def brief(self) -> "Forced":
        """Two periods."""
        return replace(self, periods=min(self.periods, 2))

    def ask(self, model: Model, given: Given) -> xr.Dataset:
        """The probes from the start, all displacements in the last period."""
        drive = Drive(np.array([float(self.forcing)]), np.array([model.frequency]))
        period, total = drive.period[0], self.periods * given.samples
        instants = period * np.arange(0, total + 1, THIN) / given.samples
        last = period * np.arange(total - given.samples, total + 1) / given.samples
        seen = strobe(drive.period, self.periods, given.samples, model.probes)
        run = model.motion(at_rest(model), drive, Watch(instants, model.probes), Watch(last), seen)
        last_displacement = run.displacement[1][0]
        largest = np.abs(np.asarray(last_displacement[:, model.probes])).max(axis=0)[None]
        changes = change(run.displacement[2], largest, self.periods)
        ended = checked(run.outcome, run.balance, self.balance)
        ended = judged(ended, changes, self.steady)
        answer = {
            "probe_displacement": variable(
                ("probe", "time"), run.displacement[0][0].T, "m", "displacement at the probes"
            ),
            "last_displacement": variable(
                ("last_time", "dof"),
                last_displacement,
                "m",
                "displacement of each free dof in the last period",
            ),
            "forcing": variable((), float(self.forcing), "1", "amplitude, times the scene's load"),
            "angular_frequency": variable(
                (), model.frequency, "rad s-1", "angular frequency of the forcing"
            ),
            "period": variable((), period, "s", "period of the forcing"),
            **change_variable((), changes[0]),
            **balance_variable((), run.balance),
            **outcome_variables(ended[0], run.failed_at[0], run.seconds),
        }
        if run.reduced is not None:
            answer |= {
                "reduced": variable(
                    ("time", "coordinate"), run.reduced[0][0], "1", "reduced coordinates"
                ),
                **range_variable((), run.range_ratio[0]),
            }
        coords = {
            "time": variable("time", instants, "s", "time since the forcing began"),
            "last_time": variable(
                "last_time", last, "s", "time since the forcing began, in the last period"
            ),
            "probe": given.probe,
            "probe_dof": given.structure["probe_dof"].variable,
        }
        return xr.Dataset(answer, coords=coords)

    def score(self, answer: xr.Dataset, truth: xr.Dataset) -> dict[str, float]:
        """NMTE of the last period, and the error of its largest value at the first probe."""
        model, true = (item["last_displacement"].variable for item in (answer, truth))
        first = int(answer["probe_dof"].values[0])
        amplitude = model[:, first].values.max() / true[:, first].values.max()
        return {
            "nmte_percent": nmte_percent(true, model),
            "amplitude_error_percent": float(100 * (amplitude - 1)),
        }

    def stored(self, answer: xr.Dataset, truth: xr.Dataset) -> xr.Dataset:
        """With the shapes when the first probe is highest instead of all displacements."""
        model, true = (item["last_displacement"].variable for item in (answer, truth))
        first = int(answer["probe_dof"].values[0])
        watched, known = (item[:, first].values for item in (model, true))
        at = int(watched.argmax()) if np.isfinite(watched).all() else 0
        return answer.drop_vars("last_displacement").assign(
            final_shape=variable(
                "dof",
                model[at].values,
                "m",
                "displacement when the first probe is highest at the end",
            ),
            final_shape_true=variable(
                "dof", true[int(known.argmax())].values, "m", "the same of the full order"
            ),
            error=variable(
                "last_time",
                distance(true, model),
                "m",
                "norm of the displacement error in the last period",
            ),
        )
