"""Robustness tests: what the seeds of a model answered with one guard and integrator."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
import xarray as xr

from vibrom.artefacts.outcome import Outcome
from vibrom.models.measures import curve_error
from vibrom.report.collection import FULL_ORDER, Collection
from vibrom.report.scores import spread

# How a run of the grid can end. With any other outcome there was no model, or no such guard.
ENDINGS = (
    Outcome.OK,
    Outcome.LEFT_RANGE,
    Outcome.DIVERGED,
    Outcome.STEP_UNDERFLOW,
    Outcome.NO_CONVERGENCE,
)


class Group(NamedTuple):
    """One scene, model, guard and integrator."""

    scene: str
    method: str
    guard: str
    integrator: str
    first: bool  # is this the integrator with which every guard is evaluated?
    answers: list[xr.Dataset]  # of each seed

    @property
    def identity(self) -> dict[str, str]:
        """As the first cells of a row."""
        return {
            "case": self.scene,
            "method": self.method,
            "guard": self.guard,
            "integrator": self.integrator,
        }

    @property
    def amplitudes(self) -> list[np.ndarray]:
        """Of each seed's response curve [m]."""
        return [answer["frc_amplitude"].values for answer in self.answers]


def groups(collection: Collection) -> Iterator[Group]:
    """All pairs of guard and integrator that were evaluated."""
    for scene in collection.scenes:
        for method in collection.methods:
            seeds = collection.every(scene, method, "robustness")
            found = [answer for answer in seeds if answer is not None]
            for guard in found[0]["guard"].values if found else ():
                for place, integrator in enumerate(found[0]["integrator"].values):
                    chosen = [answer.sel(guard=guard, integrator=integrator) for answer in found]
                    if any(ended is not Outcome.NOT_RUN for ended in endings(chosen)):
                        yield Group(scene, method, str(guard), str(integrator), place == 0, chosen)


def endings(answers: Iterable[xr.Dataset], name: str = "outcome") -> list[Outcome]:
    """Of all runs."""
    return [Outcome(str(word)) for answer in answers for word in answer[name].values.ravel()]


def evaluated(answer: xr.Dataset) -> bool:
    """Was there a model, with this guard, to evaluate?"""
    return any(ended in ENDINGS for ended in endings([answer]))


def curve(collection: Collection, group: Group) -> dict[str, float]:
    """The scene's response curve by the models of a group against the full order's: points, points
    with a value, and over seeds the median amplitude error, the error of the peak and its place.
    """
    truth = collection.find(group.scene, FULL_ORDER, "frc")["amplitude"].values[0]
    errors = [curve_error(amplitude, truth) for amplitude in group.amplitudes]
    return {
        "points": len(truth) * len(errors),
        "points_with_value": sum(error.completed for error in errors),
        **spread((e.median_percent for e in errors), worst=True).columns(
            "median_amplitude_error_percent"
        ),
        **spread((e.peak_percent for e in errors), worst=False).columns("peak_error_percent"),
        **spread((e.peak_steps for e in errors), worst=False).columns("peak_steps"),
    }


def guarded(collection: Collection, scene: str, method: str, guard: str) -> dict | None:
    """`curve` of a model with a guard and the first integrator; None where it was not evaluated."""
    for group in groups(collection):
        if (group.scene, group.method, group.guard) == (scene, method, guard) and group.first:
            found = curve(collection, group)
            return found | {
                "points_without_value": float(found["points"] - found["points_with_value"])
            }
    return None
