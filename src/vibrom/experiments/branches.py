"""The forced response curve with all of its branches, stable or not, by continuation in frequency.

What a sweep, or a start from rest, shows of a curve with folds is a part of it. Here the periodic
motions themselves are followed, through the folds at which they lose stability. Isolas are closed
curves apart from the rest; they are looked for from the motions at phase resonance, of which each
has two, and from sweeps. One row is one periodic motion. Source: Nayfeh and Balachandran, Applied
Nonlinear Dynamics (1995), chapters 3, 6.
"""

from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

import numpy as np
import xarray as xr

from vibrom.artefacts.progress import bar
from vibrom.config.kinds import Count, NonNegative, Positive, Turn, Whole
from vibrom.experiments import Experiment, Given
from vibrom.models.model import Model
from vibrom.models.motions import errors, motions
from vibrom.solvers.periodic.continuation import Pace
from vibrom.solvers.periodic.equations import in_frequency
from vibrom.solvers.periodic.flow_map import FlowMap
from vibrom.solvers.periodic.harmonic_balance import HarmonicBalance
from vibrom.solvers.periodic.response import Near, Span
from vibrom.solvers.periodic.starts import from_backbone, from_sweeps


@dataclass(frozen=True)
class Branches(Experiment):
    """One forcing amplitude, a range of frequencies."""

    forcing: Positive  # amplitude, times the scene's load
    lowest: Positive = 0.8  # times the damped first frequency
    highest: Positive = 1.2  # times the damped first frequency
    points: Count = 250  # at most, of all branches
    turn: Turn = 0.25  # rad, that a branch may turn between two points
    minor: NonNegative = 1e-3  # times the damped first frequency: two folds this close are minor
    frequencies: Count = 33  # at which stable motions are counted, as in the curve from rest
    resonances: Whole = 60  # points of the backbone that is asked for isolas, at most; 0: none
    sweeps: Whole = 0  # frequencies of sweeps up and down that are asked for isolas
    periods: Count = 60  # at each frequency of these sweeps
    # how motions of reduced models are found; those of the full order are always shot, by its own
    # steps, and harmonic balance is a second opinion of the highest, of folds and of ends
    method: Literal["shooting", "harmonic_balance"] = "shooting"
    harmonics: Count = 15  # the highest one that is balanced

    scores = {
        "folds": "1",
        "fold_frequency_error_percent": "percent",
        "fold_amplitude_error_percent": "percent",
        "peak_frequency_error_percent": "percent",
        "peak_error_percent": "percent",
        "bistable_width_error_percent": "percent",
        "stable_amplitude_error_percent": "percent",
        "unstable_amplitude_error_percent": "percent",
        "wrong_stable_motions": "1",
    }
    truth = "branches"
    where_set = True
    job = "curves"

    def brief(self) -> "Branches":
        """A few points."""
        return replace(self, points=4, resonances=0, sweeps=0)

    def ask(self, model: Model, given: Given) -> xr.Dataset:
        """Every periodic motion that was found, one a row, branch after branch."""
        flow, scale, forcing = model.return_map(), model.frequency, float(self.forcing)
        balanced, second = None, None
        if self.method == "harmonic_balance" and isinstance(flow, FlowMap):
            balanced = HarmonicBalance(flow, self.harmonics)
        elif self.method == "harmonic_balance":
            second = partial(flow.opinion, harmonics=self.harmonics)
        span = Span(self.lowest * scale, self.highest * scale, self.points, self.minor * scale)
        grid = np.linspace(self.lowest, self.highest, self.frequencies) * scale

        def near() -> list[Near]:
            found = []
            if self.resonances:
                found += from_backbone(flow, forcing, self.resonances, self.turn, heard)
            if self.sweeps:
                frequency = np.linspace(span.lowest, span.highest, self.sweeps + 2)[1:-1]
                found += from_sweeps(flow, forcing, frequency, self.periods, heard)
            if balanced is None:
                return found
            return [(balanced.of_point(x, omega, forcing), omega) for x, omega in found]

        most = self.points + self.resonances + 2 * self.sweeps
        with bar(f"{given.title}branches, at most {most} motions", most, "motions") as heard:
            scale = 0.1 * (span.highest - span.lowest)
            pace = Pace(scale, turn=self.turn, newton=flow.free, heard=heard)
            curve = in_frequency(balanced or flow, forcing)
            return motions(curve, span, pace, grid, given.probe, near, second)

    def score(self, answer: xr.Dataset, truth: xr.Dataset) -> dict[str, float]:
        """Where and how high the curve folds and peaks, and how far its branches are off."""
        return errors(answer, truth, "frequency")
