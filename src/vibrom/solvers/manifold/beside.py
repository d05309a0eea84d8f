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

from vibrom.solvers.manifold.canonical import slopes
from vibrom.solvers.manifold.covectors import Covectors
from vibrom.solvers.manifold.parametrisation import Manifold
from vibrom.solvers.manifold.pencil import Border
from vibrom.solvers.manifold.tangent import Degree, TangentSeries
from vibrom.solvers.threads import mapped, worth


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
    right = [(part @ masters.shapes.T).T for part in (pencil.mass, pencil.damping)]
    left = [(part.T @ masters.left.T).T for part in (pencil.mass, pencil.damping)]
    size = 1 + len(monomials)
    state = np.zeros((2, size, pencil.size), complex)
    measured = np.zeros((len(values), size, size), complex)  # Y_i B X of all pairs
    for k in range(monomials.order):
        degree = Degree.of(monomials, k)
        lower = _lower(degree, manifold.dynamics, push, tangents, state)
        h = sum((part.next(degree) for part in forces), np.zeros(lower[0].shape, complex))
        missing = np.zeros((len(degree.targets), len(values)), complex)
        np.subtract.at(missing, degree.row, measured[:, degree.right + 1, degree.left].T)

        def solve(row: int, degree=degree, lower=lower, h=h, missing=missing) -> None:
            target = degree.targets[row]
            sigma, (a, b) = sums[target] + 1j * frequency, (part[row] for part in lower)
            f = -h[row] - pencil.mass @ (b + sigma * a) - pencil.damping @ a
            factor = (sigma + values)[:, None]
            border = Border(
                (factor * right[0] + right[1]).T,
                factor * left[0] + left[1],
                left[0] @ masters.shapes.T,
                missing[row] - left[0] @ a,
                masters.pinned,
            )
            state[0, target], extra = pencil.solve_bordered(
                sigma, f if target else f + load, border
            )
            state[1, target] = sigma * state[0, target] + a + extra @ masters.shapes

        mapped(solve, range(len(degree.targets)), worth(pencil.size))
        here = degree.targets
        measured[:, :, here] = sum(m @ part[here].T for m, part in zip(measures, state))
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
    found = []
    for part, tangent in zip(state, tangents):
        total = along @ part
        for series, product, slope in zip(push, times, tangent):
            total += series[0] * slope[degree.targets] + product @ slope
        found.append(total)
    return found
