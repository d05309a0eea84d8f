"""Consistent mass:  M_ij = rho b int N_i . N_j dA,  b the thickness."""

from dataclasses import dataclass

import numpy as np
import skfem
from skfem.helpers import dot

from vibrom.bodies.space import Space
from vibrom.config.kinds import Positive
from vibrom.term import Term

STAGE = "mass"


@dataclass(frozen=True)
class Inertia:
    density: Positive  # kg/m^3

    def assemble(self, space: Space, base: Term) -> Term:
        mass = skfem.BilinearForm(
            lambda u, v, w: self.density * space.thickness * dot(u, v)
        ).assemble(space.mass or space.basis)
        return Term(
            mass=space.matrix(mass),
            carried=space.vector(mass @ np.eye(space.dimension)[space.axis]),
        )
