"""Backbone of the forced motions: frequency and damping against amplitude, at phase resonance.

Where the displacement along the load lags it by a quarter of a period, the load replaces what
damping takes, and the body moves as it would without both. That motion is followed as the forcing
grows. Its work in a period, W, gives the damping ratio zeta = W/(2 Omega int v'Mv dt). One row is
one periodic motion. Sources: see `solvers/periodic/resonance.py`; the experiment `backbone` reads
the same curve from a decay.
"""

import time
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from scipy.sparse import csr_matrix

from vibrom.artefacts.data import variable
from vibrom.artefacts.outcome import Outcome
from vibrom.artefacts.progress import bar
from vibrom.config.kinds import Count, Positive, Turn
from vibrom.experiments import Experiment, Given
from vibrom.models.measures import backbone_error, periodic, response_variables
from vibrom.models.model import Model
from vibrom.models.recorded import structure
from vibrom.models.training import Unsupported
from vibrom.solvers.periodic.continuation import Lost
from vibrom.solvers.periodic.equations import prepare
from vibrom.solvers.periodic.maps import ReturnMap
from vibrom.solvers.periodic.resonance import Backbone, backbone, damping_ratio


@dataclass(frozen=True)
class Resonance(Experiment):
    """All amplitudes of the forcing up to a largest one."""

    forcing: Positive  # largest amplitude, times the scene's load
    points: Count = 60  # at most
    turn: Turn = 0.25  # rad, that the curve may turn between two points

    scores = {"frequency_error_percent": "percent", "damping_error_percent": "percent"}
    truth = "resonance"
    where_set = True
    job = "curves"

    def brief(self) -> "Resonance":
        """A few points."""
        return replace(self, points=3)

    def ask(self, model: Model, given: Given) -> xr.Dataset:
        """Frequency, amplitude and damping of each motion."""
        known = structure(given.structure)
        if known is None:
            raise Unsupported("the mass, which tells the damping, is not known in this scene")
        flow = model.return_map()
        prepare(flow, flow.frequency)
        began = time.perf_counter()
        title = f"{given.title}resonance, at most {self.points} motions"
        with bar(title, self.points, "motions") as heard:
            try:
                found = backbone(flow, float(self.forcing), self.points, self.turn, heard)
            except Lost:
                found = None
        rows = _nothing(len(given.probe)) if found is None else _rows(flow, found, known.mass)
        rows["seconds"] = variable(
            (), time.perf_counter() - began, "s", "wall time of the computation, loading excluded"
        )
        return xr.Dataset(rows, coords={"probe": given.probe})

    def score(self, answer: xr.Dataset, truth: xr.Dataset) -> dict[str, float]:
        """Errors at the first probe, over the amplitudes that both reach."""

        def error(name: str) -> float:
            curves = [(item["amplitude"].values[0], item[name].values) for item in (answer, truth)]
            known = [np.isfinite(curve).all(axis=0) for curve in curves]
            return backbone_error(
                *(tuple(part[kept] for part in one) for one, kept in zip(curves, known))
            )

        return {
            "frequency_error_percent": error("angular_frequency"),
            "damping_error_percent": error("damping_ratio"),
        }


def _rows(flow: ReturnMap, found: Backbone, mass: csr_matrix) -> dict[str, xr.Variable]:
    """One entry a motion."""
    forcing = np.array([orbit.p for orbit in found.orbits])
    drives = [found.problem.drive(orbit.point.x) for orbit in found.orbits]
    x, frequency = (np.array(part) for part in zip(*drives))
    damping = [damping_ratio(flow, mass, *drive) for drive in zip(x, frequency, forcing)]
    largest = np.array([np.abs(orbit.multipliers).max() for orbit in found.orbits]) ** flow.parts
    swing = np.stack([item.displacement for item in flow.swings(x, frequency, forcing)], axis=1)
    numbers = np.stack([frequency, forcing, damping, largest])
    return _variables(numbers, swing, [orbit.outcome for orbit in found.orbits])


def _nothing(probes: int) -> dict[str, xr.Variable]:
    """A row without a motion."""
    return _variables(np.full((4, 1), np.nan), np.full((probes, 1, 4), np.nan), [Outcome.LOST])


def _variables(
    numbers: np.ndarray,  # (4, m) frequency, forcing, damping ratio, largest multiplier
    swing: np.ndarray,  # (k, m, samples) m
    outcome: list[Outcome],
) -> dict[str, xr.Variable]:
    """What an artefact keeps."""
    frequency, forcing, damping, largest = numbers
    words = np.array([one.value for one in outcome], dtype=object)
    return {
        "angular_frequency": variable("point", frequency, "rad s-1", "angular frequency"),
        "forcing": variable("point", forcing, "1", "amplitude, times the scene's load"),
        "damping_ratio": variable("point", damping, "1", "damping ratio"),
        "multiplier_largest": variable(
            "point", largest, "1", "size of the largest Floquet multiplier"
        ),
        **response_variables(("probe", "point"), periodic(swing)),
        "outcome": variable("point", words, "1", "how the curve ended there"),
        "failed_at": variable("point", np.full(len(words), np.nan), "s", "unused"),
    }
