"""Scene -> stability.nc of the full order: the response curve at coarse steps and with numerical
damping; where Newton fails, and what the damping costs.
"""

import numpy as np
import xarray as xr

from vibrom.artefacts.data import label, open_dataset, save_dataset, variable
from vibrom.models.full_order import build
from vibrom.models.measures import amplitude_and_phase
from vibrom.solvers.full.newmark import Newmark, Record


def run(
    *, structure: str, curve: str, stability: str, scene: dict, settings: dict, provenance: dict
) -> None:
    model, reference = build(scene, structure), open_dataset(curve, "frc")
    reference = reference.isel(angular_frequency=slice(None, None, settings["every_frequency"]))
    frequency, periods = reference["angular_frequency"].values, settings["periods"]
    shape = (
        len(settings["steps_per_period"]),
        len(settings["alpha"]),
        len(settings["forcing"]),
        len(frequency),
    )
    amplitude, failed_at, outcome, seconds = (
        np.full(shape, np.nan),
        np.full(shape, np.nan),
        np.empty(shape, dtype=object),
        np.full(shape[:3], np.nan),
    )
    for i, steps in enumerate(settings["steps_per_period"]):
        record = Record(
            start=periods * steps + 1,
            probes=model.probes[:1],
            probe_start=(periods - 1) * steps + 1,
        )
        phase = 2 * np.pi * np.arange(periods * steps + 1)[:, None] / steps
        for j, alpha in enumerate(settings["alpha"]):
            for k, level in enumerate(settings["forcing"]):
                start = np.repeat(model.rest[:, None], len(frequency), axis=1)
                motion = Newmark(alpha=alpha, tolerance=model.newmark.tolerance).run(
                    model.term,
                    start,
                    2 * np.pi / (frequency * steps),
                    periods * steps,
                    signal=np.sin(phase)
                    * np.full(len(frequency), level * scene["experiments"]["frc"]["forcing"]),
                    initial_acceleration=model.initial_acceleration,
                    record=record,
                )
                probe = motion.probes[:, 0] - model.rest[model.probes[0]]
                amplitude[i, j, k] = amplitude_and_phase(np.roll(probe, 1, axis=-1))[0]
                failed_at[i, j, k], outcome[i, j, k], seconds[i, j, k] = (
                    motion.failed_at * frequency / (2 * np.pi),
                    motion.outcomes,
                    motion.seconds,
                )
    dims = ("steps_per_period", "alpha", "forcing")
    dataset = xr.Dataset(
        {
            "outcome": variable((*dims, "angular_frequency"), outcome, "1", "how the run ended"),
            "failed_at": variable(
                (*dims, "angular_frequency"),
                failed_at,
                "1",
                "periods until Newton's iteration failed",
            ),
            "amplitude": variable(
                (*dims, "angular_frequency"),
                amplitude,
                "m",
                "largest displacement of the first probe in the last period",
            ),
            "reference": variable(
                "angular_frequency",
                reference["amplitude"].values[0],
                "m",
                "the same of the scene's own response curve",
            ),
            "seconds": variable(
                dims, seconds, "s", "wall time of these frequencies, compilation excluded"
            ),
        },
        coords={
            "steps_per_period": variable(
                "steps_per_period",
                np.array(settings["steps_per_period"]),
                "1",
                "steps to a period of the forcing",
            ),
            "alpha": variable(
                "alpha",
                np.array(settings["alpha"], float),
                "1",
                "numerical damping: gamma = 1/2 + alpha",
            ),
            "forcing": variable(
                "forcing",
                np.array(settings["forcing"], float),
                "1",
                "forcing amplitude over the scene's",
            ),
            "angular_frequency": variable(
                "angular_frequency", frequency, "rad s-1", "angular frequency of the forcing"
            ),
        },
    )
    save_dataset(
        label(
            dataset,
            "stability",
            scene=model.name,
            method="full_order",
            periods=periods,
            own_steps=model.steps_per_period,
            own_alpha=model.newmark.alpha,
        ),
        stability,
        provenance,
    )
