"""Periodic motions at one frequency against the amplitude of the forcing, by continuation: an S,
where the response curve folds.

Between the two folds of the S a large and a small motion are both stable, and a third one between
them is not: the forcing at which the small one jumps up as the forcing grows is the upper fold, and
the one at which the large one gives way as it shrinks the lower fold. One row is one periodic
motion. Source: Nayfeh and Mook, Nonlinear Oscillations (1979), section 4.1.
"""

from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from vibrom.artefacts.progress import bar
from vibrom.config.kinds import Count, NonNegative, Positive, Turn
from vibrom.experiments import Experiment, Given
from vibrom.models.model import Model
from vibrom.models.motions import errors, motions
from vibrom.solvers.periodic.continuation import Pace
from vibrom.solvers.periodic.equations import in_amplitude
from vibrom.solvers.periodic.response import Span

LOWEST = 0.02  # of the largest forcing: where the curve begins, nearly linear


@dataclass(frozen=True)
class SCurve(Experiment):
    """One frequency, all amplitudes of the forcing up to a largest one."""

    frequency: Positive  # times the damped first frequency
    forcing: Positive  # largest amplitude, times the scene's load
    points: Count = 150  # at most
    turn: Turn = 0.25  # rad, that the curve may turn between two points
    minor: NonNegative = 1e-2  # times the largest forcing: two folds this close are minor
    forcings: Count = 33  # at which stable motions are counted, up to the largest one

    scores = {
        "folds": "1",
        "fold_forcing_error_percent": "percent",
        "fold_amplitude_error_percent": "percent",
        "bistable_width_error_percent": "percent",
        "stable_amplitude_error_percent": "percent",
        "unstable_amplitude_error_percent": "percent",
        "wrong_stable_motions": "1",
    }
    truth = "s_curve"
    job = "curves"
    where_set = True

    def brief(self) -> "SCurve":
        """A few points."""
        return replace(self, points=4)

    def ask(self, model: Model, given: Given) -> xr.Dataset:
        """Every periodic motion that was found, one a row."""
        flow, largest = model.return_map(), float(self.forcing)
        span = Span(LOWEST * largest, largest, self.points, self.minor * largest)
        grid = np.linspace(0.0, largest, self.forcings + 1)[1:]
        curve = in_amplitude(flow, self.frequency * model.frequency)
        with bar(
            f"{given.title}S curve, at most {self.points} motions", self.points, "motions"
        ) as heard:
            pace = Pace(0.5 * largest, turn=self.turn, newton=flow.free, heard=heard)
            return motions(curve, span, pace, grid, given.probe)

    def score(self, answer: xr.Dataset, truth: xr.Dataset) -> dict[str, float]:
        """Where and how high the curve folds, and how far its branches are off."""
        found = errors(answer, truth, "forcing")
        return {name: found[name] for name in self.scores}
