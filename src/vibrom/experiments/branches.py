"""The forced response curve with all of its branches, stable or not, by continuation in frequency.

What a sweep, or a start from rest, shows of a curve with folds is a part of it. Here the periodic
motions themselves are followed, through the folds at which they lose stability. One row is one
periodic motion. Source: Nayfeh and Balachandran, Applied Nonlinear Dynamics (1995), chapters 3, 6.
"""

import time
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from vibrom.artefacts.data import variable
from vibrom.artefacts.outcome import Outcome
from vibrom.config.kinds import Count, NonNegative, Positive, Turn
from vibrom.experiments import Experiment, Given
from vibrom.models.curves import Curve, difference
from vibrom.models.measures import periodic
from vibrom.models.model import Model
from vibrom.models.rollout import MARGIN
from vibrom.solvers.periodic.continuation import Pace
from vibrom.solvers.periodic.equations import prepare
from vibrom.solvers.periodic.response import Found, Span, response
from vibrom.solvers.periodic.stability import Kind, leading_first

HARMONICS = 8  # 0 to 7 are kept


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
        return replace(self, points=4)

    def ask(self, model: Model, given: Given) -> xr.Dataset:
        """Every periodic motion that was found, one a row, branch after branch."""
        flow, scale = model.return_map(), model.frequency
        span = Span(self.lowest * scale, self.highest * scale, self.points, self.minor * scale)
        pace = Pace(0.1 * (span.highest - span.lowest), turn=self.turn, newton=flow.free)
        prepare(flow, span.lowest)
        began = time.perf_counter()
        found = response(flow, float(self.forcing), span, pace)
        seconds = time.perf_counter() - began
        rows = _motions(found) | _stability(found, flow.parts) | _endings(found)
        grid = np.linspace(self.lowest, self.highest, self.frequencies) * scale
        curve = curve_of(xr.Dataset(rows))
        rows |= {
            "stable_motions": variable(
                "grid_frequency", curve.motions(grid), "1", "stable motions at this frequency"
            ),
            "bistable_width": variable(
                (), curve.bistable_width, "rad s-1", "width of what has two stable motions or more"
            ),
            "forcing": variable((), float(self.forcing), "1", "amplitude, times the scene's load"),
            "seconds": variable(
                (), seconds, "s", "wall time of the computation, loading and compilation excluded"
            ),
        }
        coords = {
            "probe": given.probe,
            "harmonic": variable("harmonic", np.arange(HARMONICS), "1", "multiple of the forcing"),
            "grid_frequency": variable("grid_frequency", grid, "rad s-1", "angular frequency"),
        }
        return xr.Dataset(rows, coords=coords)

    def score(self, answer: xr.Dataset, truth: xr.Dataset) -> dict[str, float]:
        """Where and how high the curve folds and peaks, and how far its branches are off."""
        curve = curve_of(answer)
        off = difference(curve, curve_of(truth))
        wrong = answer["stable_motions"].values != truth["stable_motions"].values
        return {
            "folds": float(len(curve.folds)),
            "fold_frequency_error_percent": off.fold_frequency,
            "fold_amplitude_error_percent": off.fold_amplitude,
            "peak_frequency_error_percent": off.peak_frequency,
            "peak_error_percent": off.peak_amplitude,
            "bistable_width_error_percent": off.bistable_width,
            "stable_amplitude_error_percent": off.stable_amplitude,
            "unstable_amplitude_error_percent": off.unstable_amplitude,
            "wrong_stable_motions": float(wrong.sum()),
        }


def curve_of(answer: xr.Dataset) -> Curve:
    """The curve of the first probe."""
    names = ("branch", "angular_frequency", "maximum", "stable", "kind")
    branch, frequency, maximum, stable, kind = (answer[name].values for name in names)
    return Curve(branch, frequency, maximum[0], stable.astype(bool), kind.astype(str))


def _motions(found: list[Found]) -> dict[str, xr.Variable]:
    """What is seen of each motion at the probes."""
    swing = np.stack([item.swing.displacement for item in found], axis=1)  # (k, m, samples)
    shown, dims = periodic(swing), ("probe", "point")
    harmonic = np.abs(np.fft.rfft(swing)[..., :HARMONICS]) / swing.shape[-1]
    harmonic[..., 1:] *= 2.0
    return {
        "branch": variable("point", [item.branch for item in found], "1", "number of the branch"),
        "angular_frequency": variable(
            "point", [item.orbit.p for item in found], "rad s-1", "angular frequency of the forcing"
        ),
        "maximum": variable(dims, shown.maximum, "m", "largest value of a period"),
        "minimum": variable(dims, shown.minimum, "m", "smallest value of a period"),
        "half_range": variable(
            dims, shown.half_range, "m", "half the range of a period, peak to peak"
        ),
        "phase": variable(
            dims, shown.phase, "rad", "phase of the first harmonic relative to the forcing"
        ),
        "harmonic_amplitude": variable(
            (*dims, "harmonic"), harmonic, "m", "amplitude of each harmonic of the forcing"
        ),
    }


def _stability(found: list[Found], parts: int) -> dict[str, xr.Variable]:
    """Floquet's multipliers, of a whole period."""
    leading = [leading_first(item.multipliers)[0] for item in found]
    largest = np.array(leading, dtype=complex) ** parts
    names = {"real": largest.real, "imaginary": largest.imag}
    return {
        "stable": variable("point", np.int8(np.abs(largest) < 1.0), "1", "1: stable, 0: unstable"),
        "multiplier_largest": variable(
            "point", np.abs(largest), "1", "size of the largest Floquet multiplier"
        ),
        **{
            f"multiplier_{name}": variable(
                "point", part, "1", f"{name} part of the largest Floquet multiplier"
            )
            for name, part in names.items()
        },
    }


def _endings(found: list[Found]) -> dict[str, xr.Variable]:
    """What is special about a motion."""
    kind = np.array([item.orbit.kind.value for item in found], dtype=object)
    ratio = np.array([item.swing.range_ratio for item in found])
    outcome = [
        Outcome.LEFT_RANGE if item.orbit.outcome == Outcome.OK and left else item.orbit.outcome
        for item, left in zip(found, ratio > MARGIN)
    ]
    words = np.array([word.value for word in outcome], dtype=object)
    ended = "how the branch ended there, or whether the motion leaves the training range"
    rows = {
        "kind": variable("point", kind, "1", f"one of {', '.join(Kind)}"),
        "outcome": variable("point", words, "1", ended),
        "failed_at": variable("point", np.full(len(found), np.nan), "s", "unused"),
    }
    if np.isfinite(ratio).any():
        rows["range_ratio"] = variable(
            "point", ratio, "1", "largest reduced coordinate over the largest in the training data"
        )
    return rows
