"""Weight:  p_0 = M_all (g_x, g_y, g_z),  a dead load on every mass, the clamped nodes'
share included.

The body then oscillates about the shape that its weight gives it: modes, release states and
everything recorded are measured from there, and damping and modal load are those of the loaded
body's modes.
"""

from dataclasses import dataclass

from vibrom.bodies.space import Space
from vibrom.term import SceneError, Term

STAGE = "dead_load"


@dataclass(frozen=True)
class Gravity:
    x: float = 0.0  # m/s^2
    y: float = -9.81  # m/s^2
    z: float = 0.0  # m/s^2, of a body in space

    def assemble(self, space: Space, base: Term) -> Term:
        carried = base.require("carried", "gravity", "inertia")
        if self.z and space.dimension == 2:
            raise SceneError(
                f"effects.gravity.z = {self.z:g} pulls out of the plane of the body; leave it out"
            )
        return Term(dead_load=carried @ [self.x, self.y, self.z][: space.dimension])
