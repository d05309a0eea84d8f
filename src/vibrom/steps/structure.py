"""Scene -> structure.nc: the body's mesh, operators, modes, load and probes.

Under a dead load displacements are measured from the equilibrium that it makes; the stiffness and
the modes are those of small motions about it.
"""

import numpy as np
import xarray as xr
from scipy.sparse import coo_matrix

from vibrom import effects
from vibrom.artefacts.data import label, save_dataset, variable
from vibrom.bodies import space
from vibrom.solvers.full.modes import eigenmodes, linearised

MODES = 10
OPERATORS = {"mass": "kg", "damping": "kg s-1", "stiffness": "N m-1"}


def run(*, structure: str, scene: dict, name: str, provenance: dict) -> None:
    body = space.build(scene["body"])
    term = effects.assemble(body, scene["effects"])
    frequency, modes = eigenmodes(term, MODES)
    rest, stiffness = linearised(term)
    ratio = (
        np.zeros(len(frequency))
        if term.damping is None
        else np.einsum("ki,ik->k", modes, term.damping @ modes.T) / (2 * frequency)
    )
    mesh = body.basis.mesh
    corners = mesh.t.T[:, :4]
    variables = {
        "node": variable(("vertex", "axis"), mesh.p.T, "m", "coordinates of the mesh vertices"),
        "element_node": variable(
            ("element", "corner"), corners, "1", "vertices of each element, in order around it"
        ),
        "dof_node": variable(
            "dof", body.dof_vertex, "1", "vertex of each free displacement, -1 where it has none"
        ),
        "dof_axis": variable(
            "dof", body.dof_axis, "1", "direction of each free displacement: 0 along x, 1 along y"
        ),
        "dof_location": variable(
            ("dof", "axis"), body.dof_location, "m", "where each free displacement sits"
        ),
        "mode_shape": variable(
            ("mode", "dof"),
            modes,
            "kg-0.5",
            "mass-normalised eigenmodes of the undamped linear body",
        ),
        "frequency": variable("mode", frequency, "rad s-1", "undamped angular eigenfrequencies"),
        "damping_ratio": variable("mode", ratio, "1", "damping ratio of each mode"),
        "load": variable(
            "dof",
            np.zeros(body.size) if term.load is None else term.load,
            "N",
            "load per unit of the signal",
        ),
        "probe_dof": variable(
            "probe",
            np.array(list(body.probes.values())),
            "1",
            "free displacement that each probe watches",
        ),
    }
    if scene["body"]["element"] == "bilinear":
        # Bilinear elements lock in shear when they bend; the report shows by how much.
        finer = space.build({**scene["body"], "element": "quadratic", "probes": {}})
        variables["frequency_quadratic"] = variable(
            "mode",
            eigenmodes(effects.assemble(finer, scene["effects"]), len(frequency))[0],
            "rad s-1",
            "undamped angular eigenfrequencies of the same mesh with quadratic elements",
        )
    if term.dead_load is not None:
        variables["equilibrium"] = variable(
            "dof", rest, "m", "displacement under the dead load, from which all others are measured"
        )
    for operator, units in OPERATORS.items():
        matrix = stiffness if operator == "stiffness" else getattr(term, operator)
        if matrix is not None:
            entries, dim = coo_matrix(matrix), f"{operator}_entry"
            variables |= {
                f"{operator}_row": variable(
                    dim, entries.row, "1", f"row of each entry of the {operator} matrix"
                ),
                f"{operator}_column": variable(
                    dim, entries.col, "1", f"column of each entry of the {operator} matrix"
                ),
                f"{operator}_value": variable(
                    dim, entries.data, units, f"entries of the {operator} matrix"
                ),
            }
    dataset = xr.Dataset(
        variables,
        coords={
            "probe": variable(
                "probe", np.array(list(body.probes), dtype=object), "1", "name of the probe"
            ),
            "mode": variable("mode", np.arange(1, len(frequency) + 1), "1", "number of the mode"),
        },
    )
    save_dataset(
        label(
            dataset,
            "structure",
            scene=name,
            method="full_order",
            body=scene["body"],
            effects=scene["effects"],
        ),
        structure,
        provenance,
    )
