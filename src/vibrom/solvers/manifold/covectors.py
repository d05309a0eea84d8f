"""Covectors that measure a perturbation along a manifold.

    Y_i(z) = (y_i, x_i):    Y_i B d_j W = delta_ij,    Y_i B x = 0  where x decays onto it

B x = (C q + M v, M q). A load p u pushes the motion by S_i u = y_i' p u along the manifold,
whatever the signal u; the rest of it stays beside. They obey

    DY_i R + Y_i (A + DF(W)) = sum_j dR_i/dz_j Y_j B,

or degree by degree, with sigma = lambda_i - s and what lower degrees contribute, e and g,

    A(sigma)' y_ia = -g_ia - sigma M' e_ia,    x_ia = sigma y_ia + e_ia.

Where damping is proportional to the mass, they are those of the symplectic form (`canonical`), and
need no linear systems.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vibrom.solvers.manifold.bordered import Bordered
from vibrom.solvers.manifold.canonical import slopes
from vibrom.solvers.manifold.parametrisation import Manifold
from vibrom.solvers.manifold.pencil import Pencil
from vibrom.solvers.manifold.tangent import Degree, TangentSeries


@dataclass(frozen=True)
class Covectors:
    """Coefficients, the constant first, to one degree less than those of the manifold."""

    y: np.ndarray  # (2d, 1 + l, n) complex
    x: np.ndarray  # (2d, 1 + l, n) complex

    def truncated(self, count: int) -> Covectors:
        """The first coefficients of each."""
        return Covectors(self.y[:, :count], self.x[:, :count])


def of_push(manifold: Manifold, push: np.ndarray) -> Covectors:
    """x_i = sum_j dR_i/dz_j y_j - Dy_i R  of y = `push` (2d, 1 + l, n)."""
    monomials, values = manifold.monomials, manifold.masters.eigenvalues
    rates, x = slopes(monomials, manifold.dynamics.T), np.zeros_like(push)
    sums = np.append(0.0, monomials.powers @ values)
    for k in range(monomials.order):
        degree = Degree.of(monomials, k)
        here, along = degree.range, degree.along(manifold.dynamics)
        for i in range(len(push)):
            x[i, here] = (values[i] - sums[here, None]) * push[i, here]
            x[i, here] -= along @ push[i, : here.start]
            for j in range(len(push)):
                x[i, here] += degree.times(rates[j, :, i]) @ push[j, : here.start]
    return Covectors(push, x)


def carried(manifold: Manifold) -> Covectors:
    """By the equations themselves: right for any damping and any tangent."""
    return _Carried(manifold).run()


class _Carried:
    """The coefficients as they are found, degree by degree."""

    def __init__(self, manifold: Manifold):
        self.manifold, monomials = manifold, manifold.monomials
        pencil = manifold.pencil
        self.values = manifold.masters.eigenvalues
        turned = (pencil.mass, pencil.damping, pencil.stiffness)
        self.turned = Pencil(*(part.T.tocsr() for part in turned))
        masters = manifold.masters
        turned_masters = replace(masters, shapes=masters.left, left=masters.shapes)
        self.bordered = Bordered(self.turned, turned_masters)
        shape = (len(self.values), 1 + len(monomials), pencil.size)
        self.y, self.x = np.zeros(shape, complex), np.zeros(shape, complex)
        self.rates = slopes(monomials, manifold.dynamics.T)  # dR_i/dz_j
        self.tangents = [
            slopes(monomials, part) for part in (manifold.displacement, manifold.velocity)
        ]
        self.measured = np.zeros((shape[0], shape[0], shape[1], len(monomials)), complex)
        self.sums = np.append(0.0, monomials.powers @ self.values)
        self.conjugate = np.append(0, monomials.conjugate + 1)

    def run(self) -> Covectors:
        manifold, mirror = self.manifold, self.manifold.masters.mirror
        first = [i for i in range(len(mirror)) if i <= mirror[i]]
        forces = [[TangentSeries(f, manifold.monomials) for f in manifold.forces] for _ in first]
        for k in range(manifold.monomials.order):
            degree = Degree.of(manifold.monomials, k)
            along = degree.along(manifold.dynamics)
            for i, force in zip(first, forces):
                self._solve(i, degree, along, force)
            there = self.conjugate[degree.targets]
            for i in first:
                for part in (self.y, self.x):
                    part[mirror[i], there] = part[i, degree.targets].conj()
        return Covectors(self.y, self.x)

    def _solve(
        self, i: int, degree: Degree, along: np.ndarray, forces: list[TangentSeries]
    ) -> None:
        turned, masters, targets = self.turned, self.manifold.masters, degree.targets
        lower = slice(targets[0])
        e, f = (-(along @ part[i, lower]) for part in (self.y, self.x))
        for j in range(len(self.values)):
            times = degree.times(self.rates[j, :, i])
            e, f = e + times @ self.y[j, lower], f + times @ self.x[j, lower]
        g = sum(
            (part.next(degree) for part in forces), (turned.damping @ e.T + turned.mass @ f.T).T
        )
        sigma = self.values[i] - self.sums[targets]
        f = -g - sigma[:, None] * (turned.mass @ e.T).T
        missing = self._missing(i, degree) - e @ self.bordered.left[0].T
        self.y[i, targets], extra = self.bordered.solve(sigma, f, missing)
        # `extra` is zero but for rounding, except where the constant is normalised.
        self.x[i, targets] = sigma[:, None] * self.y[i, targets] + e + extra @ masters.left
        self._measure(i, targets)
        for part in forces:
            part.complete(degree, self.y[i, targets])

    def _missing(self, i: int, degree: Degree) -> np.ndarray:
        """(t, 2d): what Y_i B d_j W of the known coefficients lacks of delta_ij."""
        found = np.zeros((len(degree.targets), len(self.y)), complex)
        if degree.targets[0] == 0:
            found[0, i] = 1.0
            return found
        products = self.measured[i, :, degree.left, degree.right]
        np.subtract.at(found, degree.row, products)
        return found

    def _measure(self, i: int, targets: np.ndarray) -> None:
        """Y_i B d_j W of new coefficients with all of the tangents'."""
        turned, y, x = self.turned, self.y[i, targets].T, self.x[i, targets].T
        first, second = (turned.damping @ y + turned.mass @ x).T, (turned.mass @ y).T
        shape, rate = self.tangents
        products = shape @ first.T + rate @ second.T  # (2d, 1 + l, t)
        self.measured[i][:, targets] = products.transpose(0, 2, 1)[:, :, 1:]
