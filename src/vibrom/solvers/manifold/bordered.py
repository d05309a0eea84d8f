"""The pencil at any s, bordered by the masters of a manifold.

    A(s) w + sum_i [(s + lambda_i) M + C] phi_i r_i = f
    psi_i' [(s + lambda_i) M + C] w + psi_i' M sum_j phi_j r_j = g_i

It is regular where A(s) is singular. All its matrices are conjugate where s is, so that systems
whose s are conjugate share a factor.
"""

from __future__ import annotations

import numpy as np

from vibrom.solvers.manifold.masters import Masters
from vibrom.solvers.manifold.pencil import Border, Pencil
from vibrom.solvers.threads import mapped, worth

SAME = 1e-10  # of the largest |s|: difference up to which two are the same


class Bordered:
    """The systems of some masters."""

    def __init__(self, pencil: Pencil, masters: Masters):
        self.pencil, self.masters = pencil, masters
        parts = (pencil.mass, pencil.damping)
        self.right = [(part @ masters.shapes.T).T for part in parts]  # M phi_i, C phi_i
        self.left = [(part.T @ masters.left.T).T for part in parts]
        self.corner = self.left[0] @ masters.shapes.T
        self.pinned = masters.pinned

    def at(self, s: complex, held: np.ndarray | slice = slice(None)) -> Border:
        """The border of the masters `held`."""
        factor = (s + self.masters.eigenvalues[held])[:, None]
        columns, rows = (
            factor * mass[held] + damping[held] for mass, damping in (self.right, self.left)
        )
        pairs = np.unique(np.arange(len(self.corner))[held] % len(self.pinned))
        return Border(columns, rows, self.corner[held][:, held], self.pinned[pairs])

    def solve(self, s: np.ndarray, f: np.ndarray, g: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """w (t, n) and r (t, 2d), of all masters, for right sides f (t, n) and g (t, 2d)."""
        mirror, below = list(self.masters.mirror), s.imag < 0.0

        def turned(f: np.ndarray, g: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            """Of the conjugate system, where s is in the lower half of the plane."""
            f[below], g[below] = f[below].conj(), g[below][:, mirror].conj()
            return f, g

        upper = np.where(below, s.conj(), s)
        size = max(np.abs(s).max(), np.finfo(float).tiny)
        _, first, group = np.unique(
            np.round(upper / (SAME * size)), return_index=True, return_inverse=True
        )
        f, g = turned(f.astype(complex), g.astype(complex))

        def some(k: int) -> None:
            rows, here = group == k, upper[first[k]]
            f[rows], g[rows] = self.pencil.solve_bordered(here, f[rows], g[rows], self.at(here))

        mapped(some, range(len(first)), worth(self.pencil.size))
        return turned(f, g)
