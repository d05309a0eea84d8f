"""Eigenvalues of small motions about rest: those of the Jacobian of a reduced model's drift, and of
the full order's damped modes.

    lambda = omega (-zeta +- sqrt(zeta^2 - 1))

Source: thesis, section 3.2.2.
"""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from vibrom.artefacts.data import outcome_variables, variable
from vibrom.artefacts.outcome import Outcome
from vibrom.experiments import Experiment, Given
from vibrom.models.model import Model


@dataclass(frozen=True)
class Eigenvalues(Experiment):
    """Has no settings."""

    scores = {"real_per_s": "1/s", "imaginary_rad_per_s": "rad/s"}
    job = "answers"

    def ask(self, model: Model, given: Given) -> xr.Dataset:
        """All eigenvalues, by falling imaginary part."""
        values = model.eigenvalues()
        values = values[np.lexsort((values.real, -values.imag))]
        return xr.Dataset(
            {
                "real": variable("eigenvalue", values.real, "s-1", "real part of the eigenvalues"),
                "imaginary": variable(
                    "eigenvalue", values.imag, "s-1", "imaginary part of the eigenvalues"
                ),
                **outcome_variables(Outcome.OK),
            }
        )

    def score(self, answer: xr.Dataset, truth: xr.Dataset | None) -> dict[str, float]:
        """The one of least size in the upper half plane."""
        values = answer["real"].values + 1j * answer["imaginary"].values
        upper = values[values.imag >= 0]
        first = upper[np.abs(upper).argmin()]
        return {"real_per_s": float(first.real), "imaginary_rad_per_s": float(first.imag)}
