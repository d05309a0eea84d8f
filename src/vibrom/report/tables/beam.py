"""Table 3.1: the beam of each case

Properties, mesh, undamped natural frequencies and damping of the body, and the states from which
it is released. A coarse mesh of bilinear elements locks in shear: it is stiffer than the beam it
stands for, and its frequencies lie well above those of quadratic elements and of beam theory. The
thesis studies a locked beam. Where a scene has computed its first frequency with quadratic elements
on the same mesh (``omega_1_quadratic_rad_per_s`` in the .csv), it is listed too: the difference
between the two is the effect of shear locking.

The probe is the scene's own. In the thesis's beam it is the y displacement of the node at x = 0.525
m on the bottom edge, which the thesis calls the tip; the tip is the true one, at x = 1 m.
"""

import numpy as np
import xarray as xr

from vibrom.artefacts.outcome import Outcome
from vibrom.report.collection import FULL_ORDER, described, probe_dof
from vibrom.report.columns import CASE, METHOD, OUTCOME, Column
from vibrom.report.table import on_its_side
from vibrom.thesis import published as thesis

FAMILY = "models"
PLACE = 10
FREQUENCIES = 4
PROPERTIES = {
    "length_m": "Length [m]",
    "height_m": "Height [m]",
    "width_m": "Width [m]",
    "young_modulus_pa": "Young's modulus [Pa]",
    "poisson_ratio": "Poisson's ratio [–]",
    "density_kg_per_m3": "Density [kg/m³]",
    "damping_ratio": "Damping ratio, first mode [–]",
    "element": "Element",
    "cells": "Cells",
}
COUNTS = {"elements": "Elements", "free_dofs": "Free dofs"}
STATES = {
    "effects": "Effects",
    **{f"omega_{mode}_rad_per_s": f"ω{mode} [rad/s]" for mode in range(1, FREQUENCIES + 1)},
    "omega_1_quadratic_rad_per_s": "ω1 with quadratic elements [rad/s]",
    **{
        name: heading
        for role in ("train", "test")
        for name, heading in (
            (f"{role}_probe_m", f"{role.capitalize()} release, probe [m]"),
            (f"{role}_tip_m", f"{role.capitalize()} release, tip [m]"),
            (f"thesis_{role}_probe_m", f"{role.capitalize()} release, probe, thesis [m]"),
        )
    },
}
COLUMNS = (
    CASE,
    METHOD,
    *(Column(name, heading, optional=True) for name, heading in PROPERTIES.items()),
    *(Column(name, heading, optional=True, whole=True) for name, heading in COUNTS.items()),
    *(Column(name, heading, optional=True) for name, heading in STATES.items()),
    OUTCOME,
)

shown = on_its_side


def build(collection, scores):
    """One row a scene."""
    rows = []
    for scene in collection.scenes:
        structure = collection.find(scene, FULL_ORDER, "structure")
        row = {"case": scene, "method": FULL_ORDER, "outcome": Outcome.NOT_RUN}
        if structure is not None:
            row |= properties(structure) | frequencies(structure) | {"outcome": Outcome.OK}
            row |= releases(scene, structure, collection.find(scene, FULL_ORDER, "release"))
        rows.append({name: ten_digits(value) for name, value in row.items()})
    return rows


def ten_digits(value):
    """A float without the noise of its last digits."""
    return float(f"{value:.10g}") if isinstance(value, float) else value


def properties(structure: xr.Dataset) -> dict:
    """What the scene says about the body; what it does not say is read off the mesh."""
    body, effects = described(structure, "body"), described(structure, "effects")
    # Of an effect that acts more than once, the first.
    effects = {name: each[0] if isinstance(each, list) else each for name, each in effects.items()}
    elasticity = effects.get("elasticity") or {}
    span = np.ptp(structure["node"].values, axis=0) if "node" in structure else [np.nan, np.nan]
    damping = structure["damping_ratio"].values[0] if "damping_ratio" in structure else np.nan
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
        "elements": structure.sizes.get("element", np.nan),
        "free_dofs": structure.sizes["dof"],
        "effects": ", ".join(effects) or None,
    }


def frequencies(structure: xr.Dataset) -> dict[str, float]:
    """Undamped angular frequencies [rad/s]."""
    lowest = structure["frequency"].values[:FREQUENCIES]
    row = {f"omega_{mode}_rad_per_s": float(value) for mode, value in enumerate(lowest, start=1)}
    if "frequency_quadratic" in structure:
        quadratic = structure["frequency_quadratic"].values
        row["omega_1_quadratic_rad_per_s"] = float(quadratic.ravel()[0])
    return row


def releases(scene: str, structure: xr.Dataset, release: xr.Dataset | None) -> dict[str, float]:
    """Displacement [m] of probe and tip in the states from which the beam is released; the thesis
    gives the probe's.
    """
    row: dict[str, float] = {}
    for role in ("train", "test"):
        for probe in ("probe", "tip"):
            dof = probe_dof(structure, probe)
            if release is not None and dof is not None and role in release["role"].values:
                state = release["displacement"].sel(role=role).values
                row[f"{role}_{probe}_m"] = float(state[dof])
        row[f"thesis_{role}_probe_m"] = thesis.release(scene, role)
    return row
