"""The response to a forcing at the damped first frequency, from rest; the error is that of the last
period.

Source: thesis, section 3.4.1. The model never saw a forced motion.
"""

import time

import numpy as np
import xarray as xr

from vibrom.artefacts.data import outcome_variables, scored, variable
from vibrom.models.measures import nmte_percent
from vibrom.models.rollout import Drive, Integrator, decode_displacement, rollout

needs = ("structure", "rom", "forced")
full_order = None
scores = {"nmte_percent": "percent", "amplitude_error_percent": "percent"}
THIN = 2  # the whole trajectory is kept at every second sample of the full-order one


def predict(artefacts: dict, integrator: Integrator) -> xr.Dataset:
    rom, structure, truth = artefacts["rom"], artefacts["structure"], artefacts["forced"]
    probes = structure["probe_dof"].values
    drive = Drive(
        structure["load"].values,
        np.array([truth["forcing"].item()]),
        np.array([truth["angular_frequency"].item()]),
    )
    instants = np.union1d(truth["time"].values[::THIN], truth["last_time"].values)
    began = time.perf_counter()
    run = rollout(
        rom,
        rom.encode(np.zeros((1, 2 * len(structure["load"])))),
        instants[None],
        integrator,
        drive,
    )
    whole, last = (
        run.reduced[0][np.searchsorted(instants, when)]
        for when in (truth["time"].values[::THIN], truth["last_time"].values)
    )
    displacement, probe = decode_displacement(rom, last), decode_displacement(rom, whole, probes)
    seconds = time.perf_counter() - began
    true = truth["last_displacement"].values
    error = np.linalg.norm(true - displacement, axis=1)
    watched, watched_true = displacement[:, probes[0]], true[:, probes[0]]
    at = int(watched.argmax()) if np.isfinite(watched).all() else 0
    dims = ("time", "coordinate")
    dataset = xr.Dataset(
        {
            "probe_displacement": variable(
                ("probe", "time"), probe.T, "m", "displacement of the model at the probes"
            ),
            "reduced": variable(dims, whole, "1", "reduced coordinates of the model"),
            "final_shape": variable(
                "dof",
                displacement[at],
                "m",
                "displacement when the first probe is highest in the last period",
            ),
            "final_shape_true": variable(
                "dof", true[int(watched_true.argmax())], "m", "the same of the full-order model"
            ),
            "error": variable(
                "last_time", error, "m", "norm of the displacement error in the last period"
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
            "time": variable(
                "time", truth["time"].values[::THIN], "s", "time since the forcing began"
            ),
            "last_time": truth["last_time"].variable,
            "probe": structure["probe"].variable,
        },
    )
    return scored(
        dataset,
        {
            "nmte_percent": nmte_percent(error, true),
            "amplitude_error_percent": float(100 * (watched.max() / watched_true.max() - 1)),
        },
        scores,
    )
