"""The body: its mesh, its finite-element space, what is clamped and where it is watched.

Everything about shape functions, quadrature and degrees of freedom comes from scikit-fem; this file and `effects/` are its only users.
Free displacements are numbered by reverse Cuthill-McKee, so that every matrix of the scene is a narrow band.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import skfem
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee

from vibrom.term import SceneError

# name -> element and the polynomial degree that its quadrature integrates (2 x 2, 3 x 3 Gauss points)
ELEMENTS = {"bilinear": (skfem.ElementQuad1, 3), "quadratic": (skfem.ElementQuad2, 5), "serendipity": (skfem.ElementQuadS2, 5)}
EDGES = {"left": (0, 0), "right": (0, 1), "bottom": (1, 0), "top": (1, 1)}
AXES = {"x": 0, "y": 1}


@dataclass(frozen=True)
class Space:
    """basis: vector-valued, with the quadrature of the stiffness; scalar: the same element, one component; free: scikit-fem's number of
    each free dof (n,); thickness [m]; probes: name -> free dof."""

    basis: skfem.Basis
    scalar: skfem.Basis
    free: np.ndarray
    thickness: float
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
    def element_dofs(self) -> np.ndarray:
        """(elements, d) free dof of each local dof, -1 where clamped; local dof 2a + i is component i of shape function a."""
        number = np.full(self.basis.N, -1, dtype=np.int64)
        number[self.free] = np.arange(self.size)
        return np.ascontiguousarray(number[self.basis.element_dofs].T)

    @property
    def dof_axis(self) -> np.ndarray:
        axis = np.empty(self.basis.N, dtype=np.int64)
        axis[self.basis.element_dofs] = (np.arange(self.basis.Nbfun) % 2)[:, None]
        return axis[self.free]

    @property
    def dof_location(self) -> np.ndarray:
        """(n, 2) where each free dof sits [m]."""
        return self.basis.doflocs[:, self.free].T


def build(body: dict[str, Any]) -> Space:
    """The space of a scene's `body` block (a rectangle of quadrilaterals)."""
    (columns, rows), (element, order) = body["cells"], ELEMENTS[body["element"]]
    mesh = skfem.MeshQuad.init_tensor(np.linspace(0, body["length"], columns + 1), np.linspace(0, body["height"], rows + 1))
    basis = skfem.Basis(mesh, skfem.ElementVector(element()), intorder=order)
    scalar = basis.with_element(element())
    clamped = [basis.get_dofs(_edge(body, name)).all() for name in body["clamped"]]
    free = np.setdiff1d(np.arange(basis.N), np.concatenate(clamped) if clamped else [])
    pattern = csr_matrix(skfem.BilinearForm(lambda u, v, w: u[0] * v[0] + u[1] * v[1] + u[0] * v[1] + u[1] * v[0]).assemble(basis))
    free = free[reverse_cuthill_mckee(pattern[free][:, free].tocsr(), symmetric_mode=True)]
    space = Space(basis, scalar, free, float(body["width"]), {})
    return Space(basis, scalar, free, float(body["width"]), {name: _probe(space, name, where) for name, where in body["probes"].items()})


def _edge(body: dict[str, Any], name: str):
    axis, end = EDGES[name]
    at = end * (body["length"], body["height"])[axis]
    return lambda x: np.isclose(x[axis], at, atol=1e-9 * body["length"])


def _probe(space: Space, name: str, where: dict[str, Any]) -> int:
    distance = np.linalg.norm(space.dof_location - np.asarray(where["at"], float), axis=1)
    distance[space.dof_axis != AXES[where["direction"]]] = np.inf
    nearest = int(np.argmin(distance))
    if distance[nearest] > 1e-6:
        at = space.dof_location[nearest].tolist()
        raise SceneError(f"body.probes.{name}.at = {where['at']} is no free node; the nearest one is at {at}")
    return nearest
