"""Series in real coordinates.

    y = (u, w):    u_i = z_i + z_(d+i),    w_i = lambda_i z_i + lambda_(d+i) z_(d+i)

so that small motions have  u' = w  and  w' = -omega^2 u - c w, as modal coordinates have.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vibrom.solvers.manifold.monomials import Monomials


@dataclass(frozen=True)
class RealCoordinates:
    """The change of coordinates, and what it makes of polynomials."""

    monomials: Monomials
    eigenvalues: np.ndarray  # (2d,) 1/s

    @cached_property
    def forward(self) -> np.ndarray:
        """(2d, 2d): y of z."""
        d = len(self.eigenvalues) // 2
        one = np.eye(d)
        first, second = np.diag(self.eigenvalues[:d]), np.diag(self.eigenvalues[d:])
        return np.block([[one, one], [first, second]])

    @cached_property
    def powers(self) -> np.ndarray:
        """(1 + l, 2d) exponents of the real monomials, the constant first."""
        constant = np.zeros((1, len(self.eigenvalues)), np.int64)
        return np.concatenate([constant, self.monomials.powers])

    @cached_property
    def change(self) -> np.ndarray:
        """(1 + l, 1 + l) complex: coefficients in y of coefficients in z, the constant first."""
        inverse, l = np.linalg.inv(self.forward), len(self.monomials)
        found = np.zeros((1 + l, 1 + l), complex)
        found[0, 0] = 1.0
        axis = self.monomials.powers.argmax(axis=1)
        # raised[j, k]: where monomial k goes by one more factor y_j, the constant's place first
        raised = np.vstack([np.arange(len(self.eigenvalues)), self.monomials.raised.T])
        for k in range(l):
            below = found[:, self.monomials.lowered[axis[k], k] + 1]
            for j, weight in enumerate(inverse[axis[k]]):
                inside = raised[:, j] >= 0
                found[raised[inside, j] + 1, k + 1] += weight * below[inside]
        return found

    def real(self, values: np.ndarray) -> np.ndarray:
        """(1 + l, ...) of a real function's coefficients (1 + l, ...) in z."""
        return np.tensordot(self.change, values, 1).real
