"""Scene -> forced.nc: the full-order model driven from rest at its damped first frequency, and its
last period in full.
"""

import numpy as np
import xarray as xr

from vibrom.artefacts.data import label, save_dataset, variable
from vibrom.models.full_order import build, motion_outcome, probe_coordinate
from vibrom.solvers.full.newmark import Record


def run(*, structure: str, forced: str, scene: dict, provenance: dict) -> None:
    model, case = build(scene, structure), scene["forced"]
    steps = round(case["periods"] * model.steps_per_period)
    record = Record(every=model.every, start=steps - model.steps_per_period, probes=model.probes)
    motion = model.forced(
        np.array([float(case["forcing"])]),
        np.array([model.frequency]),
        steps,
        record,
        f"{model.name}: forced run",
    )
    instants, step = np.arange(0, steps + 1, model.every), model.period / model.steps_per_period
    dataset = xr.Dataset(
        {
            "probe_displacement": variable(
                ("probe", "time"),
                motion.probes[0][:, :: model.every],
                "m",
                "displacement at the probes",
            ),
            "last_displacement": variable(
                ("last_time", "dof"),
                motion.displacement[0],
                "m",
                "displacement of each free dof in the last period",
            ),
            "last_velocity": variable(
                ("last_time", "dof"),
                motion.velocity[0],
                "m s-1",
                "velocity of each free dof in the last period",
            ),
            "forcing": variable(
                (), float(case["forcing"]), "1", "forcing amplitude, times the scene's load"
            ),
            "angular_frequency": variable(
                (), model.frequency, "rad s-1", "angular frequency of the forcing"
            ),
            "period": variable((), model.period, "s", "period of the forcing"),
            **motion_outcome(motion),
        },
        coords={
            "time": variable("time", instants * step, "s", "time since the forcing began"),
            "last_time": variable(
                "last_time",
                motion.kept * step,
                "s",
                "time since the forcing began, in the last period",
            ),
            "probe": probe_coordinate(model),
        },
    )
    save_dataset(
        label(dataset, "forced", scene=model.name, method="full_order"), forced, provenance
    )
