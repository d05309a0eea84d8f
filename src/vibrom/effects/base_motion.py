"""A moving support:  p = -M_all r,  the signal being the acceleration of the clamped edges [m/s^2]
along one axis (r, a unit translation).

All displacements are then relative to the support, which moves the body as a whole and strains
nothing: what other effects hold to the ground (springs, stops, mass-proportional damping) is held
to the support. M_all counts the clamped nodes' share of the mass. A support that moves by w
sin(Omega t) is the signal -w Omega^2 sin(Omega t). Source: Clough and Penzien, Dynamics of
Structures, 26-1.
"""

from dataclasses import dataclass

from vibrom.bodies.space import Space
from vibrom.config.kinds import Direction
from vibrom.effects import Load
from vibrom.term import Term

STAGE = "load"


@dataclass(frozen=True)
class BaseMotion(Load):
    direction: Direction

    def assemble(self, space: Space, base: Term) -> Term:
        carried = base.require("carried", "base_motion", "inertia")
        return self.acting(
            -carried[:, space.along("effects.base_motion.direction", self.direction)]
        )
