"""The response curve of the full order with coarse steps and numerical damping: where Newton's
iteration fails, and what the damping costs.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import xarray as xr

from vibrom.artefacts.data import variable
from vibrom.artefacts.outcome import Outcome
from vibrom.models.full_order import FullOrder
from vibrom.solvers.full.newmark import Newmark
from vibrom.studies import Case
from vibrom.studies.parts.records import Column, stacked
from vibrom.studies.robustness import Robustness

CURVE = ("angular_frequency",)
COLUMNS = {
    "outcome": Column("1", "how the run ended", CURVE, missing=Outcome.NOT_RUN),
    "failed_at": Column("1", "periods until Newton's iteration failed", CURVE),
    "amplitude": Column("m", "largest displacement of the first probe in the last period", CURVE),
    "seconds": Column("s", "wall time of these frequencies, compilation excluded"),
}


def made(study: Robustness, case: Case) -> xr.Dataset:
    """One entry a number of steps, numerical damping and forcing, each at some frequencies of the
    scene's own curve.
    """
    model, varied = FullOrder.of_scene(dict(case.scene), case.structure), study.full_order
    curve = case.full_order["frc"]
    curve = curve.isel(angular_frequency=slice(None, None, varied.every_frequency))
    frequency = curve["angular_frequency"].values
    lowest, highest = frequency[[0, -1]] / model.frequency
    settings = {
        "periods": varied.periods,
        "frequencies": len(frequency),
        "lowest": float(lowest),
        "highest": float(highest),
    }
    own, records = case.scene["experiments"]["frc"]["forcing"], []
    for steps, alpha, forcing in product(varied.steps_per_period, varied.alpha, varied.forcing):
        coarse = replace(
            model,
            steps_per_period=steps,
            newmark=Newmark(alpha=alpha, tolerance=model.newmark.tolerance),
            title=f"{case.structure.attrs['scene']}: response curve, T/{steps}",
        )
        question = replace(case.question("frc"), forcing=forcing * own, **settings)
        answer = question.ask(coarse, case.given)
        records.append(
            {
                "outcome": answer["outcome"].values,
                "failed_at": answer["failed_at"].values * frequency / (2 * np.pi),
                "amplitude": answer["amplitude"].values[0],
                "seconds": float(answer["seconds"]),
            }
        )
    axes = {
        "steps_per_period": ("steps to a period of the forcing", varied.steps_per_period),
        "alpha": ("numerical damping: gamma = 1/2 + alpha", varied.alpha),
        "forcing": ("forcing amplitude over the scene's", varied.forcing),
    }
    along = {name: len(values) for name, (_, values) in axes.items()}
    return xr.Dataset(
        stacked(records, along, COLUMNS, {CURVE[0]: len(frequency)})
        | {
            "reference": variable(
                CURVE[0], curve["amplitude"].values[0], "m", "the same of the scene's own curve"
            )
        },
        coords={CURVE[0]: curve[CURVE[0]].variable}
        | {
            name: variable(name, np.array(values), "1", about)
            for name, (about, values) in axes.items()
        },
        attrs={
            "periods": varied.periods,
            "own_steps": model.steps_per_period,
            "own_alpha": model.newmark.alpha,
        },
    )
