"""The motion from rest under the loads that have signals of their own:

    M a + C v + K q + sum f(q, v) = sum_k p_k u_k(t) + a p sin(w t) + p_0

A recorded base motion, a blow, a chirp, noise: reduced models never saw any of them. Whatever the
signals, they act alone, or with a sine of the scene's other loads p on top. Values after a failure
are NaN.
"""

import json
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from vibrom import signals
from vibrom.artefacts.data import outcome_variables, variable
from vibrom.config.kinds import Count, NonNegative, Positive, Tolerance
from vibrom.experiments import Experiment, Given, at_rest
from vibrom.models.balance import balance_variable, checked
from vibrom.models.measures import distance_variable, nmte_percent, range_variable
from vibrom.models.model import Model, Signals, Watch
from vibrom.models.training import Unsupported


@dataclass(frozen=True)
class Response(Experiment):
    """The loads say what their signals are."""

    periods: Count = 50  # of the damped first mode
    forcing: NonNegative = 0.0  # amplitude of the sine on top, times the load without a signal
    frequency: Positive = 1.0  # of that sine, times the damped first frequency
    balance: Tolerance = 0.01  # relative error of energy, work and losses, where that is known

    scores = {
        "nmte_percent": "percent",
        "peak_error_percent": "percent",
        "rms_error_percent": "percent",
    }
    truth = "response"
    where_set = True
    job = "answers"

    def brief(self) -> "Response":
        """Two periods."""
        return replace(self, periods=min(self.periods, 2))

    def ask(self, model: Model, given: Given) -> xr.Dataset:
        """All displacements at the instants that the full order stores."""
        drive = self.drive(model, given.structure)
        period = 2.0 * np.pi / model.frequency
        instants = period * np.arange(self.periods * given.samples + 1) / given.samples
        run = model.motion(at_rest(model), drive, Watch(instants))
        ended = checked(run.outcome, run.balance, self.balance)
        displacement = run.displacement[0][0]
        answer = {
            "displacement": variable(
                ("time", "dof"), displacement, "m", "displacement of each free dof"
            ),
            "probe_displacement": variable(
                ("probe", "time"),
                np.asarray(displacement[:, model.probes]).T,
                "m",
                "displacement at the probes",
            ),
            "signal": variable(
                ("driven", "time"), drive.value(instants)[0], "1", "signal of each load"
            ),
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
        time = variable("time", instants, "s", "time since the start")
        return xr.Dataset(answer, coords={"time": time, "probe": given.probe})

    def drive(self, model: Model, known: xr.Dataset) -> Signals:
        """The loads with their signals, and the sine on top."""
        if "driven_load" not in known:
            raise Unsupported("no load of this scene has a signal; give one (`signal`)")
        loads = list(known["driven_load"].values)
        functions = [signals.total(own) for own in json.loads(known.attrs["signals"])]
        if self.forcing:
            loads.append(known["load"].values)
            frequency = self.frequency * model.frequency
            functions.append(lambda t: self.forcing * np.sin(frequency * t))
        return Signals(np.array(loads), lambda t: np.array([[u(t) for u in functions]]))

    def score(self, answer: xr.Dataset, truth: xr.Dataset) -> dict[str, float]:
        """NMTE of the whole motion, and errors of the first probe's largest displacement, whatever
        its sign, and of its root mean square.
        """
        model, true = (item["displacement"].variable for item in (answer, truth))
        seen, known = (item["probe_displacement"].values[0] for item in (answer, truth))
        return {
            "nmte_percent": nmte_percent(true, model),
            "peak_error_percent": float(100 * (np.abs(seen).max() / np.abs(known).max() - 1)),
            "rms_error_percent": float(100 * np.sqrt(np.mean(seen**2) / np.mean(known**2)) - 100),
        }

    def stored(self, answer: xr.Dataset, truth: xr.Dataset) -> xr.Dataset:
        """With the probes' true displacement and the norm of the error instead of all
        displacements.
        """
        displacements = (item["displacement"].variable for item in (truth, answer))
        true = variable(
            ("probe", "time"),
            truth["probe_displacement"].values,
            "m",
            "displacement of the full order at the probes",
        )
        kept = answer.drop_vars("displacement").assign(probe_true=true)
        return kept.assign(distance_variable(*displacements))
