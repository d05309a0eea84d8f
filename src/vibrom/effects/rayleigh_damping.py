"""Rayleigh damping:  C = a M + b K.

`damping_ratio` zeta of the first mode omega_1 is met by the mass part:  a = 2 zeta omega_1 - b
omega_1^2  [1/s].

Both parts are of the undeformed body, and of all its motion: a M v slows the body as a whole down,
as a fluid around it might, and b K v takes energy from the rotation of parts that have turned far,
which no material does. Use b where rotations are small, and else `kelvin_voigt`, which is the same
in small motions.
"""

from dataclasses import dataclass

from vibrom.bodies.space import Space
from vibrom.config.kinds import NonNegative, Ratio
from vibrom.solvers.full.modes import eigenmodes
from vibrom.term import Term

STAGE = "damping"


@dataclass(frozen=True)
class RayleighDamping:
    damping_ratio: Ratio  # of the first mode
    stiffness_factor: NonNegative = 0.0  # s

    def assemble(self, space: Space, base: Term) -> Term:
        mass = base.require("mass", "rayleigh_damping", "inertia")
        stiffness = base.require("stiffness", "rayleigh_damping", "elasticity")
        first = eigenmodes(base, 1).frequency[0]
        damping = (2.0 * self.damping_ratio * first - self.stiffness_factor * first**2) * mass
        return Term(
            damping=damping + self.stiffness_factor * stiffness
            if self.stiffness_factor
            else damping
        )
