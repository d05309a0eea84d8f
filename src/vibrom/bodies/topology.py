"""From a mesh file to scikit-fem's mesh: geometry of first or second order, and named groups."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import skfem

from vibrom.bodies.elements import KINDS
from vibrom.bodies.files.content import EDGES, FACES, SHAPES, Content
from vibrom.term import SceneError

# scikit-fem's corners of a hexahedron among those of a file.
HEXAHEDRON = (6, 2, 5, 7, 1, 3, 4, 0)
SAME_PLANE = 1e-9  # of the size of a plane body: how far a node may lie off its plane


def body_of(content: Content, path: str) -> tuple[str, np.ndarray, np.ndarray]:
    """The kind of a body's elements, their nodes (m, k) and all points (N, dim)."""
    dim = max((SHAPES[kind][0] for kind in content.elements), default=0)
    kinds = [kind for kind in content.elements if SHAPES[kind][0] == dim]
    if dim < 2:
        raise SceneError(f"body.mesh = {path} has no elements of a plane or solid body")
    if len(kinds) > 1:
        words = " and ".join(sorted(KINDS[kind].words for kind in kinds))
        raise SceneError(f"body.mesh = {path} mixes {words}; mesh it with one of them")
    nodes, points = np.concatenate(content.elements[kinds[0]]), content.points
    # Gmsh's format 2.2 has an element once for each of its groups.
    _, once = np.unique(np.sort(nodes, axis=1), axis=0, return_index=True)
    nodes = nodes[np.sort(once)]
    corners = np.sort(nodes[:, : SHAPES[kinds[0]][1]], axis=1)
    twice = (corners[:, 1:] == corners[:, :-1]).any(axis=1).sum()
    if twice:
        raise SceneError(
            f"body.mesh = {path}: a corner stands twice in {twice} of its {len(nodes)} elements; "
            "mesh the body with elements that have all corners"
        )
    if not np.isfinite(points[nodes]).all():
        raise SceneError(f"body.mesh = {path} has nodes whose place is no number; export it again")
    if dim == 2:
        off = np.ptp(points[np.unique(nodes), 2])
        if off > SAME_PLANE * np.ptp(points, axis=0).max():
            raise SceneError(
                f"body.mesh = {path} is a surface in space, {off:.3g} m deep along z; give a body "
                "in the plane of x and y, or a solid one"
            )
    return kinds[0], nodes, points[:, :dim]


def meshed(kind: str, nodes: np.ndarray, points: np.ndarray) -> tuple[skfem.Mesh, np.ndarray]:
    """Scikit-fem's mesh, and the vertex of each point (N,), -1 of those that are no corners."""
    corners = nodes[:, : SHAPES[kind][1]]
    used = np.unique(corners)
    vertex = np.full(len(points), -1)
    vertex[used] = np.arange(len(used))
    t = vertex[corners].T
    first = next(name for name in KINDS if KINDS[name].second == kind or name == kind)
    first = {"quad8": "quad", "hexahedron27": "hexahedron"}.get(kind, first)
    t = t[list(HEXAHEDRON)] if first == "hexahedron" else t
    mesh = KINDS[first].mesh(np.ascontiguousarray(points[used].T), np.ascontiguousarray(t))
    return (_curved(mesh, kind, nodes, points, vertex) if kind in EDGES else mesh), vertex


def _curved(
    mesh: skfem.Mesh, kind: str, nodes: np.ndarray, points: np.ndarray, vertex: np.ndarray
) -> skfem.Mesh:
    """The mesh whose edges, faces and elements pass through the nodes between the corners."""
    made = KINDS[kind].mesh.from_mesh(mesh)
    place, dofs = made.doflocs.copy(), made.dofs
    plane, corners = mesh.dim() == 2, vertex[nodes]
    edges, edge_dofs = (mesh.facets, dofs.facet_dofs) if plane else (mesh.edges, dofs.edge_dofs)
    count = SHAPES[kind][1]
    for number, pair in enumerate(EDGES[kind]):
        found = _find(edges, corners[:, pair].T, len(points))
        place[:, edge_dofs[0, found]] = points[nodes[:, count + number]].T
    count += len(EDGES[kind])
    for number, face in enumerate(FACES.get(kind, ())):
        found = _find(mesh.facets, corners[:, face].T, len(points))
        place[:, dofs.facet_dofs[0, found]] = points[nodes[:, count + number]].T
    if kind in ("quad9", "hexahedron27"):
        place[:, dofs.interior_dofs[0]] = points[nodes[:, -1]].T
    if kind in ("quad8", "hexahedron20"):
        fill(place, made)
    return replace(made, doflocs=place)


def fill(place: np.ndarray, mesh: skfem.Mesh) -> None:
    """Middles of faces and elements where serendipity shape functions have them."""
    local, refdom = mesh.dofs.element_dofs, mesh.elem.refdom
    count = refdom.nnodes
    if mesh.dim() == 2:
        corners, middles = local[:4], local[4:8]
        place[:, local[8]] = _middle(place, corners, middles)
        return
    edges = [set(edge) for edge in refdom.edges]
    for number, face in enumerate(refdom.facets):
        around = [count + k for k, edge in enumerate(edges) if edge <= set(face)]
        place[:, local[count + 12 + number]] = _middle(place, local[face], local[around])
    inside = -0.25 * place[:, local[:8]].sum(axis=1) + 0.25 * place[:, local[8:20]].sum(axis=1)
    place[:, local[26]] = inside


def _middle(place: np.ndarray, corners: np.ndarray, middles: np.ndarray) -> np.ndarray:
    return -0.25 * place[:, corners].sum(axis=1) + 0.5 * place[:, middles].sum(axis=1)


def _keys(nodes: np.ndarray, size: int) -> np.ndarray:
    """A number for each facet or edge, from up to three of its corners (k, m)."""
    lowest = np.sort(nodes, axis=0).astype(np.int64)
    twice = lowest[1:] == lowest[:-1]  # a triangle among quadrilaterals repeats a corner
    lowest[1:][twice] = size
    lowest = np.sort(lowest, axis=0)[:3]
    key = lowest[0]
    for row in lowest[1:]:
        key = key * size + row
    return key


def _find(known: np.ndarray, wanted: np.ndarray, size: int) -> np.ndarray:
    """Which of the known facets or edges (k, m) the wanted ones are, -1 where there is none."""
    keys, sought = _keys(known, size), _keys(wanted, size)
    order = np.argsort(keys)
    place = order[np.minimum(np.searchsorted(keys, sought, sorter=order), len(keys) - 1)]
    return np.where((keys[place] == sought) & (wanted >= 0).all(axis=0), place, -1)


def facets_of(
    mesh: skfem.Mesh, groups: Mapping[str, list[np.ndarray]], vertex: np.ndarray, path: str
) -> dict[str, np.ndarray]:
    """Group -> its facets, of those that have some. Nodes alone name the facets at the surface
    between them.
    """
    found: dict[str, np.ndarray] = {}
    surface = mesh.boundary_facets()
    for name, parts in groups.items():
        facets: list[np.ndarray] = []
        for part in parts:
            wanted = vertex[part].T
            if len(wanted) == 1:
                among = np.isin(mesh.facets[:, surface], wanted[wanted >= 0]).all(axis=0)
                facets.append(surface[among])
            elif len(wanted) == 2 and mesh.dim() == 3:
                continue
            elif len(wanted) <= len(mesh.facets):  # more corners are those of elements
                place = _find(mesh.facets, wanted, len(vertex))
                if (place < 0).any():
                    raise SceneError(
                        f"body.mesh = {path}: {(place < 0).sum()} of the {len(place)} facets of "
                        f"group {name!r} belong to no element; mesh the body once more"
                    )
                facets.append(place)
        if facets and len(whole := np.unique(np.concatenate(facets))):
            found[name] = whole
    return found


def points_of(
    basis: skfem.Basis,
    groups: Mapping[str, list[np.ndarray]],
    vertex: np.ndarray,
    boundaries: Mapping[str, np.ndarray],
) -> dict[str, np.ndarray]:
    """Group -> scikit-fem's dofs, of groups of nodes and edges that are no boundaries."""
    mesh, found = basis.mesh, {}
    for name, parts in groups.items():
        dofs: list[np.ndarray] = []
        for part in parts:
            wanted = vertex[part].T
            if len(wanted) == 1:
                dofs.append(basis.nodal_dofs[:, wanted[wanted >= 0]].ravel())
            elif len(wanted) == 2 and mesh.dim() == 3:
                place = _find(mesh.edges, wanted, len(vertex))
                place = place[place >= 0]
                dofs.append(basis.nodal_dofs[:, mesh.edges[:, place]].ravel())
                if len(basis.edge_dofs):
                    dofs.append(basis.edge_dofs[:, place].ravel())
        if name in boundaries:
            dofs.append(basis.get_dofs(boundaries[name]).all())
        whole = np.unique(np.concatenate(dofs)) if dofs else np.zeros(0, np.int64)
        if len(whole) and (name not in boundaries or len(dofs) > 1):
            found[name] = whole
    return found
