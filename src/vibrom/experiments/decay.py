"""An unseen decay: the model starts where the full-order model starts and is left alone.

Source: thesis, section 3.3.1. Values after a failure are NaN.
"""

import time

import numpy as np
import xarray as xr

from vibrom.artefacts.data import outcome_variables, scored, variable
from vibrom.models.measures import nmte_percent
from vibrom.models.recorded import trajectory
from vibrom.models.rollout import Integrator, decode_displacement, rollout

needs = ("structure", "rom", "test")
full_order = None
scores = {"nmte_percent": "percent"}


def predict(artefacts: dict, integrator: Integrator) -> xr.Dataset:
    rom, truth, probes = (
        artefacts["rom"],
        trajectory(artefacts["test"]),
        artefacts["structure"]["probe_dof"],
    )
    encoded = rom.encode(truth.state)
    began = time.perf_counter()
    run = rollout(rom, encoded[:1], (truth.time - truth.time[0])[None], integrator)
    displacement = decode_displacement(rom, run.reduced[0])
    seconds = time.perf_counter() - began
    error = np.linalg.norm(truth.displacement - displacement, axis=1)
    dataset = xr.Dataset(
        {
            "error": variable("time", error, "m", "norm of the displacement error"),
            "reduced": variable(
                ("time", "coordinate"), run.reduced[0], "1", "reduced coordinates of the model"
            ),
            "encoded": variable(
                ("time", "coordinate"), encoded, "1", "reduced coordinates of the true trajectory"
            ),
            "probe_displacement": variable(
                ("probe", "time"),
                displacement[:, probes.values].T,
                "m",
                "displacement of the model at the probes",
            ),
            "probe_true": variable(
                ("probe", "time"),
                truth.displacement[:, probes.values].T,
                "m",
                "true displacement at the probes",
            ),
            "range_ratio": variable(
                (),
                run.range_ratio[0],
                "1",
                "largest reduced coordinate over the largest in the training data",
            ),
            **outcome_variables(run.outcome[0], run.failed_at[0], seconds),
        },
        coords={
            "time": variable("time", truth.time, "s", "time since release"),
            "probe": probes["probe"].variable,
        },
    )
    return scored(dataset, {"nmte_percent": nmte_percent(error, truth.displacement)}, scores)
