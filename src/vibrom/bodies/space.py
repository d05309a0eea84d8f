"""The body: its mesh, its finite-element space, what is clamped and where it is watched.

Everything about shape functions, quadrature and degrees of freedom comes from scikit-fem; this file
and `effects/` are its only users. Free displacements are numbered line by line across the body, so
that every matrix of the scene is a narrow band.

A body with a `rise` r is an arch: the straight body, each of whose points is moved up by 4 r x/L (1
- x/L). Edges and points (of probes and effects) are named in the straight body's coordinates.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import skfem
from scipy.sparse import csr_matrix

from vibrom.term import SceneError

# name -> element and the polynomial degree that its quadrature integrates (2 x 2, 3 x 3 Gauss
# points)
ELEMENTS = {
    "bilinear": (skfem.ElementQuad1, 3),
    "quadratic": (skfem.ElementQuad2, 5),
    "serendipity": (skfem.ElementQuadS2, 5),
}
EDGES = {"left": (0, 0), "right": (0, 1), "bottom": (1, 0), "top": (1, 1)}
AXES = {"x": 0, "y": 1}


@dataclass(frozen=True)
class Space:
    """basis: vector-valued, with the quadrature of the stiffness; scalar: the same element, one
    component; free: scikit-fem's number of each free dof (n,); thickness [m]; straight: where all
    dofs sit in the straight body (2, N) [m]; sides: clamped or not, edge -> the numbers of its
    facets; probes: name -> free dof.
    """

    basis: skfem.Basis
    scalar: skfem.Basis
    free: np.ndarray
    thickness: float
    straight: np.ndarray
    sides: dict[str, np.ndarray]
    probes: dict[str, int]

    @property
    def size(self) -> int:
        return len(self.free)

    def matrix(self, full: Any) -> csr_matrix:
        """An assembled matrix on the free dofs."""
        return csr_matrix(full)[self.free][:, self.free].tocsr()

    def vector(self, full: np.ndarray) -> np.ndarray:
        return np.asarray(full)[self.free]

    @property
    def number(self) -> np.ndarray:
        """(N,) the free dof of each of scikit-fem's, -1 where it is clamped."""
        number = np.full(self.basis.N, -1, dtype=np.int64)
        number[self.free] = np.arange(self.size)
        return number

    @property
    def element_dofs(self) -> np.ndarray:
        """(elements, d) free dof of each local dof, -1 where clamped; local dof 2a + i is component
        i of shape function a.
        """
        return np.ascontiguousarray(self.number[self.basis.element_dofs].T)

    @property
    def axis(self) -> np.ndarray:
        """(N,) direction of each of scikit-fem's dofs: 0 along x, 1 along y."""
        axis = np.empty(self.basis.N, dtype=np.int64)
        axis[self.basis.element_dofs] = (np.arange(self.basis.Nbfun) % 2)[:, None]
        return axis

    @property
    def dof_axis(self) -> np.ndarray:
        return self.axis[self.free]

    @property
    def dof_location(self) -> np.ndarray:
        """(n, 2) where each free dof sits [m]."""
        return self.basis.doflocs[:, self.free].T

    def edge(self, name: str) -> np.ndarray:
        """(segments, k, 2) scikit-fem's dofs (x and y) of the k = 2 or 3 nodes of each segment of
        an edge, with the body on their left.
        """
        facets, axis = self.sides[name], 1 - EDGES[name][0]
        ends = self.basis.mesh.facets[:, facets]
        along = self.straight[axis, self.basis.nodal_dofs[0, ends]]
        # Counter-clockwise: the bottom runs along x, the right edge along y, the others back.
        swap = (along[0] > along[1]) == (name in ("bottom", "right"))
        ends = np.where(swap, ends[::-1], ends)
        nodes = [self.basis.nodal_dofs[:, ends[0]], self.basis.nodal_dofs[:, ends[1]]]
        if len(self.basis.facet_dofs):
            nodes.insert(1, self.basis.facet_dofs[:, facets])
        return np.stack(nodes).transpose(2, 0, 1)

    def dof(self, key: str, at: list[float], direction: str) -> int:
        """The free dof at a point of the straight body, for the entry `key` of the scene."""
        there = self.straight[:, self.free].T
        distance = np.linalg.norm(there - np.asarray(at, float), axis=1)
        distance[self.dof_axis != AXES[direction]] = np.inf
        nearest = int(np.argmin(distance))
        if distance[nearest] > 1e-6:
            raise SceneError(
                f"{key}.at = {at} is no free node; the nearest one is at {np.round(there[nearest], 9).tolist()}"
            )
        return nearest


def build(body: dict[str, Any]) -> Space:
    """The space of a scene's `body` block (a rectangle of quadrilaterals, straight or arched)."""
    (columns, rows), (element, order) = body["cells"], ELEMENTS[body["element"]]
    mesh = skfem.MeshQuad.init_tensor(
        np.linspace(0, body["length"], columns + 1), np.linspace(0, body["height"], rows + 1)
    )
    basis = skfem.Basis(mesh, skfem.ElementVector(element()), intorder=order)
    straight, sides = (
        basis.doflocs,
        {name: mesh.facets_satisfying(_edge(body, name), boundaries_only=True) for name in EDGES},
    )
    clamped = [basis.get_dofs(_edge(body, name)).all() for name in body["clamped"]]
    if body.get("rise"):
        x, y = mesh.p
        basis = skfem.Basis(
            replace(
                mesh,
                doflocs=np.array(
                    [x, y + 4 * body["rise"] * x / body["length"] * (1 - x / body["length"])]
                ),
            ),
            skfem.ElementVector(element()),
            intorder=order,
        )
    scalar = basis.with_element(element())
    free = np.setdiff1d(np.arange(basis.N), np.concatenate(clamped) if clamped else [])
    # Reverse Cuthill-McKee leaves the nodes of a line in the order in which it met them: a band up
    # to twice as wide.
    x, y = np.round(straight[:, free] / body["length"], 9)
    free = free[np.lexsort((y, x) if columns >= rows else (x, y))]
    space = Space(basis, scalar, free, float(body["width"]), straight, sides, {})
    return replace(
        space,
        probes={
            name: space.dof(f"body.probes.{name}", where["at"], where["direction"])
            for name, where in body["probes"].items()
        },
    )


def _edge(body: dict[str, Any], name: str):
    axis, end = EDGES[name]
    at = end * (body["length"], body["height"])[axis]
    return lambda x: np.isclose(x[axis], at, atol=1e-9 * body["length"])
