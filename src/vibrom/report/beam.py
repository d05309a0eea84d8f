"""The bodies of a run as a table: properties, mesh, frequencies, and the states from which they are
released.

The coarse bilinear mesh of the thesis locks in shear, so that its frequencies lie above those of
the beam itself. Where a scene's structure carries `frequency_quadratic` (the same body in quadratic
elements), that frequency stands beside the locked one.
"""

import numpy as np
import pandas as pd
import xarray as xr

from vibrom.report.collection import FULL_ORDER, Collection, described
from vibrom.thesis import published as thesis

FREQUENCIES = 4


def table(collection: Collection) -> pd.DataFrame:
    """One row a scene. Columns that no scene of the run can fill are left out."""
    rows = []
    for scene in collection.scenes:
        structure = collection.find(scene, FULL_ORDER, "structure")
        row: dict = {"case": scene, "method": FULL_ORDER}
        if structure is not None:
            row |= properties(structure) | frequencies(structure)
            row |= releases(scene, structure, collection.find(scene, FULL_ORDER, "release"))
        rows.append(row | {"outcome": "ok" if structure is not None else "not run"})
    frame = pd.DataFrame([{name: ten_digits(value) for name, value in row.items()} for row in rows])
    return frame[
        [
            name
            for name in frame.columns
            if name in ("case", "method", "outcome") or frame[name].notna().any()
        ]
    ]


def ten_digits(value):
    """A float without the noise of its last digits."""
    return float(f"{value:.10g}") if isinstance(value, float) else value


def properties(structure: xr.Dataset) -> dict:
    """What the scene says about the body; what it leaves unsaid is read off the mesh."""
    body, effects = described(structure, "body"), described(structure, "effects")
    elasticity, span = effects.get("elasticity") or {}, np.ptp(structure["node"].values, axis=0)
    damping = (
        np.atleast_1d(structure["damping_ratio"].values)[0]
        if "damping_ratio" in structure
        else np.nan
    )
    return {
        "length_m": float(body.get("length", span[0])),
        "height_m": float(body.get("height", span[1])),
        "width_m": float(body.get("width", np.nan)),
        "young_modulus_pa": float(elasticity.get("young_modulus", np.nan)),
        "poisson_ratio": float(elasticity.get("poisson_ratio", np.nan)),
        "density_kg_per_m3": float((effects.get("inertia") or {}).get("density", np.nan)),
        "damping_ratio": float(damping),
        "element": body.get("element"),
        "cells": " x ".join(str(count) for count in body["cells"]) if "cells" in body else None,
        "elements": structure.sizes["element"],
        "free_dofs": structure.sizes["dof"],
        "effects": ", ".join(effects) or None,
    }


def frequencies(structure: xr.Dataset) -> dict[str, float]:
    """Undamped angular frequencies [rad/s]."""
    lowest = structure["frequency"].values[:FREQUENCIES]
    row = {
        f"omega_{number}_rad_per_s": float(value) for number, value in enumerate(lowest, start=1)
    }
    if "frequency_quadratic" in structure:
        row["omega_1_quadratic_rad_per_s"] = float(
            np.atleast_1d(structure["frequency_quadratic"].values)[0]
        )
    return row


def releases(scene: str, structure: xr.Dataset, release: xr.Dataset | None) -> dict[str, float]:
    """Displacement [m] of probe and tip in the states from which the beam is let go; the thesis
    gives the probe's.
    """
    row: dict[str, float] = {}
    names = [str(name) for name in structure["probe"].values]
    for role in ("train", "test"):
        for probe in ("probe", "tip"):
            if release is not None and probe in names and role in release["role"].values:
                state = release["displacement"].sel(role=role).values
                row[f"{role}_{probe}_m"] = float(
                    state[int(structure["probe_dof"].values[names.index(probe)])]
                )
        row[f"thesis_{role}_probe_m"] = thesis.release(scene, role)
    return row
