"""A traction on an edge that turns with it: `pressure` stays normal to the deformed edge (into the
body), `shear` tangential to it.

    F_a = b int N_a [-pressure (y', -x') + shear (x', y')] ds,   (x, y) = X + u, ' = d/ds along the
    edge with the body on its left

It is linear in u: p_0 = G X acts at rest and f = -G u is what turning adds, with a non-symmetric G
(Belytschko, Liu, Moran, Nonlinear Finite Elements for Continua and Structures, 6.4.5). It has no
potential unless the edge's ends are held: it can make a body flutter (Beck's column). It is
constant: the signal of a scene drives other loads.
"""

from dataclasses import dataclass

import numpy as np

from vibrom.bodies.space import Space
from vibrom.config.kinds import Edge
from vibrom.term import Force, SceneError, Term, force_kernel, tangent_kernel

# int N_a dN_b/ds ds over a segment of two or three nodes; its length drops out.
NODES = {
    2: np.array([[-3.0, 3.0], [-3.0, 3.0]]) / 6,
    3: np.array([[-3.0, 4.0, -1.0], [-4.0, 0.0, 4.0], [1.0, -4.0, 3.0]]) / 6,
}

STAGE = "dead_load"


@dataclass(frozen=True)
class FollowerLoad:
    edge: Edge
    pressure: float = 0.0  # Pa
    shear: float = 0.0  # Pa, counter-clockwise around the body

    def assemble(self, space: Space, base: Term) -> Term:
        nodes = space.segments(self.edge)
        dofs = nodes.reshape(len(nodes), -1)
        if (space.number[dofs] < 0).all():
            cure = "is clamped; choose one that can move"
            raise SceneError(f"effects.follower_load.edge = {self.edge!r} {cure}")
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
                    quartic=tuple,
                ),
            ),
        )


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
