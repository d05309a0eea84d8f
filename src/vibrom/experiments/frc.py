"""The forced response curve: amplitude and phase of the last period, every frequency from rest, all
frequencies side by side.

Started from rest, a frequency shows one of the motions that are possible there. Source: thesis,
section 2.3.3.
"""

from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from vibrom.artefacts.data import outcome_variables, variable
from vibrom.artefacts.outcome import Outcome
from vibrom.config.kinds import Count, Positive, Tolerance
from vibrom.experiments import Experiment, Given, at_rest
from vibrom.models.balance import balance_variable, checked
from vibrom.models.measures import curve_error, periodic, range_variable, response_variables
from vibrom.models.model import Drive, Model, Watch
from vibrom.models.steady import change, change_variable, judged, strobe


@dataclass(frozen=True)
class ResponseCurve(Experiment):
    """One forcing amplitude at equally spaced frequencies."""

    forcing: Positive  # amplitude, times the scene's load
    periods: Count = 200  # from rest, at each frequency
    frequencies: Count = 33  # from the lowest to the highest
    lowest: Positive = 0.8  # times the damped first frequency
    highest: Positive = 1.2  # times the damped first frequency
    steady: Tolerance = 0.001  # of the amplitude: what the last quarter of a run may still change
    balance: Tolerance = 0.01  # relative error of energy, work and losses, where that is known

    scores = {
        "completed": "1",
        "amplitude_error_median_percent": "percent",
        "amplitude_error_largest_percent": "percent",
        "peak_error_percent": "percent",
    }
    truth = "frc"
    job = "answers"

    def brief(self) -> "ResponseCurve":
        """One frequency, one period."""
        return replace(self, periods=1, frequencies=1)

    def ask(self, model: Model, given: Given) -> xr.Dataset:
        """Largest and smallest value of the last period at every probe, and the phase."""
        frequency = np.linspace(self.lowest, self.highest, self.frequencies) * model.frequency
        drive = Drive(np.full(len(frequency), float(self.forcing)), frequency)
        # The instants are those after a step, up to the end, which is also the period's beginning.
        part = np.arange(1, model.samples + 1) / model.samples
        instants = drive.period[:, None] * (self.periods - 1 + part)
        seen = strobe(drive.period, self.periods, model.samples, model.probes)
        watch = Watch(instants, model.probes)
        run = model.motion(at_rest(model, len(frequency)), drive, watch, seen)
        largest = np.abs(run.displacement[0]).max(axis=1)
        changes = change(run.displacement[1], largest, self.periods)
        ended = checked(run.outcome, run.balance, self.balance)
        shown = periodic(np.roll(run.displacement[0].transpose(2, 0, 1), 1, axis=-1))
        dims, point = ("probe", "angular_frequency"), "angular_frequency"
        answer = {
            **response_variables(dims, shown),
            "forcing": variable((), float(self.forcing), "1", "amplitude, times the scene's load"),
            **balance_variable(point, run.balance),
            **outcome_variables(Outcome.OK, seconds=run.seconds),
            "outcome": variable(
                point, judged(ended, changes, self.steady), "1", "how the run ended"
            ),
            **change_variable(point, changes),
            "failed_at": variable(
                point, run.failed_at, "s", "when the run failed or first left the training range"
            ),
        }
        if run.reduced is not None:
            answer |= range_variable(point, run.range_ratio)
        coords = {
            point: variable(point, frequency, "rad s-1", "angular frequency of the forcing"),
            "probe": given.probe,
        }
        return xr.Dataset(answer, coords=coords)

    def score(self, answer: xr.Dataset, truth: xr.Dataset) -> dict[str, float]:
        """Errors of the amplitude at the first probe."""
        error = curve_error(*(item["amplitude"].values[0] for item in (answer, truth)))
        return {
            "completed": float(error.completed),
            "amplitude_error_median_percent": error.median_percent,
            "amplitude_error_largest_percent": error.largest_percent,
            "peak_error_percent": error.peak_percent,
        }
