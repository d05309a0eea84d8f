"""Linear isotropic elasticity:  K_ij = b int eps(N_i) : D : eps(N_j) dA,  b the thickness.

Plane stress:  D11 = E/(1 - nu^2), D12 = nu D11.  Plane strain:  D11 = E(1 - nu)/((1 + nu)(1 - 2
nu)), D12 = nu D11/(1 - nu).  D33 = E/(2(1 + nu)).
"""

from dataclasses import dataclass

import numpy as np
import skfem
from skfem.helpers import sym_grad

from vibrom.bodies.space import Space
from vibrom.term import Term


@dataclass(frozen=True)
class Elasticity:
    young_modulus: float  # Pa
    poisson_ratio: float
    plane: str = "stress"  # or strain

    def assemble(self, space: Space, base: Term) -> Term:
        elastic = space.thickness * self.moduli()
        d11, d12, d33 = elastic[0, 0], elastic[0, 1], elastic[2, 2]

        @skfem.BilinearForm
        def form(u, v, w):
            e, f = sym_grad(u), sym_grad(v)
            return (
                d11 * (e[0, 0] * f[0, 0] + e[1, 1] * f[1, 1])
                + d12 * (e[0, 0] * f[1, 1] + e[1, 1] * f[0, 0])
                + 4.0 * d33 * e[0, 1] * f[0, 1]
            )

        return Term(stiffness=space.matrix(form.assemble(space.basis)), elastic=elastic)

    def moduli(self) -> np.ndarray:
        """D (3, 3) [Pa]: (s11, s22, s12) over (e11, e22, 2 e12)."""
        young, nu = self.young_modulus, self.poisson_ratio
        if self.plane == "stress":
            d11, d12 = young / (1 - nu**2), nu * young / (1 - nu**2)
        else:
            d11 = young * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
            d12 = d11 * nu / (1 - nu)
        return np.array([[d11, d12, 0.0], [d12, d11, 0.0], [0.0, 0.0, young / (2 * (1 + nu))]])
