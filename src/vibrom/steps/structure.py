"""Scene -> structure.nc: the body's mesh, operators, modes, load and probes.

Under a dead load displacements are measured from the equilibrium that it makes; the stiffness and
the modes are those of small motions about it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from scipy.sparse import coo_matrix, spmatrix

from vibrom import effects
from vibrom.artefacts.data import label, save_dataset, variable
from vibrom.bodies import space
from vibrom.bodies.space import Space
from vibrom.config.places import FULL_ORDER
from vibrom.solvers.full.modes import eigenmodes, linearised
from vibrom.term import Term

MODES = 10
Variables = dict[str, xr.Variable]


def run(*, structure: str, scene: dict[str, Any], name: str, provenance: dict[str, str]) -> None:
    """`scene` has the blocks `body` and `effects`."""
    body = space.build(scene["body"])
    term = effects.assemble(body, scene["effects"])
    found = eigenmodes(term, MODES)
    rest, stiffness = linearised(term)
    variables = geometry(body) | of_modes(term, *found)
    load = np.zeros(body.size) if term.load is None else term.load
    variables["load"] = variable("dof", load, "N", "load per unit of the signal")
    if term.driven:
        own = np.array([one.load for one in term.driven])
        variables["driven_load"] = variable(
            ("driven", "dof"), own, "N", "load per unit of its own signal"
        )
    if scene["body"].get("element") == "bilinear":
        # Bilinear elements lock in shear when they bend; the report shows by how much.
        finer = space.build({**scene["body"], "element": "quadratic", "probes": {}})
        variables["frequency_quadratic"] = variable(
            "mode",
            eigenmodes(effects.assemble(finer, scene["effects"]), len(found.frequency)).frequency,
            "rad s-1",
            "undamped angular eigenfrequencies of the same mesh with quadratic elements",
        )
    if term.dead_load is not None:
        variables["equilibrium"] = variable(
            "dof", rest, "m", "displacement under the dead load, from which all others are measured"
        )
    for matrix, what, units in (
        (term.mass, "mass", "kg"),
        (term.damping, "damping", "kg s-1"),
        (stiffness, "stiffness", "N m-1"),
    ):
        variables |= {} if matrix is None else entries(matrix, what, units)
    probes, count = np.array(list(body.probes), dtype=object), len(found.frequency)
    coords = {
        "probe": variable("probe", probes, "1", "name of the probe"),
        "mode": variable("mode", np.arange(1, count + 1), "1", "number of the mode"),
    }
    blocks = {block: scene[block] for block in ("body", "effects")}
    if term.driven:
        blocks["signals"] = [one.signal for one in term.driven]
    dataset = label(
        xr.Dataset(variables, coords), "structure", scene=name, method=FULL_ORDER, **blocks
    )
    save_dataset(dataset, structure, provenance)


def geometry(body: Space) -> Variables:
    """The mesh, and where the free displacements and the probes are."""
    mesh, surface = body.basis.mesh, {}
    corners = mesh.p[:, : mesh.nvertices].T
    if body.dimension == 3:
        surface["face_node"] = variable(
            ("face", "around"), body.surface, "1", "vertices of each face of the surface, around it"
        )
    return surface | {
        "node": variable(("vertex", "axis"), corners, "m", "coordinates of the mesh vertices"),
        "element_node": variable(
            ("element", "corner"), mesh.t.T, "1", "vertices of each element, in the plane around it"
        ),
        "dof_node": variable(
            "dof", body.dof_vertex, "1", "vertex of each free displacement, -1 where it has none"
        ),
        "dof_axis": variable(
            "dof", body.dof_axis, "1", "direction of each free displacement: 0, 1, 2 along x, y, z"
        ),
        "dof_location": variable(
            ("dof", "axis"), body.dof_location, "m", "where each free displacement sits"
        ),
        "probe_dof": variable(
            "probe",
            np.array(list(body.probes.values())),
            "1",
            "free displacement that each probe watches",
        ),
    }


def of_modes(term: Term, frequency: np.ndarray, shape: np.ndarray) -> Variables:
    """Frequencies (k,) [rad/s], shapes (k, n) [kg^-1/2] and damping ratios phi' C phi/(2 omega)."""
    ratio = np.zeros(len(frequency))
    if term.damping is not None:
        ratio = np.einsum("ki,ik->k", shape, term.damping @ shape.T) / (2 * frequency)
    return {
        "mode_shape": variable(
            ("mode", "dof"),
            shape,
            "kg^(-1/2)",
            "mass-normalised eigenmodes of the undamped linear body",
        ),
        "frequency": variable("mode", frequency, "rad s-1", "undamped angular eigenfrequencies"),
        "damping_ratio": variable("mode", ratio, "1", "damping ratio of each mode"),
    }


def entries(matrix: spmatrix, what: str, units: str) -> Variables:
    """A sparse matrix by row, column and value of its entries."""
    found, dim = coo_matrix(matrix), f"{what}_entry"
    return {
        f"{what}_row": variable(dim, found.row, "1", f"row of each entry of the {what} matrix"),
        f"{what}_column": variable(
            dim, found.col, "1", f"column of each entry of the {what} matrix"
        ),
        f"{what}_value": variable(dim, found.data, units, f"entries of the {what} matrix"),
    }
