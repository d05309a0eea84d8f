"""Pade approximants of series in x = |z|^2 with one denominator for all components.

    F(z) = sum_a z^a F_a = N(z) / D(x),    D = 1 + d_1 x + ... + d_L x^L,    N = D F truncated

D is the one that best makes the highest L coefficients of D F vanish, in every harmonic and every
component at once (least squares): with many components there is no choice that fits one of them by
a pole next to a zero. Source: Gonnet, Guettel, Trefethen, SIAM Review 55 (2013) 101, for what makes
an approximant robust; simultaneous approximants: Baker and Graves-Morris, chapter 8.
"""

import numpy as np

from vibrom.solvers.manifold.monomials import Monomials

FAR = 6.0


def denominator(
    monomials: Monomials, values: np.ndarray, top: int, degree: int, unit: float
) -> np.ndarray:
    """(degree + 1,) coefficients of D in x, of a series `values` (1 + l, m), the constant first,
    that is known to the degree `top`; `unit` is about the x within which it converges.
    """
    rows, right = [], []
    for one, other in monomials.powers[monomials.kept]:
        # The last coefficients of each harmonic that are known.
        if min(one, other) < degree or not top - 2 * degree < one + other <= top:
            continue
        below = monomials.index(np.array([one, other]) - np.arange(degree + 1)[:, None]) + 1
        weight = unit ** (0.5 * (one + other) - np.arange(degree + 1))
        columns = values[below] * weight[:, None]
        rows.append(columns[1:].T)
        right.append(-columns[0])
    if not rows or degree == 0:
        return np.eye(1, degree + 1)[0]
    a, b = np.concatenate(rows), np.concatenate(right)
    a, b = np.concatenate([a.real, a.imag]), np.concatenate([b.real, b.imag])
    found = np.linalg.lstsq(a, b, rcond=None)[0]
    return np.append(1.0, found) / unit ** np.arange(degree + 1)


def robust_denominator(
    monomials: Monomials, values: np.ndarray, top: int, degree: int, unit: float
) -> np.ndarray:
    """`denominator` of the highest degree, at most `degree`, that has no root near the positive
    axis, where the amplitudes are, within FAR times `unit`; 1 if there is none.
    """
    for lower in range(degree, 0, -1):
        found = denominator(monomials, values, top, lower, unit)
        roots = np.roots(found[::-1])
        if not ((roots.real > np.abs(roots.imag)) & (np.abs(roots) < FAR * unit)).any():
            return found
    return np.ones(1)


def of_circle(monomials: Monomials, series: np.ndarray) -> np.ndarray:
    """(1 + l,) a series in x as one in z, the constant first."""
    found = np.zeros(1 + len(monomials), complex)
    found[0] = series[0]
    for k in range(1, len(series)):
        found[monomials.index(np.array([k, k])) + 1] = series[k]
    return found


def numerator(monomials: Monomials, values: np.ndarray, top: int, series: np.ndarray) -> np.ndarray:
    """D F (1 + l, m), truncated at the degree `top`, of `values` F and the coefficients of D."""
    powers = np.pad(monomials.powers, ((1, 0), (0, 0)))
    found = values.copy()
    for k in range(1, len(series)):
        target = monomials.index(powers + k) + 1
        found[target[target > 0]] += series[k] * values[target > 0]
    found[powers.sum(axis=1) > top] = 0.0
    return found
