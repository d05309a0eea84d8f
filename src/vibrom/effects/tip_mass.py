"""A point mass at one node:  M_ii += m  in all directions. It has no rotary inertia of its own."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from vibrom.bodies.space import AXES, Space
from vibrom.config.kinds import Point, Positive
from vibrom.term import Term

STAGE = "mass"


@dataclass(frozen=True)
class TipMass:
    at: Point  # m, a node
    mass: Positive  # kg

    def assemble(self, space: Space, base: Term) -> Term:
        axes = AXES[: space.dimension]
        dofs = [space.dof("effects.tip_mass", self.at, direction) for direction in axes]
        carried = np.zeros((space.size, len(axes)))
        carried[dofs, range(len(axes))] = self.mass
        entries = np.full(len(axes), self.mass)
        mass = csr_matrix((entries, (dofs, dofs)), shape=(space.size, space.size))
        return Term(mass=mass, carried=carried)
