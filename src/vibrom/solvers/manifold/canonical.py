"""The symplectic form on a manifold, what it makes of a load, and coordinates in which it is plain.

    Omega_ij(z) = d_i W' M d_j V - d_j W' M d_i V,    sum_j Omega_ij S_j = d_i W' p

S_i u is what a load p u adds to z_i': the push along the manifold, the rest being symplectically
normal to it. Where damping is proportional to the mass, motion near the manifold keeps that
splitting, and S is exact to first order in the load.

For one pair in normal form, z' = z g(x) with x = |z|^2, the action of the closed orbits gives a
better coordinate than z itself:

    X = int_0^x Omega(x) / Omega(0) dx,    z~ = z sqrt(X/x),    X' = 2 Re g dX/dlnx

It grows along a family of orbits even where their first harmonic turns back, where series in x end
with a branch point. Under damping C = c M the action decays by exactly c, whatever the amplitude.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import csr_matrix, lil_matrix

from vibrom.solvers.manifold.monomials import Monomials
from vibrom.solvers.manifold.parametrisation import Manifold

NOTHING = 1e-7  # relative size below which a coefficient of the form is rounding


def derivative(monomials: Monomials, values: np.ndarray, axis: int) -> np.ndarray:
    """d/dz_axis of a series `values` (l, ...): (1 + l, ...), the constant first."""
    found = np.zeros((1 + len(monomials), *values.shape[1:]), values.dtype)
    lower = monomials.lowered[axis]
    factor = monomials.powers[:, axis].reshape(-1, *(1,) * (values.ndim - 1))
    rising = monomials.powers[:, axis] > 0
    found[lower[rising] + 1] = factor[rising] * values[rising]  # each place once
    return found


def slopes(monomials: Monomials, values: np.ndarray) -> np.ndarray:
    """(2d, 1 + l, ...) derivatives of a series (l, ...) along each coordinate."""
    axes = range(len(monomials.mirror))
    return np.stack([derivative(monomials, values, axis) for axis in axes])


def symplectic_form(manifold: Manifold, mass: csr_matrix) -> np.ndarray:
    """Omega (2d, 2d, 1 + l) complex, the constant first, to one degree less than the manifold."""
    monomials, pair = manifold.monomials, len(manifold.masters.eigenvalues)
    gram = manifold.displacement @ (mass @ manifold.velocity.T)
    gram = gram - gram.T
    one, other = np.nonzero(
        np.add.outer(monomials.degrees, monomials.degrees) <= monomials.order + 1
    )
    form = np.zeros((pair, pair, 1 + len(monomials)), complex)
    for i in range(pair):
        for j in range(i + 1, pair):
            factor = monomials.powers[one, i] * monomials.powers[other, j]
            there = factor > 0
            powers = monomials.powers[one[there]] + monomials.powers[other[there]]
            powers[:, i] -= 1
            powers[:, j] -= 1
            place = np.where(powers.sum(axis=1) == 0, 0, monomials.index(powers) + 1)
            np.add.at(form[i, j], place, factor[there] * gram[one[there], other[there]])
            form[j, i] = -form[i, j]
    return form


def symplectic_push(manifold: Manifold, form: np.ndarray) -> np.ndarray:
    """S (2d, 1 + l, n) complex: z_i' += sum_a z^a S_ia . p u, the constant first."""
    monomials, pair = manifold.monomials, len(form)
    tangents = slopes(monomials, manifold.displacement)
    first = np.linalg.inv(form[:, :, 0])
    # Sizes are compared where both sides of a product count alike, at the scale of the series.
    scale = convergence_scale(manifold) ** np.append(0, monomials.degrees)
    size = np.abs(form * scale)
    terms = np.where(size > NOTHING * size.max(), form, 0.0)[:, :, 1:]
    push = np.zeros_like(tangents)
    push[:, 0] = np.tensordot(first, tangents[:, 0], 1)
    if not terms.any():
        return np.tensordot(first, tangents, 1)
    mirror = list(manifold.masters.mirror)
    for degree in range(1, monomials.order):
        pairs = monomials.pairs(degree)
        targets = np.unique(np.arange(len(monomials))[monomials.of_degree(degree)])
        targets = targets[monomials.kept[targets]]
        right = tangents[:, targets + 1].copy()
        for i in range(pair):
            for j in range(pair):
                right[i] -= terms[i, j, targets, None] * push[j, 0]
                mix = np.zeros((len(targets), targets[0]), complex)
                mix[np.searchsorted(targets, pairs.target), pairs.left] = terms[i, j, pairs.right]
                right[i] -= mix @ push[j, 1 : 1 + targets[0]]
        push[:, targets + 1] = np.tensordot(first, right, 1)
        mirrors = monomials.conjugate[targets]
        push[:, mirrors + 1] = push[np.ix_(mirror, targets + 1)].conj()
    return push


def sizes(manifold: Manifold) -> np.ndarray:
    """(order,) largest coefficient of the displacement of each degree."""
    length, degrees = np.linalg.norm(manifold.displacement, axis=1), manifold.monomials.degrees
    return np.array([length[degrees == k].max() for k in range(1, degrees[-1] + 1)])


def convergence_scale(manifold: Manifold) -> float:
    """|z| at which no degree contributes more than the first; one of a linear body."""
    found = sizes(manifold) / sizes(manifold)[0]
    ratios = [part ** (-1.0 / k) for k, part in enumerate(found[1:], start=1) if part > 1e-300]
    return min(ratios, default=1.0)


def convergence_radius(manifold: Manifold) -> float:
    """|z| within which the series seem to converge: the slope of the logarithm of their
    coefficients over the upper half of the degrees; infinite of a linear body.
    """
    found = sizes(manifold)
    degree = np.arange(1, len(found) + 1)
    upper = (degree > len(found) // 2) & (found > 1e-300)
    if upper.sum() < 3:
        return float("inf")
    return float(np.exp(-np.polyfit(degree[upper], np.log(found[upper]), 1)[0]))


def action_coordinates(manifold: Manifold, form: np.ndarray) -> Manifold:
    """The same manifold of one pair in normal form, in z~."""
    monomials = manifold.monomials
    count = monomials.order // 2 + 1
    circle = np.array([[k, k] for k in range(count)])
    place = np.concatenate([[0], monomials.index(circle[1:]) + 1])
    density = (form[0, 1, place] / form[0, 1, 0]).real
    unit = (
        convergence_scale(manifold) ** 2
    )  # series in x over this unit have coefficients of order one
    density = density * unit ** np.arange(count)
    action = np.append(0.0, density / np.arange(1, count + 1))[: count + 1]  # X(x)
    inverse = _reversed(action)  # x(X)
    ratio = inverse[1:]  # x / X
    change = lil_matrix((len(monomials), len(monomials)))
    for a, (one, other) in enumerate(monomials.powers):
        series = _power(ratio, 0.5 * (one + other))
        steps = np.arange((monomials.order - one - other) // 2 + 1)
        target = monomials.index(np.array([one, other]) + steps[:, None])
        change[target, a] = series[steps] / unit**steps
    rate = _rate(manifold, action, inverse, unit, count)
    change, kept = change.tocsr(), np.nonzero(monomials.kept)[0]
    return replace(
        manifold,
        forces=tuple(part.changed(change[kept][:, kept]) for part in manifold.forces),
        displacement=change @ manifold.displacement,
        velocity=change @ manifold.velocity,
        dynamics=rate,
    )


def _rate(
    manifold: Manifold, action: np.ndarray, inverse: np.ndarray, unit: float, count: int
) -> np.ndarray:
    """R of z~' = z~ [Re g dlnX/dlnx + i Im g], in X."""
    monomials = manifold.monomials
    powers = np.array([[k + 1, k] for k in range((monomials.order + 1) // 2)])
    place = monomials.index(powers)
    g = manifold.dynamics[0, place] * unit ** np.arange(len(place))
    slope = _product(action[1:] * np.arange(1, count + 1), _power(action[1:], -1.0))
    of_x = _product(g.real, slope) + 1j * np.pad(g.imag, (0, count - len(g)))[:count]
    of_action = _composed(of_x, inverse)[: len(place)] / unit ** np.arange(len(place))
    rate = np.zeros_like(manifold.dynamics)
    rate[0, place] = of_action
    rate[1, monomials.conjugate[place]] = of_action.conj()
    return rate


def _product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Of two power series, to the length of the second."""
    return np.convolve(a, b)[: len(b)]


def _power(a: np.ndarray, exponent: float) -> np.ndarray:
    """a(x)^exponent of a power series that begins with one."""
    found = np.zeros_like(a)
    found[0] = 1.0
    for k in range(1, len(a)):
        j = np.arange(1, k + 1)
        found[k] = np.sum((exponent * j - (k - j)) * a[j] * found[k - j]) / k
    return found


def _composed(a: np.ndarray, inner: np.ndarray) -> np.ndarray:
    """a(h(x)) of power series, h(0) = 0, to the length of a."""
    h = inner[: len(a)]
    found = np.zeros_like(a)
    for coefficient in a[::-1]:
        found = np.convolve(found, h)[: len(a)]
        found[0] += coefficient
    return found


def _reversed(a: np.ndarray) -> np.ndarray:
    """The series h with a(h(x)) = x, of a(x) = x + ..."""
    found = np.zeros_like(a)
    found[1] = 1.0
    for _ in range(len(a)):
        error = _composed(a, found)
        error[1] -= 1.0
        found = found - error
    return found
