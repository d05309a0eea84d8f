"""Deformed bodies: nodes, quadrilaterals and the outline of the mesh, from the structure of a
scene.
"""

import numpy as np
import xarray as xr


def displacement(structure: xr.Dataset, free: np.ndarray) -> np.ndarray:
    """(node, 2) displacement [m] of every node from that of the free dofs; clamped dofs stay where
    they are, mid-side nodes are left out.
    """
    full = np.zeros_like(structure["node"].values, dtype=float)
    node, axis = structure["dof_node"].values, structure["dof_axis"].values
    full[node[node >= 0], axis[node >= 0]] = free[node >= 0]
    return full


def rest(structure: xr.Dataset) -> np.ndarray:
    """(node, 2) positions [m] that displacements are measured from: those of the mesh, or of the
    equilibrium under the dead load.
    """
    position = structure["node"].values
    return (
        position + displacement(structure, structure["equilibrium"].values)
        if "equilibrium" in structure
        else position
    )


def quadrilaterals(structure: xr.Dataset, free: np.ndarray, scale: float = 1.0) -> np.ndarray:
    """(element, 4, 2) corners [m] of the deformed elements."""
    return (rest(structure) + scale * displacement(structure, free))[
        structure["element_node"].values
    ]


def magnitude(structure: xr.Dataset, free: np.ndarray) -> np.ndarray:
    """(element,) mean size of the displacement [m] at the corners of each element."""
    return np.linalg.norm(displacement(structure, free), axis=1)[
        structure["element_node"].values
    ].mean(axis=1)


def outline(structure: xr.Dataset) -> list[np.ndarray]:
    """Closed loops of nodes: the edges that belong to one element only, chained."""
    corners = structure["element_node"].values
    edges = np.concatenate([corners[:, [k, (k + 1) % 4]] for k in range(4)])
    seen: dict[tuple[int, int], int] = {}
    for a, b in edges:
        seen[(min(a, b), max(a, b))] = seen.get((min(a, b), max(a, b)), 0) + 1
    beside: dict[int, list[int]] = {}
    for (a, b), count in seen.items():
        if count == 1:
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


def outlines(structure: xr.Dataset, free: np.ndarray, scale: float = 1.0) -> list[np.ndarray]:
    """The deformed outline [m], loop by loop, each (points, 2)."""
    position = rest(structure) + scale * displacement(structure, free)
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
