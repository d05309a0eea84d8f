"""A moving support:  p = -M_all r,  the signal being the acceleration of the clamped edges [m/s^2]
along one axis (r, a unit translation).

All displacements are then relative to the support, which moves the body as a whole and strains
nothing: what other effects hold to the ground (springs, stops, mass-proportional damping) is held
to the support. M_all counts the clamped nodes' share of the mass. A support that moves by w
sin(Omega t) is the signal -w Omega^2 sin(Omega t). Source: Clough and Penzien, Dynamics of
Structures, 26-1.
"""

from dataclasses import dataclass

from vibrom.bodies.space import AXES, Space
from vibrom.term import Term


@dataclass(frozen=True)
class BaseMotion:
    direction: str  # x or y

    def assemble(self, space: Space, base: Term) -> Term:
        return Term(
            load=-base.require("carried", "base_motion", "inertia")[:, AXES[self.direction]]
        )
