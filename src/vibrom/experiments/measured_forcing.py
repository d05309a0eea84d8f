"""The motion under a recorded signal: the model starts where the recording starts.

    dz/dt = drift(z) + s sum_k force_map(z, p_k) u_k(t)

A model has never seen a forced motion. The strength s of the load is known, or another recording
tells it (`models.calibration`). Values after a failure are NaN.
"""

from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy.interpolate import make_interp_spline

from vibrom.artefacts.data import outcome_variables, variable
from vibrom.artefacts.outcome import worst
from vibrom.experiments import Experiment, Given
from vibrom.models.measures import nmte_percent, range_variable
from vibrom.models.model import Model, Motion, Signals, Watch
from vibrom.models.training import Unsupported


@dataclass(frozen=True)
class MeasuredForcing(Experiment):
    """All recordings with the role `forced`."""

    scores = {"nmte_percent": "percent", "amplitude_error_percent": "percent"}
    of_full_order = False
    where_set = True

    def ask(self, model: Model, given: Given) -> xr.Dataset:
        """The channels at the instants of the recordings, beside what was recorded."""
        known = given.structure
        if "signal_calibrates" not in known or known["signal_calibrates"].values.all():
            raise Unsupported("no motion under a signal was recorded (the role `forced`)")
        known = known.isel(signal_sample=known["signal_calibrates"].values == 0)
        part, runs = known["signal_part"].values, []
        for number in np.unique(part):
            runs.append(self._run(model, known.isel(signal_sample=part == number)))
        found = np.concatenate([run.displacement[0][0] for run in runs])
        true = known["signal_displacement"].values[:, model.probes]
        failed = np.concatenate([run.failed_at for run in runs])
        dims, time = ("probe", "time"), known["signal_time"].values
        return xr.Dataset(
            {
                "probe_displacement": variable(dims, found.T, "m", "displacement of the channels"),
                "probe_true": variable(dims, true.T, "m", "recorded displacement of the channels"),
                "signal": variable(
                    "time", known["signal_value"].values[:, 0], "1", "what drove it"
                ),
                "part": variable("time", part, "1", "number of the recording"),
                **range_variable((), max(float(run.range_ratio[0]) for run in runs)),
                **outcome_variables(
                    worst(run.outcome[0] for run in runs),
                    np.nan if np.isnan(failed).all() else np.nanmin(failed),
                    sum(run.seconds for run in runs),
                ),
            },
            {"time": variable("time", time, "s", "time"), "probe": given.probe},
        )

    def _run(self, model: Model, known: xr.Dataset) -> Motion:
        """Under the signals of one recording."""
        time, signal = (known[f"signal_{name}"].values for name in ("time", "value"))
        start = [known[f"signal_{name}"].values[:1] for name in ("displacement", "velocity")]
        instants, loads = time - time[0], known["signal_load"].values
        between = make_interp_spline(instants, signal, k=5)
        drive = Signals(loads, lambda t: between(t).T[None])
        watch = Watch(instants, model.probes)
        return model.motion(np.concatenate(start, axis=1), drive, watch)

    def score(self, answer: xr.Dataset, truth: xr.Dataset | None) -> dict[str, float]:
        """NMTE of the channels, and the error of the first one's largest displacement."""
        found, true = (answer[f"probe_{name}"].values for name in ("displacement", "true"))
        largest = [np.abs(part[0]).max() for part in (found, true)]
        return {
            "nmte_percent": nmte_percent(true.T, found.T),
            "amplitude_error_percent": float(100.0 * (largest[0] / largest[1] - 1.0)),
        }
