"""Weight:  p_0 = M_all (g_x, g_y),  a dead load on every mass, the clamped nodes'
share included.

The body then oscillates about the shape that its weight gives it: modes, release states and
everything recorded are measured from there, and damping and modal load are those of the loaded
body's modes.
"""

from dataclasses import dataclass

from vibrom.bodies.space import Space
from vibrom.term import Term

STAGE = "dead_load"


@dataclass(frozen=True)
class Gravity:
    x: float = 0.0  # m/s^2
    y: float = -9.81  # m/s^2

    def assemble(self, space: Space, base: Term) -> Term:
        return Term(dead_load=base.require("carried", "gravity", "inertia") @ [self.x, self.y])
