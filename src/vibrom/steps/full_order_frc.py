"""Scene -> frc.nc: the full-order forced response curve, every frequency from rest, states side by
side.
"""

import numpy as np
import xarray as xr

from vibrom.artefacts.data import label, save_dataset, variable
from vibrom.models.full_order import build, probe_coordinate
from vibrom.models.measures import amplitude_and_phase
from vibrom.solvers.full.newmark import Record


def run(*, structure: str, frc: str, scene: dict, provenance: dict) -> None:
    model, case = build(scene, structure), scene["frc"]
    frequency = np.linspace(case["from"], case["to"], case["frequencies"]) * model.frequency
    steps, last = round(case["periods"] * model.steps_per_period), model.steps_per_period
    record = Record(start=steps + 1, probes=model.probes, probe_start=steps - last + 1)
    motion = model.forced(
        np.full(len(frequency), float(case["forcing"])),
        frequency,
        steps,
        record,
        f"{model.name}: response curve",
    )
    # The last period holds the instants t = h, 2h, ... T of a period; its end is also its
    # beginning.
    amplitude, phase = amplitude_and_phase(np.roll(motion.probes, 1, axis=-1))
    dims = ("probe", "angular_frequency")
    dataset = xr.Dataset(
        {
            "amplitude": variable(
                dims, amplitude.T, "m", "largest displacement of the last period"
            ),
            "phase": variable(
                dims, phase.T, "rad", "phase of the first harmonic relative to the forcing"
            ),
            "outcome": variable(
                "angular_frequency",
                np.array(motion.outcomes, dtype=object),
                "1",
                "how the run ended",
            ),
            "failed_at": variable(
                "angular_frequency", motion.failed_at, "s", "simulated time at which the run failed"
            ),
            "forcing": variable(
                (), float(case["forcing"]), "1", "forcing amplitude, times the scene's load"
            ),
            "seconds": variable(
                (),
                motion.seconds,
                "s",
                "wall time of the whole curve, loading and compilation excluded",
            ),
        },
        coords={
            "angular_frequency": variable(
                "angular_frequency", frequency, "rad s-1", "angular frequency of the forcing"
            ),
            "probe": probe_coordinate(model),
        },
    )
    save_dataset(
        label(dataset, "frc", scene=model.name, method="full_order", periods=case["periods"]),
        frc,
        provenance,
    )
