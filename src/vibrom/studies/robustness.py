"""Robustness: far from the training data, for long, integrated loosely, with and without guards.

Of a fitted model see `parts.robustness_model`, of the full order `parts.robustness_full_order`.
"""

from dataclasses import dataclass
from typing import Annotated

from msgspec import Meta

from vibrom.config.kinds import Count, Fraction, Name, NonNegative, Positive, Several, TimeScheme
from vibrom.models.rollout import Integrator
from vibrom.models.rom import Guards
from vibrom.studies import Study


@dataclass(frozen=True)
class Frequencies:
    """Multiples of the damped first frequency."""

    lowest: Positive
    highest: Positive
    count: Count  # from the lowest to the highest


@dataclass(frozen=True)
class Scheme:
    """A time integration of the full-order model."""

    alpha: Fraction = 0.0  # numerical damping: gamma = 1/2 + alpha
    scheme: TimeScheme = "newmark"
    iterations: Count = 25  # of Newton, a step, at most


@dataclass(frozen=True)
class FullOrder:
    """Coarse steps and schemes of the full-order model."""

    steps_per_period: Several[Annotated[int, Meta(ge=4)]]
    schemes: Annotated[list[Scheme], Meta(min_length=1)]
    forcing: Several[NonNegative]  # times the scene's own
    periods: Count
    every_frequency: Count  # every n-th frequency of the scene's response curve


@dataclass(frozen=True)
class Robustness(Study):
    """The grid of runs."""

    # of one and the same fitted model; the first is what the others are compared with
    guards: Annotated[dict[Name, Guards], Meta(min_length=1)]
    # the first one for every guard, the others with the first guard
    integrators: Annotated[dict[Name, Integrator], Meta(min_length=1)]
    forcing: Annotated[list[NonNegative], Meta(min_length=1)]  # times the scene's own
    frequency: Frequencies  # of the forced runs
    periods: Count
    releases: Count  # random states that are released, and as many that are forced
    beyond: Positive  # how far out they lie at most, divided by the training range
    full_order: FullOrder

    jobs = {"scene": "robustness", "model": "robustness"}
    reads = {
        "scene": ("full_order/frc",),
        "model": (
            "full_order/train",
            "full_order/test",
            "full_order/forced",
            "full_order/frc",
            "decay",
            "forced",
            "frc",
            "eigenvalues",
        ),
    }
    experiments = ("decay", "forced", "frc", "eigenvalues")
    settings = {
        "scene": ("full_order",),
        "model": (
            "guards",
            "integrators",
            "forcing",
            "frequency",
            "periods",
            "releases",
            "beyond",
        ),
    }
    parts = {
        "scene": "studies.parts.robustness_full_order",
        "model": "studies.parts.robustness_model",
    }
