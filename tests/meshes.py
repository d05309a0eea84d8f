"""Small distorted bodies of every kind of element, and mesh files of small bodies."""

import numpy as np
import skfem

from vibrom.bodies import space
from vibrom.bodies.elements import KINDS, bases
from vibrom.bodies.space import Space, movable, numbered
from vibrom.bodies.topology import fill

FIRST = {
    "triangle": skfem.MeshTri1,
    "quad": skfem.MeshQuad1,
    "tetra": skfem.MeshTet1,
    "hexahedron": skfem.MeshHex1,
    "wedge": skfem.MeshWedge1,
}
OF = {
    "triangle6": "triangle",
    "quad8": "quad",
    "quad9": "quad",
    "tetra10": "tetra",
    "hexahedron20": "hexahedron",
    "hexahedron27": "hexahedron",
}
THICKNESS = 0.7


def straight(kind: str, size=(1.0, 0.8, 0.6), cells=(2, 1, 1)) -> skfem.Mesh:
    """The corners of a block of these elements."""
    first = FIRST[OF.get(kind, kind)]
    dim = first.elem.refdom.dim()
    lines = [np.linspace(0.0, side, count + 1) for side, count in zip(size, cells)][:dim]
    if first is not skfem.MeshWedge1:
        return first.init_tensor(*lines)
    base = skfem.MeshTri1.init_tensor(*lines[:2])
    layers = [np.vstack([base.p, np.full(base.nvertices, z)]) for z in lines[2]]
    count = base.nvertices
    t = [np.vstack([base.t + k * count, base.t + (k + 1) * count]) for k in range(cells[2])]
    return skfem.MeshWedge1(np.hstack(layers), np.hstack(t))


def distorted(kind: str, clamped=("left",), curved=True) -> Space:
    """Corners moved at random; sides of elements of second order are curved."""
    mesh, rng = straight(kind), np.random.default_rng(3)
    mesh.p[:] += 0.08 * rng.uniform(-1, 1, mesh.p.shape) * (mesh.p[0] > 1e-9)
    if KINDS[kind].mesh is not type(mesh):
        mesh = KINDS[kind].mesh.from_mesh(mesh)
    moved = mesh.doflocs.copy()
    bent = np.where(mesh.doflocs[0] > 1e-9, 0.02 * curved, 0.0)
    bent[: mesh.nvertices] = 0.0
    moved += bent * rng.uniform(-1, 1, moved.shape)
    if kind in ("quad8", "hexahedron20"):
        fill(moved, mesh)
    mesh = type(mesh)(moved, mesh.t)
    return spaced(mesh, kind, clamped)


def spaced(mesh: skfem.Mesh, kind: str, clamped=("left",)) -> Space:
    """The space of a mesh whose face at x = 0 is named left."""
    at = np.abs(mesh.p[0, mesh.facets]).max(axis=0) < 1e-9
    mesh = mesh.with_boundaries({"left": np.flatnonzero(at)})
    basis, scalar, mass = bases(mesh, kind)
    free = numbered(scalar, basis, movable(basis, clamped))
    thickness = THICKNESS if mesh.dim() == 2 else 1.0
    return Space(basis, scalar, thickness, tuple(clamped), free, basis.doflocs, {}, mass)


# Gmsh's numbers of elements (its reference manual, "MSH file format").
NUMBERS = {
    "vertex": 15,
    "line": 1,
    "triangle": 2,
    "quad": 3,
    "tetra": 4,
    "hexahedron": 5,
    "wedge": 6,
    "triangle6": 9,
    "quad9": 10,
    "tetra10": 11,
    "hexahedron27": 12,
    "quad8": 16,
    "hexahedron20": 17,
}


def write_gmsh(path, blocks, points, names=(), version="2.2"):
    """Blocks (kind, group, rows of node numbers from 1 on)."""
    text = ["$MeshFormat", f"{version} 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names))]
    text += [f'{dim} {tag} "{name}"' for dim, tag, name in names]
    text += ["$EndPhysicalNames", "$Nodes", str(len(points))]
    text += [f"{k} {x:.17g} {y:.17g} {z:.17g}" for k, (x, y, z) in enumerate(points, 1)]
    rows = [(kind, group, row) for kind, group, found in blocks for row in found]
    text += ["$EndNodes", "$Elements", str(len(rows))]
    for k, (kind, group, row) in enumerate(rows, 1):
        text.append(f"{k} {NUMBERS[kind]} 2 {group} 1 {' '.join(map(str, row))}")
    path.write_text("\n".join([*text, "$EndElements"]))


def build(path, **changes):
    return space.build({"mesh": str(path), "clamped": [], "probes": {}, "width": 0.0, **changes})


STRIP = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0]]
QUADS = [[1, 2, 5, 4], [2, 3, 6, 5]]
NAMES = [(1, 1, "left"), (2, 2, "part"), (0, 3, "end")]
BLOCKS = [("line", 1, [[1, 4]]), ("quad", 2, QUADS), ("vertex", 3, [[6]])]


def strip(tmp_path, blocks=BLOCKS, points=STRIP, **changes):
    path = tmp_path / "strip.msh"
    write_gmsh(path, blocks, points, NAMES)
    return build(path, **{"width": 0.1, "clamped": ["left"], **changes})
