"""What accuracy costs in time: settings of the full-order model and of the methods are varied.

Each setting has an error against a reference, and the seconds that it takes: see
`parts.cost_full_order` and `parts.cost_reduced`.
"""

from dataclasses import dataclass
from typing import Annotated, Any, Literal

from msgspec import Meta

from vibrom.config.kinds import (
    Cells,
    Count,
    Distinct,
    Element,
    Fraction,
    Name,
    NonNegative,
    Several,
    TimeScheme,
)
from vibrom.studies import Study

Residual = Annotated[float, Meta(ge=1e-10, le=0.1)]
Steps = Annotated[int, Meta(ge=50, multiple_of=50)]
Meshes = Distinct[Cells]


@dataclass(frozen=True)
class Scheme:
    """A time integration of the full-order model."""

    alpha: Fraction  # numerical damping
    initial_acceleration: Literal["zero", "equilibrium"]
    scheme: TimeScheme = "newmark"
    iterations: Count = 25  # of Newton, a step, at most
    # time steps in one period of the first mode; null: those of all schemes
    steps_per_period: Several[Steps] | None = None


@dataclass(frozen=True)
class Reference:
    """The converged run, also made with two and four times its step, which tells its own error."""

    # time steps in one period of the first mode, of which a quarter is a multiple of 50
    steps_per_period: Annotated[int, Meta(ge=200, multiple_of=200)]
    residual: Residual  # relative, of a converged step


@dataclass(frozen=True)
class Mesh:
    """The mesh that others are compared with."""

    element: Element
    cells: Cells  # along the length, over the height


@dataclass(frozen=True)
class FullOrder:
    """What is varied of the full-order model."""

    schemes: list[Scheme]
    steps_per_period: Several[Steps]  # time steps in one period of the first mode
    residuals: Several[Residual]  # relative, of a converged step
    forced_periods: Count  # periods of the forced run
    reference: Reference
    meshes: dict[Element, Meshes]  # cells along the length and over the height, by element
    reference_mesh: Mesh
    mesh_periods: Count  # periods of the forced run on each mesh
    mesh_steps_per_period: Steps  # time steps in one period of the first mode


@dataclass(frozen=True)
class Sweep:
    """Settings of a method that are varied together."""

    vary: Several[str]  # settings of the method, thin, periods, rtol, or start.<setting>
    over: Several[Any]  # each is given to all of `vary`, one after the other


@dataclass(frozen=True)
class Cost(Study):
    """What is varied, and how often a time is taken."""

    repeats: Count  # a time is the median of so many runs
    patience: NonNegative  # s; what took longer in all is not repeated
    full_order: FullOrder
    reduced: dict[Name, list[Sweep]]  # by method

    jobs = {"scene": "cost_full_order", "models": "cost_reduced"}
    reads = {
        "scene": ("full_order/release",),
        "models": (
            "full_order/train",
            "full_order/test",
            "full_order/forced",
            "full_order/frc",
            "decay",
            "forced",
            "frc",
        ),
    }
    experiments = ("decay", "forced", "frc")
    settings = {
        "scene": ("repeats", "patience", "full_order"),
        "models": ("repeats", "patience", "reduced"),
    }
    parts = {
        "scene": "studies.parts.cost_full_order",
        "models": "studies.parts.cost_reduced",
    }
