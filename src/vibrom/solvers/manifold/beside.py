"""What a load adds to the displacement beside a manifold, to first order in the load.

    q = W(z) + X(z) e^(i Omega t),    z' = R(z) + S(z) e^(i Omega t),    Y_i B X = 0

Modes that are not the manifold's own answer the load as well, and in a deformed body any load
reaches them. With sigma = s + i Omega and what lower degrees contribute, a, b and h, the last from
the tangent of the force,

    A(sigma) X_a = p_a - h_a - M [b_a + (DV S)_a] - (sigma M + C) [a_a + (DW S)_a].

Far below the frequencies of those modes X hardly depends on Omega: that of the manifold's own first
mode serves for all.
"""

from __future__ import annotations

import numpy as np

from vibrom.solvers.manifold.bordered import Bordered
from vibrom.solvers.manifold.canonical import slopes
from vibrom.solvers.manifold.covectors import Covectors
from vibrom.solvers.manifold.parametrisation import Manifold
from vibrom.solvers.manifold.tangent import Degree, TangentSeries


def beside(
    manifold: Manifold, covectors: Covectors, load: np.ndarray, frequency: float
) -> np.ndarray:
    """X (1 + l, n) complex of a load p (n,), the constant first, to one degree less than W."""
    monomials, pencil, masters = manifold.monomials, manifold.pencil, manifold.masters
    values, sums = masters.eigenvalues, np.append(0.0, monomials.powers @ masters.eigenvalues)
    push = covectors.y @ load  # S (2d, 1 + l)
    tangents = [slopes(monomials, part) for part in (manifold.displacement, manifold.velocity)]
    forces = [TangentSeries(part, monomials) for part in manifold.forces]
    y, x = (part.reshape(-1, pencil.size).T for part in (covectors.y, covectors.x))
    measures = [
        part.T.reshape(covectors.y.shape)
        for part in (pencil.damping.T @ y + pencil.mass.T @ x, pencil.mass.T @ y)
    ]
    bordered = Bordered(pencil, masters)
    size = 1 + len(monomials)
    state = np.zeros((2, size, pencil.size), complex)
    measured = np.zeros((len(values), size, size), complex)  # Y_i B X of all pairs
    for k in range(monomials.order):
        degree = Degree.of(monomials, k)
        here, sigma = degree.targets, sums[degree.targets] + 1j * frequency
        a, b = _lower(degree, manifold.dynamics, push, tangents, state)
        f = -(pencil.mass @ (b + sigma[:, None] * a).T).T - (pencil.damping @ a.T).T
        f += 0.0 if k else load
        for part in forces:
            f -= part.next(degree)
        missing = -a @ bordered.left[0].T
        np.subtract.at(missing, degree.row, measured[:, degree.right + 1, degree.left].T)
        state[0, here], extra = bordered.solve(sigma, f, missing)
        state[1, here] = sigma[:, None] * state[0, here] + a + extra @ masters.shapes
        known = 1 + monomials.of_degree(monomials.order - k).start  # what meets it up to the order
        measured[:, :known, here] = sum(m[:, :known] @ x[here].T for m, x in zip(measures, state))
        for part in forces:
            part.complete(degree, state[0, here])
    return state[0]


def _lower(
    degree: Degree,
    dynamics: np.ndarray,
    push: np.ndarray,
    tangents: list[np.ndarray],
    state: np.ndarray,
) -> list[np.ndarray]:
    """The sums a + DW S and b + DV S (t, n)."""
    along, times = degree.along(dynamics), [degree.times(series) for series in push]
    here, found = degree.range, []
    for part, tangent in zip(state, tangents):
        total = along @ part[: here.start]
        for series, product, slope in zip(push, times, tangent):
            total += series[0] * slope[here] + product @ slope[: here.start]
        found.append(total)
    return found
