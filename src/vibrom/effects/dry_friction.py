"""Dry friction between one node and the ground, along one axis:

    f = F sign(v)  [N]  where |v| >= v_0,    F x (3 - x^2)/2,  x = v/v_0,  where it is slower

Coulomb's law, but that a node which it would hold creeps, with 3 F/2 v_0 as a viscous damper. The
smaller v_0, the closer to that law, and the harder the steps in which the velocity changes its
sign.
"""

from dataclasses import dataclass

import numpy as np

from vibrom.bodies.space import Space
from vibrom.config.kinds import Direction, Point, Positive
from vibrom.term import Force, Term, force_kernel, tangent_kernel

STAGE = "forces"


@dataclass(frozen=True)
class DryFriction:
    at: Point  # m, a node
    direction: Direction
    force: Positive  # N, while it slides
    velocity: Positive  # m/s, v_0

    def assemble(self, space: Space, base: Term) -> Term:
        dof = space.dof("effects.dry_friction", self.at, self.direction)
        table = np.array([[float(self.force), float(self.velocity)]])
        kernels = _force, _tangent
        rub = Force(lambda width: kernels, np.array([[dof]]), table, conservative=False)
        return Term(forces=(rub,))


@force_kernel
def _force(q, v, dofs, table, f):
    for e in range(dofs.shape[0]):
        for w in range(q.shape[1]):
            x = min(max(v[dofs[e, 0], w] / table[e, 1], -1.0), 1.0)
            f[dofs[e, 0], w] += table[e, 0] * 0.5 * x * (3.0 - x * x)


@tangent_kernel
def _tangent(q, v, dofs, table, slots, scale_q, scale_v, values):
    for e in range(dofs.shape[0]):
        for w in range(q.shape[1]):
            x = min(max(v[dofs[e, 0], w] / table[e, 1], -1.0), 1.0)
            values[slots[e, 0], w] += scale_v[w] * table[e, 0] / table[e, 1] * 1.5 * (1.0 - x * x)
