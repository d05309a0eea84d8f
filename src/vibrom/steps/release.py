"""Scene -> release.nc: the shapes, and velocities, from which the body is released.

A shape is the displacement of a run forced from rest: at the damped first frequency, at the step
that the scene names; or, of a run whose frequency is changed in steps, at the turning point of its
last period; or the equilibrium under the load. A sweep reaches motions that a run from rest never
shows. A velocity is that of all points along an axis, or has the shape of a mode.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from vibrom.artefacts.data import DataError, label, open_dataset, save_dataset, variable
from vibrom.artefacts.outcome import Outcome
from vibrom.bodies.space import AXES
from vibrom.config.places import FULL_ORDER
from vibrom.config.scene import Release, Sweep, Velocity
from vibrom.models.full_order import FullOrder
from vibrom.models.model import Drive, Watch
from vibrom.solvers.full.newmark import Motion, Record
from vibrom.solvers.full.static import NoEquilibrium, equilibrium

ROLES = ("train", "test")
STILL = 1e-3  # of a mode's largest displacement: a probe that moves less shows no speed


def run(*, structure: str, release: str, scene: dict[str, Any], provenance: dict[str, str]) -> None:
    """`scene` has the blocks `body`, `effects`, `releases` and `time`."""
    known = open_dataset(structure, "structure")
    model = FullOrder.of_scene(scene, known)
    shapes, velocities, legs = [], [], {}
    for role in ROLES:
        recipe = Release.from_builtins(scene["releases"][role])
        shapes.append(displaced(model, role, recipe, legs))
        velocities.append(thrown(model, role, recipe.velocity, known["mode_shape"].values))
    dataset = xr.Dataset(
        {
            "displacement": variable(
                ("role", "dof"), np.array(shapes), "m", "displacement of the release state"
            )
        },
        coords={
            "role": variable(
                "role", np.array(ROLES, dtype=object), "1", "trajectory that starts here"
            )
        },
    )
    if np.any(velocities):
        dataset["velocity"] = variable(
            ("role", "dof"), np.array(velocities), "m s-1", "velocity of the release state"
        )
    dataset = label(
        dataset,
        "release",
        scene=str(known.attrs["scene"]),
        method=FULL_ORDER,
        releases=scene["releases"],
    )
    save_dataset(dataset, release, provenance)


def displaced(model: FullOrder, role: str, recipe: Release, legs: dict) -> np.ndarray:
    """(n,) [m] from the rest state; `legs` as of `turning_point`. Raises DataError where there is
    none.
    """
    if recipe.forcing is None:
        return np.zeros(model.size)
    if recipe.static:
        return held(model, role, recipe.forcing)
    if recipe.sweep is not None:
        return turning_point(model, role, recipe.forcing, recipe.sweep, legs)
    return at_step(model, role, recipe.forcing, recipe.step)


def thrown(model: FullOrder, role: str, velocity: Velocity | None, modes: np.ndarray) -> np.ndarray:
    """(n,) [m/s]; `modes` (k, n) are shapes. Raises DataError where it would be none."""
    if velocity is None:
        return np.zeros(model.size)
    where = f"releases.{role}.velocity"
    if velocity.direction is not None:
        shape = np.asarray(model.axis == AXES.index(velocity.direction), float)
        if not shape.any():
            raise DataError(
                f"{where}.direction = {velocity.direction!r} is none in which the body moves; "
                "choose another"
            )
        return velocity.speed * shape
    if velocity.mode > len(modes):
        raise DataError(
            f"{where}.mode = {velocity.mode} is not known; choose one of the first {len(modes)}"
        )
    shape = modes[velocity.mode - 1]
    seen = shape[model.probes[0]]
    if abs(seen) < STILL * np.abs(shape).max():
        raise DataError(
            f"{where}.mode = {velocity.mode} does not move the first probe, whose speed is given; "
            "put another probe first"
        )
    return velocity.speed / seen * shape


def held(model: FullOrder, role: str, forcing: float) -> np.ndarray:
    """(n,) [m] in equilibrium under the load. Raises DataError where none is found."""
    try:
        return equilibrium(model.term, forcing, start=model.rest) - model.rest
    except NoEquilibrium as error:
        raise DataError(f"releases.{role}.forcing = {forcing:g} is not held: {error}") from error


def at_step(model: FullOrder, role: str, forcing: float, step: int) -> np.ndarray:
    """(n,) [m] at this step. Raises DataError where the run stops before it."""
    drive = Drive(np.array([forcing]), np.array([model.frequency]))
    instant = np.array([step * model.period / model.steps_per_period])
    motion = model.motion(np.zeros((1, 2 * model.size)), drive, Watch(instant))
    if motion.outcome[0] != Outcome.OK:
        raise stopped(role, forcing, motion.failed_at[0])
    return motion.displacement[0][0, 0]


def turning_point(
    model: FullOrder, role: str, forcing: float, sweep: Sweep, legs: dict[tuple, Motion]
) -> np.ndarray:
    """(n,) [m] where the last period of a sweep is slowest, among its states on the load's side.
    Raises DataError where the run stops before. `legs`: see `swept`.
    """
    motion = swept(model, role, forcing, sweep, legs)
    q, v = motion.displacement[0], motion.velocity[0]
    along = q @ model.term.load > 0.0
    speed = np.where(along, np.linalg.norm(v, axis=1), np.inf)
    return q[speed.argmin()]


def swept(
    model: FullOrder, role: str, forcing: float, sweep: Sweep, legs: dict[tuple, Motion]
) -> Motion:
    """The last period of a run from rest through all frequencies of a sweep. `legs` are the last
    periods at the frequencies of earlier sweeps, which may begin alike; those of this one join.
    """
    # A motion that is carried on is in equilibrium with its acceleration.
    carried, state = replace(model, initial_acceleration="equilibrium"), np.zeros(2 * model.size)
    last = (sweep.periods - 1) * model.steps_per_period
    steps, elapsed = sweep.periods * model.steps_per_period, 0.0
    for count, frequency in enumerate(sweep.frequencies, 1):
        drive = Drive(np.array([forcing]), np.array([frequency * model.frequency]))
        step = drive.period / model.steps_per_period
        leg = (forcing, sweep.periods, *sweep.frequencies[:count])
        if leg not in legs:
            legs[leg] = carried.run(state[None], step, steps, Record(start=last), drive)
        motion = legs[leg]
        if motion.outcomes[0] != Outcome.OK:
            raise stopped(role, forcing, elapsed + motion.failed_at[0])
        state = np.concatenate([motion.displacement[0, -1], motion.velocity[0, -1]])
        elapsed += steps * step[0]
    return motion


def stopped(role: str, forcing: float, instant: float) -> DataError:
    """A forced run that does not reach the release."""
    return DataError(
        f"releases.{role}: the forced run stops at {instant:.4g} s (no convergence); lower "
        f"releases.{role}.forcing = {forcing:g} or raise time.steps_per_period"
    )
