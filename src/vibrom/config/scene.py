"""A scene: a body, the effects that act on it, and what is recorded and asked of it.

The settings of bodies, effects and experiments are declared by their own files; here they are plain
mappings, complete and checked.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from vibrom.config.kinds import (
    Count,
    Direction,
    Fraction,
    Name,
    Positive,
    Step,
    Steps,
    TimeScheme,
    Tolerance,
)

Role = Literal["train", "test"]
# Effects add up in this order, whatever the order of their keys, those of one stage by their names:
# each says by `STAGE` what it adds, and may read the sum of what comes before.
STAGES = ("mass", "stiffness", "forces", "dead_load", "damping", "load")
SHAPE = "rectangle"  # of a body that does not say
USUAL_STAGE = "forces"  # of an effect that does not say


def shape_of(body: Any) -> Any:
    """The file of src/vibrom/bodies of a scene's `body` block: what it says, `mesh` of one that
    names a mesh, else a rectangle.
    """
    return body.get("shape", "mesh" if "mesh" in body else SHAPE)


class Block(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings that stand together under one key."""

    @classmethod
    def from_builtins(cls, plain: dict[str, Any]):
        """From what `to_builtins` gives: the parameter of a rule."""
        return msgspec.convert(plain, cls)

    def to_builtins(self) -> dict[str, Any]:
        """Plain mappings, lists, numbers and text; defaults are written out, None left out."""
        plain = msgspec.to_builtins(self)
        return {key: value for key, value in plain.items() if value is not None}


class Sweep(Block, frozen=True):
    """A forced run from rest whose frequency is changed in steps, the motion carried on."""

    # times the damped first frequency, in the order in which they are driven
    frequencies: Annotated[tuple[Positive, ...], Meta(min_length=1)]
    periods: Count  # of the forcing, at each frequency


class Velocity(Block, frozen=True):
    """At the start: of all that can move, along an axis, or in the shape of a mode. One of
    `direction` and `mode` is given.
    """

    speed: float  # m/s, of every point; in the shape of a mode, of the first probe
    direction: Direction | None = None
    mode: Count | None = None  # counted from one


class Release(Block, frozen=True):
    """Where a decay starts: a displacement of a forced run, or the one that the load holds, at rest
    or with a velocity. One of `step`, `sweep` and `static` is given with a `forcing`; with a
    `velocity` none is needed.
    """

    forcing: Positive | None = None  # amplitude, as a multiple of the load
    # the displacement at this time step of a run from rest at the damped first frequency
    step: Step | None = None
    # the turning point, on the load's side, of the last period of this run
    sweep: Sweep | None = None
    static: bool = False  # the equilibrium under the load itself
    velocity: Velocity | None = None  # none: at rest


class Record(Block, frozen=True):
    """What is recorded of a decay."""

    periods: Count  # of the damped first mode
    # of velocity and acceleration: differences of the displacements, or the integrator's own
    derivatives: Literal["differences", "integrator"] = "differences"
    # time steps of the converged test decay to each of the scene's; 0: there is none
    finer: Annotated[int, Meta(ge=0, multiple_of=2)] = 2
    balance: Tolerance = 0.01  # relative error of energy, work and losses
    # of the numbers in the file: float32 takes half the space, rounds them to 6e-8 of their size,
    # and the artefact says what that cost
    stored: Literal["float64", "float32"] = "float64"


class Time(Block, frozen=True):
    """The time integration of the full-order model."""

    steps_per_period: Steps  # time steps in one period of the first mode
    every: Count  # store every n-th step
    alpha: Fraction  # numerical damping: gamma = 1/2 + alpha, beta = (1 + alpha)^2/4
    # relative residual of a converged step; rounding in stiff bodies allows no less than about 1e-9
    residual: Annotated[float, Meta(ge=1e-8, le=0.1)]
    initial_acceleration: Literal["zero", "equilibrium"]
    scheme: TimeScheme = "newmark"
    iterations: Count = 25  # of Newton, a step, at most


class Scene(Block, frozen=True):
    """One file of config/scenes."""

    name: Name  # the file's
    description: str
    body: dict[str, Any]  # `shape`, a file of src/vibrom/bodies, and its settings
    # settings, by effect; a list of them where one acts more than once
    effects: dict[str, list[dict[str, Any]] | dict[str, Any]]
    releases: Annotated[dict[Role, Release], Meta(min_length=2)]  # where the decays start
    record: Record  # what is recorded of a decay
    time: Time  # the time integration of the full-order model
    experiments: dict[str, dict[str, Any]] = {}  # settings, by experiment
