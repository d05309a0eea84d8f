"""A traction on an edge that turns with it: `pressure` stays normal to the deformed edge (into the
body), `shear` tangential to it.

    F_a = b int N_a [-pressure (y', -x') + shear (x', y')] ds,   (x, y) = X + u, ' = d/ds along the
    edge with the body on its left

In the plane it is linear in u: p_0 = G X acts at rest and f = -G u is what turning adds, with a
non-symmetric G (Belytschko, Liu, Moran, Nonlinear Finite Elements for Continua and Structures,
6.4.5). It has no potential unless the edge's ends are held: it can make a body flutter (Beck's
column). It is constant: the signal of a scene drives other loads. A body in space has a face for
the edge, and pressure alone:  F_ai = -pressure int N_a cof(F)_iJ n_J dA  with the normal n at rest.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
import skfem

from vibrom.bodies.space import Space
from vibrom.config.kinds import Group
from vibrom.kernels.follower_pressure import gradient, slope, turned
from vibrom.term import Force, SceneError, Term, force_kernel, tangent_kernel

# int N_a dN_b/ds ds over a segment of two or three nodes; its length drops out.
NODES = {
    2: np.array([[-3.0, 3.0], [-3.0, 3.0]]) / 6,
    3: np.array([[-3.0, 4.0, -1.0], [-4.0, 0.0, 4.0], [1.0, -4.0, 3.0]]) / 6,
}

STAGE = "dead_load"


@dataclass(frozen=True)
class FollowerLoad:
    edge: Group  # of a plane body, or a face of one in space
    pressure: float = 0.0  # Pa
    shear: float = 0.0  # Pa, counter-clockwise around the body

    def assemble(self, space: Space, base: Term) -> Term:
        facets = space.boundary("effects.follower_load.edge", self.edge)
        nodes = space.basis.get_dofs(facets).all()
        if (space.number[nodes] < 0).all():
            cure = "is clamped; choose one that can move"
            raise SceneError(f"effects.follower_load.edge = {self.edge!r} {cure}")
        return self._in_space(space, facets) if space.dimension == 3 else self._in_plane(space)

    def _in_plane(self, space: Space) -> Term:
        nodes = space.segments(self.edge)
        dofs = nodes.reshape(len(nodes), -1)
        turn = np.array([[self.shear, -self.pressure], [self.pressure, self.shear]])
        matrix = space.thickness * np.kron(NODES[nodes.shape[1]], turn)  # G of every segment [N/m]
        load = np.zeros(space.basis.N)
        place = space.basis.doflocs[np.arange(dofs.shape[1]) % 2, dofs]
        np.add.at(load, dofs, place @ matrix.T)
        table = np.tile(-matrix.ravel(), (len(dofs), 1))
        return Term(
            dead_load=space.vector(load),
            forces=(
                Force(
                    lambda width: (_force, _tangent),
                    space.number[dofs],
                    table,
                    symmetric=False,
                    conservative=False,
                    quartic=tuple,
                ),
            ),
        )

    def _in_space(self, space: Space, facets: np.ndarray) -> Term:
        if self.shear:
            raise SceneError(
                f"effects.follower_load.shear = {self.shear:g} has no direction on the face of a "
                "body in space; leave it out"
            )
        element = space.scalar.elem
        if element.refdom.brefdom is None:
            raise SceneError("effects.follower_load acts on no wedges; mesh the body without them")
        degree = 3 if element.maxdeg <= 3 and not len(space.scalar.edge_dofs) else 5
        face = skfem.FacetBasis(space.basis.mesh, element, facets=facets, intorder=degree)
        beside = space.basis.mesh.f2t[0, facets]  # elements
        moment = self.pressure * face.normals * face.dx  # (3, facets, points)
        values = np.stack(
            [np.asarray(shape[0]) for shape in face.basis]
        )  # (shapes, facets, points)
        slopes = np.stack([shape[0].grad for shape in face.basis])
        shapes, count, points = values.shape
        load = np.zeros(space.basis.N)
        at_rest = np.einsum("afp,ifp->fai", values, -moment).reshape(count, -1)
        np.add.at(load, space.basis.element_dofs[:, beside].T, at_rest)
        parts = [moment, values, slopes.reshape(3 * shapes, count, points)]
        table = np.concatenate(parts).transpose(1, 2, 0).reshape(count, -1)
        turning = Force(
            lambda width: _surface(shapes, points),
            np.ascontiguousarray(space.element_dofs[beside]),
            np.ascontiguousarray(table),
            symmetric=False,
            conservative=False,
        )
        return Term(dead_load=space.vector(load), forces=(turning,))


@force_kernel
def _force(q, v, dofs, table, f):
    for e in range(dofs.shape[0]):
        for i in range(dofs.shape[1]):
            for j in range(dofs.shape[1]):
                if dofs[e, i] >= 0 and dofs[e, j] >= 0:
                    for w in range(q.shape[1]):
                        f[dofs[e, i], w] += table[e, i * dofs.shape[1] + j] * q[dofs[e, j], w]


@tangent_kernel
def _tangent(q, v, dofs, table, slots, scale_q, scale_v, values):
    for e in range(dofs.shape[0]):
        for entry in range(slots.shape[1]):
            if slots[e, entry] >= 0:
                for w in range(q.shape[1]):
                    values[slots[e, entry], w] += scale_q[w] * table[e, entry]


@cache
def _surface(shapes: int, points: int) -> tuple[Callable, Callable]:
    """Force and tangent for a number of shape functions and of points of a facet."""
    stride = 3 + 4 * shapes

    @force_kernel
    def follower(q, v, dofs, table, f):
        h = np.zeros((3, 3))
        for e in range(dofs.shape[0]):
            for w in range(q.shape[1]):
                for point in range(points):
                    at = point * stride
                    gradient(q, w, dofs, table, e, at + 3 + shapes, h)
                    for i in range(3):
                        push = turned(h, table, e, at, i)
                        for a in range(shapes):
                            if dofs[e, 3 * a + i] >= 0:
                                f[dofs[e, 3 * a + i], w] += table[e, at + 3 + a] * push

    @tangent_kernel
    def follower_tangent(q, v, dofs, table, slots, scale_q, scale_v, values):
        h, size = np.zeros((3, 3)), 3 * shapes
        for e in range(dofs.shape[0]):
            for w in range(q.shape[1]):
                for point in range(points):
                    at = point * stride
                    gradient(q, w, dofs, table, e, at + 3 + shapes, h)
                    for i in range(3):
                        for k in range(3):
                            for column in range(shapes):
                                first, change = at + 3 + shapes + 3 * column, 0.0
                                for j in range(3):
                                    change += slope(h, table, e, at, i, k, j) * table[e, first + j]
                                for a in range(shapes):
                                    slot = slots[e, (3 * a + i) * size + 3 * column + k]
                                    if slot >= 0:
                                        share = table[e, at + 3 + a] * change
                                        values[slot, w] += scale_q[w] * share

    return follower, follower_tangent
