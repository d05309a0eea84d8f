"""How well the model's own coordinates describe an unseen decay:  q against the displacement of
decode(encode(q, v)).

No dynamics is asked. Source: thesis, section 3.2.3.
"""

import time

import numpy as np
import xarray as xr

from vibrom.artefacts.data import outcome_variables, scored, variable
from vibrom.models.measures import nmte_percent
from vibrom.models.recorded import trajectory
from vibrom.models.rollout import Integrator, decode_displacement

needs = ("structure", "rom", "test")
full_order = None
scores = {"nmte_percent": "percent"}


def predict(artefacts: dict, integrator: Integrator) -> xr.Dataset:
    rom, truth = artefacts["rom"], trajectory(artefacts["test"])
    began = time.perf_counter()
    encoded = rom.encode(truth.state)
    error = np.linalg.norm(truth.displacement - decode_displacement(rom, encoded), axis=1)
    dataset = xr.Dataset(
        {
            "error": variable("time", error, "m", "norm of the displacement error"),
            "encoded": variable(
                ("time", "coordinate"), encoded, "1", "reduced coordinates of the true trajectory"
            ),
            **outcome_variables("ok", seconds=time.perf_counter() - began),
        },
        coords={"time": variable("time", truth.time, "s", "time since release")},
    )
    return scored(dataset, {"nmte_percent": nmte_percent(error, truth.displacement)}, scores)
