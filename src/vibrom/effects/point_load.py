"""A load at one node:  p = e_dof  (1 N per unit of the signal), in a fixed direction."""

from dataclasses import dataclass

import numpy as np

from vibrom.bodies.space import Space
from vibrom.term import Term


@dataclass(frozen=True)
class PointLoad:
    at: list[float]  # m, a node
    direction: str  # x or y

    def assemble(self, space: Space, base: Term) -> Term:
        load = np.zeros(space.size)
        load[space.dof("effects.point_load", self.at, self.direction)] = 1.0
        return Term(load=load)
