"""Release state -> train.nc or test.nc: the recorded decay of the full-order model, released at
rest.

Velocity and acceleration are the integrator's, or differences of the displacements as for measured
data (`record.derivatives`).
"""

from typing import Any

import numpy as np
import xarray as xr

from vibrom.artefacts.data import (
    label,
    open_dataset,
    outcome_variables,
    save_dataset,
    variable,
)
from vibrom.config.places import FULL_ORDER
from vibrom.config.scene import Record, Time
from vibrom.models.full_order import FullOrder
from vibrom.models.recorded import differences
from vibrom.solvers.full.newmark import Record as Kept


def run(
    *,
    structure: str,
    release: str,
    trajectory: str,
    scene: dict[str, Any],
    role: str,
    provenance: dict[str, str],
) -> None:
    """`scene` has the blocks `body`, `effects`, `record` and `time`."""
    known = open_dataset(structure, "structure")
    model, record = FullOrder.of_scene(scene, known), Record.from_builtins(scene["record"])
    shape = open_dataset(release, "release")["displacement"].sel(role=role).values
    step, steps = model.period / model.steps_per_period, record.periods * model.steps_per_period
    start = np.concatenate([shape, np.zeros_like(shape)])[None]
    keep = Kept(probes=model.probes)
    motion = model.run(start, np.array([step]), steps, keep, None)
    time, probes = motion.kept * step, motion.probes[0]
    q, v, a = motion.displacement[0], motion.velocity[0], motion.acceleration[0]
    if record.derivatives == "differences":
        v, a = differences(q, step)
        time, q, probes = time[3:-3], q[3:-3], probes[:, 3:-3]
    dims = ("time", "dof")
    kept = slice(None, None, Time.from_builtins(scene["time"]).every)
    dataset = xr.Dataset(
        {
            "displacement": variable(dims, q[kept], "m", "displacement of each free dof"),
            "velocity": variable(dims, v[kept], "m s-1", "velocity of each free dof"),
            "acceleration": variable(dims, a[kept], "m s-2", "acceleration of each free dof"),
            "probe_displacement": variable(
                ("probe", "time"), probes[:, kept], "m", "displacement at the probes"
            ),
            "period": variable((), model.period, "s", "period of the damped first mode"),
            **outcome_variables(motion.outcomes[0], motion.failed_at[0], motion.seconds),
        },
        coords={
            "time": variable("time", time[kept], "s", "time since release"),
            "probe": known["probe"].variable,
        },
    )
    dataset = label(
        dataset,
        "trajectory",
        scene=str(known.attrs["scene"]),
        method=FULL_ORDER,
        role=role,
        derivatives=record.derivatives,
        iterations=motion.iterations,
        factorisations=motion.factorisations,
    )
    save_dataset(dataset, trajectory, provenance)
