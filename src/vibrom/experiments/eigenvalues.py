"""Eigenvalues of the linear part of the dynamics: those of the Jacobian of `drift` at rest, for the
full model those of its damped modes.

    lambda = omega (-zeta +- sqrt(zeta^2 - 1))

Source: thesis, section 3.2.2.
"""

import numpy as np
import xarray as xr

from vibrom.artefacts.data import outcome_variables, scored, variable
from vibrom.models.rollout import Integrator

needs = ("structure", "rom")
full_order = ("structure",)
scores = {"real_per_s": "1/s", "imaginary_rad_per_s": "rad/s"}
# of the training range: central differences of a cubic drift are then exact to about 1e-10
STEP = 1e-5


def jacobian(rom) -> np.ndarray:
    """D drift / dz (r, r) at z = 0 [1/s]."""
    steps = np.diag(STEP * rom.reach)
    return (rom.drift(steps) - rom.drift(-steps)).T / (2 * STEP * rom.reach)


def predict(artefacts: dict, integrator: Integrator) -> xr.Dataset:
    if "rom" in artefacts:
        values = np.linalg.eigvals(jacobian(artefacts["rom"]))
    else:
        omega, zeta = (
            artefacts["structure"]["frequency"].values,
            artefacts["structure"]["damping_ratio"].values,
        )
        root = np.sqrt(zeta.astype(complex) ** 2 - 1)
        values = np.concatenate([omega * (-zeta + root), omega * (-zeta - root)])
    values = values[np.lexsort((values.real, -values.imag))]
    dataset = xr.Dataset(
        {
            "real": variable("eigenvalue", values.real, "s-1", "real part of the eigenvalues"),
            "imaginary": variable(
                "eigenvalue", values.imag, "s-1", "imaginary part of the eigenvalues"
            ),
            **outcome_variables("ok"),
        }
    )
    upper = values[values.imag >= 0]
    first = upper[np.abs(upper).argmin()]
    return scored(
        dataset, {"real_per_s": float(first.real), "imaginary_rad_per_s": float(first.imag)}, scores
    )
