"""The measured response curve of a recorded scene: every frequency in the order of the measured
sweep, the motion carried on from one to the next.

A model has never seen a forced motion. Where the strength of the load is not known, one point of
the curve tells it (`models.calibration`), and the model agrees with that point.
"""

import time
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from vibrom.artefacts.data import outcome_variables, variable
from vibrom.artefacts.outcome import Outcome
from vibrom.config.kinds import Count, Positive
from vibrom.experiments import Experiment, Given
from vibrom.models.measures import curve_error, periodic, response_variables
from vibrom.models.model import Model
from vibrom.models.training import Unsupported
from vibrom.solvers.periodic.carried import swept, swings
from vibrom.solvers.periodic.equations import prepare


@dataclass(frozen=True)
class MeasuredResponse(Experiment):
    """At the measured frequencies."""

    forcing: Positive = 1.0  # times the scene's load, whose strength the response may have told
    periods: Count = 200  # of the load, at each frequency

    scores = {
        "completed": "1",
        "amplitude_error_median_percent": "percent",
        "amplitude_error_largest_percent": "percent",
        "peak_error_percent": "percent",
    }
    of_full_order = False
    where_set = True

    def brief(self) -> "MeasuredResponse":
        """One period at each frequency."""
        return replace(self, periods=1)

    def ask(self, model: Model, given: Given) -> xr.Dataset:
        """Largest and smallest value of the last period, beside the measured amplitude."""
        if "response_frequency" not in given.structure:
            raise Unsupported("no response was measured (`forcing.response`)")
        known = given.structure
        flow, frequency = model.return_map(), known["response_frequency"].values
        probe = int(np.nonzero(model.probes == int(known["response_dof"]))[0][0])
        prepare(flow, frequency[0])
        began, force = time.perf_counter(), float(self.forcing)
        points = swept(flow, frequency, force, self.periods)
        swing = swings(flow, points, frequency, force)[:, probe]
        seconds = time.perf_counter() - began
        lasts = np.isfinite(swing).all(axis=1)
        words = np.where(lasts, Outcome.OK.value, Outcome.DIVERGED.value).astype(object)
        shown = periodic(swing)
        point = "response"
        answer = {
            **response_variables((point,), shown),
            "angular_frequency": variable(point, frequency, "rad s-1", "of the load"),
            "measured_amplitude": known["response_amplitude"].variable,
            "forcing": variable((), force, "1", "amplitude, times the scene's load"),
            **outcome_variables(Outcome.OK, seconds=seconds),
            "outcome": variable(point, words, "1", "how the motion ended"),
        }
        return xr.Dataset(answer)

    def score(self, answer: xr.Dataset, truth: xr.Dataset | None) -> dict[str, float]:
        """Errors of half the range against the measured amplitudes."""
        measured = answer["measured_amplitude"].values
        error = curve_error(answer["half_range"].values, measured)
        return {
            "completed": float(error.completed),
            "amplitude_error_median_percent": error.median_percent,
            "amplitude_error_largest_percent": error.largest_percent,
            "peak_error_percent": error.peak_percent,
        }
