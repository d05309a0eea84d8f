"""Deformed bodies: nodes, polygons and the outline of the mesh, from the structure of a scene. A
body in space is drawn by its surface.
"""

import numpy as np
import xarray as xr


def displacement(structure: xr.Dataset, free: np.ndarray) -> np.ndarray:
    """(node, axes) displacement [m] of every node from that of the free dofs; clamped dofs stay
    where they are, mid-side nodes are left out.
    """
    full = np.zeros_like(structure["node"].values, dtype=float)
    node, axis = structure["dof_node"].values, structure["dof_axis"].values
    full[node[node >= 0], axis[node >= 0]] = free[node >= 0]
    return full


def rest(structure: xr.Dataset) -> np.ndarray:
    """(node, axes) positions [m] that displacements are measured from: those of the mesh, or of the
    equilibrium under the dead load.
    """
    position = structure["node"].values
    return (
        position + displacement(structure, structure["equilibrium"].values)
        if "equilibrium" in structure
        else position
    )


def view(structure: xr.Dataset) -> np.ndarray:
    """(2, axes) from coordinates to those of the page: a plane body as it is, one in space from the
    front, the right and above.
    """
    if structure.sizes["axis"] == 2:
        return np.eye(2)
    turn, tilt = np.radians([30.0, 20.0])
    right = np.array([np.cos(turn), 0.0, -np.sin(turn)])
    toward = np.array([np.sin(turn) * np.cos(tilt), np.sin(tilt), np.cos(turn) * np.cos(tilt)])
    return np.array([right, np.cross(toward, right)])


def labels(structure: xr.Dataset | None) -> dict[str, str]:
    """What a panel's axes are."""
    if structure is None or structure.sizes["axis"] == 2:
        return {"xlabel": "x [m]", "ylabel": "y [m]"}
    return {"xlabel": "across [m]", "ylabel": "up [m]"}


def polygons(
    structure: xr.Dataset, free: np.ndarray, scale: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """(polygon, corner, 2) on the page [m] of the deformed elements or, of a body in space, of the
    faces of its surface, the nearest last; and what numbers they have among those.
    """
    position, seen = rest(structure) + scale * displacement(structure, free), view(structure)
    corners = position[_cells(structure)]
    if len(seen[0]) == 2:
        return corners, np.arange(len(corners))
    near = np.argsort(corners.mean(axis=1) @ np.cross(*seen), kind="stable")
    return corners[near] @ seen.T, near


def _cells(structure: xr.Dataset) -> np.ndarray:
    return structure["face_node" if "face_node" in structure else "element_node"].values


def magnitude(structure: xr.Dataset, free: np.ndarray) -> np.ndarray:
    """Mean size of the displacement [m] at the corners of each element, or face of the surface."""
    return np.linalg.norm(displacement(structure, free), axis=1)[_cells(structure)].mean(axis=1)


SHARP = 0.9  # cosine between the normals of faces that meet at an edge which is drawn


def outline(structure: xr.Dataset) -> list[np.ndarray]:
    """Closed loops of nodes: the edges that belong to one element only, chained. Of a body in space
    the edges of its surface, one by one.
    """
    corners = _cells(structure)
    if "face_node" in structure:
        return _edges(structure["node"].values, corners)
    count = corners.shape[1]
    edges = np.concatenate([corners[:, [k, (k + 1) % count]] for k in range(count)])
    sides, times = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    beside: dict[int, list[int]] = {}
    for a, b in sides[times == 1].tolist():
        beside.setdefault(a, []).append(b)
        beside.setdefault(b, []).append(a)
    loops = []
    while beside:
        loop = [min(beside)]
        while ahead := [node for node in beside[loop[-1]] if node not in loop]:
            loop.append(ahead[0])
        for node in loop:
            del beside[node]
        loops.append(np.array([*loop, loop[0]]))
    return loops


def _edges(node: np.ndarray, faces: np.ndarray) -> list[np.ndarray]:
    """The edges at which the surface is not smooth."""
    count = faces.shape[1]
    across = node[faces[:, count // 2]] - node[faces[:, 0]]
    normal = np.cross(across, node[faces[:, -1]] - node[faces[:, 1]])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    edges = np.sort(np.concatenate([faces[:, [k, (k + 1) % count]] for k in range(count)]), axis=1)
    owner = np.tile(np.arange(len(faces)), count)
    real = edges[:, 0] != edges[:, 1]
    edges, owner = edges[real], owner[real]
    order = np.lexsort(edges.T)
    pairs = order[: len(order) // 2 * 2].reshape(-1, 2)  # every edge has two faces
    cosine = np.abs(np.einsum("ij,ij->i", *normal[owner[pairs]].transpose(1, 0, 2)))
    return list(edges[pairs[cosine < SHARP, 0]])


def outlines(structure: xr.Dataset, free: np.ndarray, scale: float = 1.0) -> list[np.ndarray]:
    """The deformed outline on the page [m], loop by loop, each (points, 2)."""
    position = (rest(structure) + scale * displacement(structure, free)) @ view(structure).T
    return [position[loop] for loop in outline(structure)]


def longest_side(structure: xr.Dataset) -> float:
    """[m]."""
    return float(np.ptp(structure["node"].values, axis=0).max())


def magnification(structure: xr.Dataset, free: np.ndarray, share: float = 0.15) -> float:
    """1, or the 1-2-5 factor that makes a displacement too small to see about `share` of the body's
    longest side.
    """
    largest = float(np.abs(displacement(structure, free)).max())
    wanted = share * longest_side(structure) / largest if largest > 0 else 1.0
    if wanted < 5:
        return 1.0
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(power * max(step for step in (1, 2, 5) if step * power <= wanted))
