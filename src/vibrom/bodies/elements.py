"""Elements by the names that mesh files use, and bases of them.

The quadrature of the stiffness integrates the linear stiffness of an undistorted element exactly
and has no zero-energy modes: 2 and 3 Gauss points along each side of quadrilaterals and hexahedra,
1 and 3 points of triangles, 1 and 4 of tetrahedra, 3 x 2 of wedges. The mass of simplices takes
more. Points and weights are scikit-fem's.
"""

from typing import NamedTuple

import numpy as np
import skfem
from skfem.quadrature import get_quadrature
from skfem.refdom import RefLine, RefTri

Quadrature = tuple[np.ndarray, np.ndarray]  # (dim, points) and weights (points,)


class Kind(NamedTuple):
    """An element of a mesh, and of displacements where those are of its own order."""

    mesh: type[skfem.Mesh]  # of its geometry
    element: type[skfem.Element]  # of a displacement
    stiffness: int  # degree of the polynomials that its quadrature integrates; 0: one point
    mass: int
    second: str = ""  # the kind of second order with the same corners
    words: str = ""


KINDS = {
    "triangle": Kind(skfem.MeshTri1, skfem.ElementTriP1, 0, 2, "triangle6", "triangles"),
    "triangle6": Kind(skfem.MeshTri2, skfem.ElementTriP2, 2, 4, "", "triangles of second order"),
    "quad": Kind(skfem.MeshQuad1, skfem.ElementQuad1, 3, 3, "quad9", "quadrilaterals"),
    "quad8": Kind(skfem.MeshQuad2, skfem.ElementQuadS2, 5, 5, "", "quadrilaterals of 8 nodes"),
    "quad9": Kind(skfem.MeshQuad2, skfem.ElementQuad2, 5, 5, "", "quadrilaterals of 9 nodes"),
    "tetra": Kind(skfem.MeshTet1, skfem.ElementTetP1, 0, 2, "tetra10", "tetrahedra"),
    "tetra10": Kind(skfem.MeshTet2, skfem.ElementTetP2, 2, 4, "", "tetrahedra of second order"),
    "hexahedron": Kind(skfem.MeshHex1, skfem.ElementHex1, 3, 3, "hexahedron20", "hexahedra"),
    "hexahedron20": Kind(skfem.MeshHex2, skfem.ElementHexS2, 5, 5, "", "hexahedra of 20 nodes"),
    "hexahedron27": Kind(skfem.MeshHex2, skfem.ElementHex2, 5, 5, "", "hexahedra of 27 nodes"),
    "wedge": Kind(skfem.MeshWedge1, skfem.ElementWedge1, 2, 2, "", "wedges"),
}


class Bases(NamedTuple):
    """Bases of a mesh."""

    vector: skfem.Basis  # with the quadrature of the stiffness
    scalar: skfem.Basis  # the same, one component
    mass: skfem.Basis  # vector-valued, with that of the mass


def bases(mesh: skfem.Mesh, kind: str) -> Bases:
    """Those of displacements of a kind, which may be of higher order than the mesh."""
    chosen = KINDS[kind]
    element = chosen.element()
    stiffness, mass = (quadrature(element, degree) for degree in (chosen.stiffness, chosen.mass))
    vector = skfem.Basis(mesh, skfem.ElementVector(element), quadrature=stiffness)
    same = chosen.stiffness == chosen.mass
    return Bases(
        vector,
        vector.with_element(element),
        vector if same else skfem.Basis(mesh, vector.elem, quadrature=mass),
    )


def quadrature(element: skfem.Element, degree: int) -> Quadrature:
    """Points and weights in the reference element."""
    corners = element.refdom.p
    if degree == 0:
        return corners.mean(axis=1)[:, None], np.array(
            [1.0 / np.prod([*range(2, len(corners) + 1)])]
        )
    if corners.shape[1] == 6:  # a wedge: triangle times line; scikit-fem takes far more points
        (x, w), (z, v) = get_quadrature(RefTri, degree), get_quadrature(RefLine, 3)
        points = np.concatenate([np.repeat(x, z.shape[1], axis=1), np.tile(z, x.shape[1])])
        return points, np.repeat(w, len(v)) * np.tile(v, len(w))
    return get_quadrature(element, degree)
