"""Linear isotropic elasticity:  K_ij = b int eps(N_i) : C : eps(N_j) dA,  b the thickness.

C : eps = lambda tr(eps) 1 + 2 mu eps,  mu = E/(2 (1 + nu)).  Plane strain, and a body in space,
where b = 1: lambda = E nu/((1 + nu) (1 - 2 nu)); plane stress: lambda = E nu/(1 - nu^2).
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
    plane: Literal["stress", "strain"] = "stress"  # of a plane body

    def assemble(self, space: Space, base: Term) -> Term:
        lame = self.lame(space.dimension)
        return Term(
            stiffness=space.matrix(
                space.thickness * linear_elasticity(*lame).assemble(space.basis)
            ),
            elastic=space.thickness * moduli(*lame, space.dimension),
        )

    def lame(self, dimension: int) -> tuple[float, float]:
        """Lambda and mu [Pa]."""
        thin = self.plane == "stress" and dimension == 2
        found = plane_stress if thin else lame_parameters
        return found(self.young_modulus, self.poisson_ratio)


def moduli(first: float, shear: float, dimension: int) -> np.ndarray:
    """D [Pa] (3, 3): (s11, s22, s12) over (e11, e22, 2 e12); (6, 6) of a body in space."""
    strains = dimension * (dimension + 1) // 2
    found = np.diag(np.full(strains, shear))
    found[:dimension, :dimension] = first
    direct = range(dimension)
    found[direct, direct] = first + 2.0 * shear
    return found
