"""What a mesh file holds, whatever its format."""

from dataclasses import dataclass, field

import numpy as np

# Elements by meshio's names -> their dimension and how many corners come first among their nodes.
SHAPES = {
    "vertex": (0, 1),
    "line": (1, 2),
    "line3": (1, 2),
    "triangle": (2, 3),
    "triangle6": (2, 3),
    "quad": (2, 4),
    "quad8": (2, 4),
    "quad9": (2, 4),
    "tetra": (3, 4),
    "tetra10": (3, 4),
    "hexahedron": (3, 8),
    "hexahedron20": (3, 8),
    "hexahedron27": (3, 8),
    "wedge": (3, 6),
}
# Corners of the edge in whose middle each further node lies.
_RING = ((0, 1), (1, 2), (2, 3), (3, 0))
_LAYERS = (*_RING, (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
EDGES = {
    "triangle6": ((0, 1), (1, 2), (2, 0)),
    "quad8": _RING,
    "quad9": _RING,
    "tetra10": ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)),
    "hexahedron20": _LAYERS,
    "hexahedron27": _LAYERS,
}
# Corners of the face in whose middle each node after those lies.
FACES = {
    "hexahedron27": (
        (0, 4, 7, 3),
        (1, 2, 6, 5),
        (0, 1, 5, 4),
        (2, 3, 7, 6),
        (0, 3, 2, 1),
        (4, 5, 6, 7),
    ),
}


class Unreadable(ValueError):
    """What is wrong with a file, in the words after `cannot be read:`."""


def foreign_to(kind: str) -> str:
    """Why elements of this type are refused."""
    return (
        f"its elements of type {kind} are not known here; mesh it with triangles, quadrilaterals, "
        "tetrahedra or hexahedra, of first or second order, or wedges"
    )


@dataclass
class Content:
    """Nodes, elements and named groups."""

    points: np.ndarray  # (N, 3), in the unit of the file
    # kind -> [(m, k) nodes of elements]: corners, then middles of edges in the order of EDGES, of
    # faces and of the element
    elements: dict[str, list[np.ndarray]] = field(default_factory=dict)
    # name -> [(m, k) corners]: of facets, edges (k = 2) or single nodes (k = 1)
    groups: dict[str, list[np.ndarray]] = field(default_factory=dict)
