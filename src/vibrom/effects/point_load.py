"""A load at one node:  p = e_dof  (1 N per unit of the signal), in a fixed direction."""

from dataclasses import dataclass

import numpy as np

from vibrom.bodies.space import Space
from vibrom.config.kinds import Direction, Point
from vibrom.effects import Load
from vibrom.term import Term

STAGE = "load"


@dataclass(frozen=True)
class PointLoad(Load):
    at: Point  # m, a node
    direction: Direction

    def assemble(self, space: Space, base: Term) -> Term:
        load = np.zeros(space.size)
        load[space.dof("effects.point_load", self.at, self.direction)] = 1.0
        return self.acting(load)
