"""Linear isotropic elasticity:  K_ij = b int eps(N_i) : C : eps(N_j) dA,  b the thickness.

C : eps = lambda tr(eps) 1 + 2 mu eps,  mu = E/(2 (1 + nu)).  Plane strain: lambda = E nu/((1 + nu)
(1 - 2 nu)); plane stress: lambda = E nu/(1 - nu^2).
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from skfem.models.elasticity import lame_parameters, linear_elasticity, plane_stress

from vibrom.bodies.space import Space
from vibrom.config.kinds import PoissonRatio, Positive
from vibrom.term import Term

STAGE = "stiffness"


@dataclass(frozen=True)
class Elasticity:
    young_modulus: Positive  # Pa
    poisson_ratio: PoissonRatio
    plane: Literal["stress", "strain"] = "stress"

    def assemble(self, space: Space, base: Term) -> Term:
        stiffness = linear_elasticity(*self.lame()).assemble(space.basis)
        return Term(
            stiffness=space.matrix(space.thickness * stiffness),
            elastic=space.thickness * self.moduli(),
        )

    def lame(self) -> tuple[float, float]:
        """Lambda and mu [Pa]."""
        plane = plane_stress if self.plane == "stress" else lame_parameters
        return plane(self.young_modulus, self.poisson_ratio)

    def moduli(self) -> np.ndarray:
        """D (3, 3) [Pa]: (s11, s22, s12) over (e11, e22, 2 e12)."""
        first, shear = self.lame()
        direct = first + 2.0 * shear
        return np.array([[direct, first, 0.0], [first, direct, 0.0], [0.0, 0.0, shear]])
