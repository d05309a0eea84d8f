"""A point mass at one node:  M_ii += m  in both directions. It has no rotary inertia of its own."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from vibrom.bodies.space import AXES, Space
from vibrom.term import Term


@dataclass(frozen=True)
class TipMass:
    at: list[float]  # m, a node
    mass: float  # kg

    def assemble(self, space: Space, base: Term) -> Term:
        dofs, carried = (
            [space.dof("effects.tip_mass", self.at, direction) for direction in AXES],
            np.zeros((space.size, len(AXES))),
        )
        carried[dofs, range(len(AXES))] = self.mass
        return Term(
            mass=csr_matrix(
                (np.full(len(AXES), self.mass), (dofs, dofs)), shape=(space.size, space.size)
            ),
            carried=carried,
        )
