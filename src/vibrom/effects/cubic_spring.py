"""A spring from one node to the ground:  f(u) = k_1 u + k_3 u^3  [N] along one axis; k_3 > 0
hardens, k_3 < 0 softens.

The linear part joins the stiffness, and so the modes.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from vibrom.bodies.space import Space
from vibrom.config.kinds import Direction, Point
from vibrom.term import Force, Quartic, Term, force_kernel, tangent_kernel

STAGE = "forces"


@dataclass(frozen=True)
class CubicSpring:
    at: Point  # m, a node
    direction: Direction
    linear: float = 0.0  # N/m
    cubic: float = 0.0  # N/m^3

    def assemble(self, space: Space, base: Term) -> Term:
        dof = space.dof("effects.cubic_spring", self.at, self.direction)
        stiffness = (
            csr_matrix(([self.linear], ([dof], [dof])), shape=(space.size, space.size))
            if self.linear
            else None
        )
        spring = Force(
            lambda width: (_force, _tangent),
            np.array([[dof]]),
            np.array([[float(self.cubic)]]),
            quartic=lambda: (_potential(space.size, dof, self.cubic),),
            mean=lambda width: (_mean_force, _mean_tangent),
        )
        return Term(stiffness=stiffness, forces=(spring,) if self.cubic else ())


def _potential(size: int, dof: int, cubic: float) -> Quartic:
    """U = k_3 u^4/4  with  e = u^2  and  D = k_3/2."""
    one = np.ones((1, 1))
    at = csr_matrix(([1.0], ([0], [dof])), shape=(1, size))
    return Quartic(at, np.ones(1), 0.0 * one, one[None], 0.5 * cubic * one)


@force_kernel
def _force(q, v, dofs, table, f):
    for e in range(dofs.shape[0]):
        for w in range(q.shape[1]):
            f[dofs[e, 0], w] += table[e, 0] * q[dofs[e, 0], w] ** 3


@tangent_kernel
def _tangent(q, v, dofs, table, slots, scale_q, scale_v, values):
    for e in range(dofs.shape[0]):
        for w in range(q.shape[1]):
            values[slots[e, 0], w] += scale_q[w] * 3.0 * table[e, 0] * q[dofs[e, 0], w] ** 2


# (U(m + d) - U(m - d))/2d = k_3 m (m^2 + d^2) at the middle m of a step, d half of the way.


@force_kernel
def _mean_force(q, v, dofs, table, f):
    for e in range(dofs.shape[0]):
        for w in range(q.shape[1]):
            middle, half = q[dofs[e, 0], w], q[v.shape[0] + dofs[e, 0], w]
            f[dofs[e, 0], w] += table[e, 0] * middle * (middle**2 + half**2)


@tangent_kernel
def _mean_tangent(q, v, dofs, table, slots, scale_q, scale_v, values):
    for e in range(dofs.shape[0]):
        for w in range(q.shape[1]):
            middle, half = q[dofs[e, 0], w], q[v.shape[0] + dofs[e, 0], w]
            slope = 3.0 * middle**2 + half**2 + 2.0 * middle * half
            values[slots[e, 0], w] += scale_q[w] * table[e, 0] * slope
