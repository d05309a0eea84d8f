"""Scene -> release.nc: the shapes from which the body is let go.

Each is the displacement of a run forced from rest at the damped first frequency, at the step that
the scene names.
"""

import numpy as np
import xarray as xr

from vibrom.artefacts.data import DataError, label, save_dataset, variable
from vibrom.models.full_order import build
from vibrom.solvers.full.newmark import Record

ROLES = ("train", "test")


def run(*, structure: str, release: str, scene: dict, provenance: dict) -> None:
    model = build(scene, structure)
    at = [scene["releases"][role]["step"] for role in ROLES]
    forcing = np.array([scene["releases"][role]["forcing"] for role in ROLES], float)
    shapes = np.empty((len(ROLES), model.space.size))
    for index in range(len(ROLES)):
        # Only the last step is kept; each run stops where its shape is.
        motion = model.forced(
            forcing[[index]],
            np.array([model.frequency]),
            at[index],
            Record(start=at[index]),
            f"{model.name}: release state {ROLES[index]}",
        )
        if motion.outcomes[0] != "ok":
            raise DataError(
                f"releases.{ROLES[index]}: the forced run stops at {motion.failed_at[0]:.4g} s (no convergence); "
                f"lower releases.{ROLES[index]}.forcing = {forcing[index]:g} or raise time.steps_per_period"
            )
        shapes[index] = motion.displacement[0, 0]
    dataset = xr.Dataset(
        {
            "displacement": variable(
                ("role", "dof"), shapes, "m", "displacement of the release state"
            )
        },
        coords={
            "role": variable(
                "role", np.array(ROLES, dtype=object), "1", "trajectory that starts here"
            )
        },
    )
    save_dataset(
        label(
            dataset, "release", scene=model.name, method="full_order", releases=scene["releases"]
        ),
        release,
        provenance,
    )
