"""The forced response curve: amplitude and phase of the last period, every frequency from rest, all
frequencies side by side.

Source: thesis, section 2.3.3.
"""

import time

import numpy as np
import xarray as xr

from vibrom.artefacts.data import outcome_variables, scored, variable
from vibrom.models.measures import amplitude_and_phase
from vibrom.models.rollout import Drive, Integrator, decode_displacement, rollout

needs = ("structure", "rom", "frc")
full_order = None
scores = {
    "completed": "1",
    "amplitude_error_median_percent": "percent",
    "peak_error_percent": "percent",
}
# of the last period: a maximum between two samples is missed by at most (pi/500)^2/2 = 2e-5 of it
SAMPLES = 500


def predict(artefacts: dict, integrator: Integrator) -> xr.Dataset:
    rom, structure, truth = artefacts["rom"], artefacts["structure"], artefacts["frc"]
    frequency, periods = truth["angular_frequency"].values, int(truth.attrs["periods"])
    runs, n, probes = len(frequency), len(structure["load"]), structure["probe_dof"].values
    drive = Drive(structure["load"].values, np.full(runs, truth["forcing"].item()), frequency)
    period = (2 * np.pi / frequency)[:, None]
    instants = period * (periods - 1 + np.arange(SAMPLES + 1) / SAMPLES)
    began = time.perf_counter()
    run = rollout(
        rom, np.repeat(rom.encode(np.zeros((1, 2 * n))), runs, axis=0), instants, integrator, drive
    )
    watched = decode_displacement(
        rom, run.reduced[:, :-1].reshape(runs * SAMPLES, -1), probes
    ).reshape(runs, SAMPLES, len(probes))
    amplitude, phase = amplitude_and_phase(watched.transpose(2, 0, 1))
    seconds = time.perf_counter() - began
    dims = ("probe", "angular_frequency")
    dataset = xr.Dataset(
        {
            "amplitude": variable(dims, amplitude, "m", "largest displacement of the last period"),
            "phase": variable(
                dims, phase, "rad", "phase of the first harmonic relative to the forcing"
            ),
            "range_ratio": variable(
                "angular_frequency",
                run.range_ratio,
                "1",
                "largest reduced coordinate over the largest in the training data",
            ),
            "forcing": variable(
                (), truth["forcing"].item(), "1", "forcing amplitude, times the scene's load"
            ),
            **outcome_variables("ok", seconds=seconds),
            "outcome": variable(
                "angular_frequency", np.array(run.outcome, dtype=object), "1", "how the run ended"
            ),
            "failed_at": variable(
                "angular_frequency",
                run.failed_at,
                "s",
                "simulated time of the failure, or of leaving the training range",
            ),
        },
        coords={
            "angular_frequency": truth["angular_frequency"].variable,
            "probe": structure["probe"].variable,
        },
    )
    # Models fail at the peak first: a curve with gaps has no peak and no median to tell (NaN stays
    # NaN). Where the full order failed there is nothing to compare with.
    reference = truth["amplitude"].values[0]
    known = np.isfinite(reference)
    relative = 100 * np.abs(amplitude[0, known] / reference[known] - 1)
    return scored(
        dataset,
        {
            "completed": float(np.isfinite(amplitude[0]).sum()),
            "amplitude_error_median_percent": float(np.median(relative))
            if known.any()
            else float("nan"),
            "peak_error_percent": float(100 * (amplitude[0].max() / reference.max() - 1)),
        },
        scores,
    )
