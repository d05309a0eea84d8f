"""The response curve of the full order with coarse steps and several schemes: where Newton's
iteration fails, and what numerical damping costs.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import xarray as xr

from vibrom.artefacts.data import variable
from vibrom.artefacts.outcome import Outcome
from vibrom.experiments.frc import ResponseCurve
from vibrom.models.full_order import FullOrder
from vibrom.solvers.full.newmark import Newmark
from vibrom.studies import Case
from vibrom.studies.parts.records import Column, stacked, text
from vibrom.studies.robustness import Robustness

CURVE = ("angular_frequency",)
COLUMNS = {
    "outcome": Column("1", "how the run ended", CURVE, missing=Outcome.NOT_RUN),
    "failed_at": Column("1", "periods until Newton's iteration failed", CURVE),
    "amplitude": Column("m", "largest displacement of the first probe in the last period", CURVE),
    "seconds": Column("s", "wall time of these frequencies, compilation excluded"),
}


def made(study: Robustness, case: Case) -> xr.Dataset:
    """One entry a number of steps, scheme and forcing, each at some frequencies of the
    scene's own curve.
    """
    model, varied = FullOrder.of_scene(dict(case.scene), case.structure), study.full_order
    curve = case.full_order["frc"]
    curve = curve.isel(angular_frequency=slice(None, None, varied.every_frequency))
    axes = {
        "steps_per_period": ("steps to a period of the forcing", varied.steps_per_period),
        "forcing": ("forcing amplitude over the scene's", varied.forcing),
    }
    records = []
    for steps, scheme, forcing in product(varied.steps_per_period, varied.schemes, varied.forcing):
        coarse = replace(
            model,
            steps_per_period=steps,
            newmark=Newmark(
                scheme.alpha, scheme.scheme, model.newmark.tolerance, scheme.iterations
            ),
            title=f"{model.title}: response curve, T/{steps}",
        )
        level = forcing * float(case.settings("frc")["forcing"])
        records.append(evaluated(coarse, level, varied.periods, case, curve[CURVE[0]].values))
    along = {"steps_per_period": len(varied.steps_per_period), "scheme": len(varied.schemes)}
    along |= {"forcing": len(varied.forcing)}
    reference = variable(
        CURVE[0], curve["amplitude"].values[0], "m", "the same of the scene's own curve"
    )
    return xr.Dataset(
        {
            "reference": reference,
            "alpha": variable(
                "scheme", np.array([one.alpha for one in varied.schemes]), "1", "numerical damping"
            ),
            "time_scheme": text(
                "scheme", [one.scheme for one in varied.schemes], "time integration"
            ),
            **stacked(records, along, COLUMNS, {CURVE[0]: curve.sizes[CURVE[0]]}),
        },
        coords={CURVE[0]: curve[CURVE[0]].variable}
        | {name: variable(name, np.array(made), "1", said) for name, (said, made) in axes.items()},
        attrs={
            "periods": varied.periods,
            "own_steps": model.steps_per_period,
            "own_alpha": model.newmark.alpha,
        },
    )


def evaluated(
    model: FullOrder, forcing: float, periods: int, case: Case, frequency: np.ndarray
) -> dict[str, Any]:
    """The response at equally spaced frequencies [rad/s], each from rest."""
    lowest, highest = (float(end) for end in frequency[[0, -1]] / model.frequency)
    curve = ResponseCurve(forcing, periods, len(frequency), lowest, highest)
    answer = curve.ask(model, case.given)
    return {
        "outcome": answer["outcome"].values,
        "failed_at": answer["failed_at"].values * frequency / (2 * np.pi),
        "amplitude": answer["amplitude"].values[0],
        "seconds": float(answer["seconds"]),
    }
