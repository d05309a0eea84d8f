"""A load that drives one mode of the undamped linear body:  p = M phi_k  (modal force 1 N per
kg^1/2 and unit of the signal).
"""

from dataclasses import dataclass

from vibrom.bodies.space import Space
from vibrom.config.kinds import Count
from vibrom.effects import Load
from vibrom.solvers.full.modes import eigenmodes
from vibrom.term import SceneError, Term

STAGE = "load"


@dataclass(frozen=True)
class ModalLoad(Load):
    mode: Count = 1  # counted from one

    def assemble(self, space: Space, base: Term) -> Term:
        mass = base.require("mass", "modal_load", "inertia")
        base.require("stiffness", "modal_load", "elasticity")
        if self.mode >= space.size:
            raise SceneError(
                f"effects.modal_load.mode = {self.mode} is no mode of this body; choose 1 to "
                f"{space.size - 1}"
            )
        return self.acting(mass @ eigenmodes(base, self.mode).shape[self.mode - 1])
