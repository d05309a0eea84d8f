"""Sweeps up and down: the frequency is changed in steps, and the motion carried on from each to the
next, as in a laboratory.

A stop lasts until the motion is steady, or for as long as is allowed: its outcome says which.
Where a curve folds, a sweep stays on the branch on which it is until that ends, and jumps; on the
way back it jumps elsewhere. A jump is bracketed by halving the last step from the motion before it.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from vibrom.artefacts.data import outcome_variables, variable
from vibrom.artefacts.outcome import Outcome
from vibrom.artefacts.progress import bar
from vibrom.config.kinds import Count, Positive, Tolerance, Whole
from vibrom.experiments import Experiment, Given
from vibrom.models.measures import curve_error, periodic, response_variables
from vibrom.models.model import Model
from vibrom.models.steady import PART, change_variable, judged
from vibrom.solvers.periodic.carried import Stay, stops, swings
from vibrom.solvers.periodic.equations import prepare
from vibrom.solvers.periodic.maps import ReturnMap

DIRECTIONS = ("up", "down")
MARGIN = 0.7  # of `steady`: what the body may change in all, so that the probes change no more
APART = 0.01  # of the larger one: amplitudes that belong to two motions
SIDES = ("before", "after")


@dataclass(frozen=True)
class Sweeps(Experiment):
    """One forcing amplitude, equal steps of the frequency."""

    forcing: Positive  # amplitude, times the scene's load
    periods: Count = 60  # at each frequency, at least
    longest: Whole = 180  # at most, where the motion still changes
    settle: Whole = 0  # more periods at the first one, which begins from rest
    frequencies: Count = 33  # from the lowest to the highest
    lowest: Positive = 0.8  # times the damped first frequency
    highest: Positive = 1.2  # times the damped first frequency
    halvings: Whole = 3  # of the step in which a jump was seen
    steady: Tolerance = 0.001  # of the amplitude: what the end of a stop may change

    scores = {
        "jumps": "1",
        "jump_up_error_percent": "percent",
        "jump_down_error_percent": "percent",
        "amplitude_error_median_percent": "percent",
        "peak_error_percent": "percent",
    }
    truth = "sweeps"
    where_set = True
    job = "curves"

    def brief(self) -> "Sweeps":
        """Two frequencies, one period each."""
        return replace(self, periods=1, longest=0, settle=0, frequencies=2)

    def ask(self, model: Model, given: Given) -> xr.Dataset:
        """Largest and smallest value of the last period at every probe, and where jumps are."""
        flow = model.return_map()
        frequency = np.linspace(self.lowest, self.highest, self.frequencies) * model.frequency
        prepare(flow, frequency[0])
        began = time.perf_counter()
        forcing = float(self.forcing)
        longest = max(self.periods, self.longest)
        stay = Stay(self.periods, longest, MARGIN * self.steady, self.settle)
        most = 2 * (self.settle + longest * self.frequencies + self.periods * self.halvings)
        with bar(f"{given.title}sweeps, at most {most} periods", most, "periods") as heard:
            up, down = (
                stops(flow, order, forcing, stay, heard) for order in (frequency, frequency[::-1])
            )
            seen = [list(zip(*row)) for row in (up, down[::-1])]
            points = [row[-1] for row in seen]
            swing = np.stack(
                [[swings(flow, row, frequency, forcing) for row in stop] for stop in zip(*seen)]
            )
            shown, changes = periodic(swing[-1]), settled(swing, self.periods)
            jumps = self._jumps(flow, frequency, points, shown.maximum[:, :, 0], heard)
        seconds = time.perf_counter() - began
        finite = np.isfinite(shown.maximum).all(axis=-1)
        ended = np.where(finite, Outcome.OK, Outcome.DIVERGED).astype(object)
        dims, point = ("direction", "angular_frequency", "probe"), "angular_frequency"
        answer = {
            **response_variables(dims, shown),
            "jump_frequency": variable(
                ("direction", "side"), jumps, "rad s-1", "frequencies between which it jumps"
            ),
            "forcing": variable((), forcing, "1", "amplitude, times the scene's load"),
            **outcome_variables(Outcome.OK, seconds=seconds),
            **change_variable(dims[:2], changes),
            "outcome": variable(
                dims[:2],
                judged(ended, changes, self.steady),
                "1",
                "how the motion ended",
            ),
        }
        coords = {
            point: variable(point, frequency, "rad s-1", "angular frequency of the forcing"),
            "probe": given.probe,
            "direction": variable("direction", np.array(DIRECTIONS, object), "1", "of the sweep"),
            "side": variable("side", np.array(SIDES, object), "1", "of a jump"),
        }
        return xr.Dataset(answer, coords=coords)

    def _jumps(
        self,
        flow: ReturnMap,
        frequency: np.ndarray,
        points: list[list[np.ndarray]],
        amplitude: np.ndarray,
        heard: Callable[[int], object],
    ) -> np.ndarray:
        """(2, 2) the frequencies before and after the jump of each direction; NaN without one."""
        found = np.full((2, 2), np.nan)
        known = np.isfinite(amplitude).all(axis=0)
        difference = np.where(known, np.abs(amplitude[0] - amplitude[1]), 0.0)
        apart = difference > APART * np.abs(amplitude[:, known]).max(initial=0.0)
        if not apart.any():
            return found
        first = last = int(np.argmax(difference))
        while first > 0 and apart[first - 1]:
            first -= 1
        while last + 1 < len(frequency) and apart[last + 1]:
            last += 1
        # After a jump the motion settles for a while, and the two sweeps still differ.
        for row, step in ((0, 1), (1, -1)):
            starts = [k for k in range(first, last + 1) if 0 <= k + step < len(frequency)]
            change = [abs(amplitude[row, k + step] - amplitude[row, k]) for k in starts]
            if starts:
                ends = np.array([0, step]) + starts[int(np.argmax(np.nan_to_num(change)))]
                given = frequency[ends], amplitude[row, ends]
                found[row] = self._halved(flow, points[row][ends[0]], *given, heard)
        return found

    def _halved(
        self,
        flow: ReturnMap,
        x: np.ndarray,
        frequency: np.ndarray,
        amplitude: np.ndarray,
        heard: Callable[[int], object],
    ) -> np.ndarray:
        """Frequencies (2,) on both sides of a jump from x, between two at which it was seen."""
        (low, high), (before, after), forcing = frequency, amplitude, float(self.forcing)
        for _ in range(self.halvings):
            middle = 0.5 * (low + high)
            ahead = flow.after(x, middle, forcing, self.periods)
            heard(self.periods)
            seen = swings(flow, [ahead], np.array([middle]), forcing)[0, 0].max()
            if abs(seen - before) < abs(seen - after):
                low, x, before = middle, ahead, seen
            else:
                high = middle
        return np.array([low, high])

    def score(self, answer: xr.Dataset, truth: xr.Dataset) -> dict[str, float]:
        """Errors of the jumps, and of the amplitude at the first probe."""
        amplitude, true = (item["amplitude"].values[..., 0].ravel() for item in (answer, truth))
        error = curve_error(amplitude, true)
        jumps, true_jumps = (item["jump_frequency"].values.mean(axis=1) for item in (answer, truth))
        off = [_off(one, other) for one, other in zip(jumps, true_jumps)]
        return {
            "jumps": float(np.isfinite(jumps).sum()),
            "jump_up_error_percent": off[1],  # of the amplitude, on the way down
            "jump_down_error_percent": off[0],
            "amplitude_error_median_percent": error.median_percent,
            "peak_error_percent": error.peak_percent,
        }


def settled(swing: np.ndarray, periods: int) -> np.ndarray:
    """(2, k) how far the last period's motion differs from earlier ones, over its amplitude, of
    (earlier ones + 1, 2, k, probes, samples) [m]; NaN after too few periods.
    """
    if periods < PART:
        return np.full(swing.shape[1:3], np.nan)
    with np.errstate(invalid="ignore", divide="ignore"):
        apart = np.abs(swing[:-1] - swing[-1]).max(axis=(0, 3, 4))
        return apart / np.abs(swing[-1]).max(axis=(2, 3))


def _off(one: float, other: float) -> float:
    """Of a frequency, in percent; zero where neither curve jumps, infinite where only one does."""
    if np.isnan(one) and np.isnan(other):
        return 0.0
    return float(100.0 * (one / other - 1.0)) if np.isfinite(one * other) else float("inf")
