"""Release state -> train.nc or test.nc: the decaying motion of the full-order model, let go at
rest.

Velocity and acceleration are the integrator's, or differences of the displacements as for measured
data (`decay.derivatives`).
"""

import numpy as np
import xarray as xr

from vibrom.artefacts.data import label, open_dataset, save_dataset, variable
from vibrom.models.full_order import build, motion_outcome, probe_coordinate
from vibrom.models.recorded import differences
from vibrom.solvers.full.newmark import Record


def run(
    *, structure: str, release: str, trajectory: str, scene: dict, role: str, provenance: dict
) -> None:
    model = build(scene, structure)
    start = open_dataset(release, "release")["displacement"].sel(role=role).values
    steps = round(scene["decay"]["periods"] * model.steps_per_period)
    record = Record(probes=model.probes)
    motion = model.run(
        start[:, None],
        np.array([model.period / model.steps_per_period]),
        steps,
        record,
        f"{model.name}: decay for {role}",
    )
    time, probes = motion.kept * model.period / model.steps_per_period, motion.probes[0]
    q, v, a = motion.displacement[0], motion.velocity[0], motion.acceleration[0]
    derivatives = scene["decay"].get("derivatives", "differences")
    if derivatives == "differences":
        v, a = differences(q, model.period / model.steps_per_period)
        time, q, probes = time[3:-3], q[3:-3], probes[:, 3:-3]
    dims, kept = ("time", "dof"), slice(None, None, model.every)
    dataset = xr.Dataset(
        {
            "displacement": variable(dims, q[kept], "m", "displacement of each free dof"),
            "velocity": variable(dims, v[kept], "m s-1", "velocity of each free dof"),
            "acceleration": variable(dims, a[kept], "m s-2", "acceleration of each free dof"),
            "probe_displacement": variable(
                ("probe", "time"), probes[:, kept], "m", "displacement at the probes"
            ),
            "period": variable((), model.period, "s", "period of the damped first mode"),
            **motion_outcome(motion),
        },
        coords={
            "time": variable("time", time[kept], "s", "time since release"),
            "probe": probe_coordinate(model),
        },
    )
    save_dataset(
        label(
            dataset,
            "trajectory",
            scene=model.name,
            method="full_order",
            role=role,
            derivatives=derivatives,
            iterations=motion.iterations,
            factorisations=motion.factorisations,
        ),
        trajectory,
        provenance,
    )
