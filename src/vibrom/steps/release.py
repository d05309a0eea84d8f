"""Scene -> release.nc: the shapes from which the body is released.

Each is the displacement of a run forced from rest at the damped first frequency, at the step that
the scene names.
"""

from typing import Any

import numpy as np
import xarray as xr

from vibrom.artefacts.data import DataError, label, open_dataset, save_dataset, variable
from vibrom.artefacts.outcome import Outcome
from vibrom.config.places import FULL_ORDER
from vibrom.config.scene import Release
from vibrom.models.full_order import FullOrder
from vibrom.models.model import Drive, Watch

ROLES = ("train", "test")


def run(*, structure: str, release: str, scene: dict[str, Any], provenance: dict[str, str]) -> None:
    """`scene` has the blocks `body`, `effects`, `releases` and `time`."""
    known = open_dataset(structure, "structure")
    model = FullOrder.of_scene(scene, known)
    shapes = [shape(model, role, Release.from_builtins(scene["releases"][role])) for role in ROLES]
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
    dataset = label(
        dataset,
        "release",
        scene=str(known.attrs["scene"]),
        method=FULL_ORDER,
        releases=scene["releases"],
    )
    save_dataset(dataset, release, provenance)


def shape(model: FullOrder, role: str, release: Release) -> np.ndarray:
    """(n,) [m] at the release's step. Raises DataError where the run stops before it."""
    drive = Drive(np.array([float(release.forcing)]), np.array([model.frequency]))
    instant = np.array([release.step * model.period / model.steps_per_period])
    motion = model.motion(np.zeros((1, 2 * model.size)), drive, Watch(instant))
    if motion.outcome[0] != Outcome.OK:
        raise DataError(
            f"releases.{role}: the forced run stops at {motion.failed_at[0]:.4g} s (no "
            f"convergence); lower releases.{role}.forcing = {release.forcing:g} or raise "
            "time.steps_per_period"
        )
    return motion.displacement[0][0, 0]
