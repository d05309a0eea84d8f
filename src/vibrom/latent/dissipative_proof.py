"""Upper bounds of the conditions of a dissipative fit, over the whole phase plane.

    F(r, a) = sum_m r^m P_m(a),    P_m a trigonometric polynomial,    0 <= r <= 1

is, along a ray of the training ellipse, what `dissipative` bounds: the damping o/z', or the turning
(z e - z'^2)/(z^2 + z'^2). On a part of the radius F is no larger than the largest of its Bernstein
coefficients there, each of which is a trigonometric polynomial b(a) of the same degree n; and such
a one is, between N equally spaced points, no larger than

    max b <= max b_j + (1/cos(pi n/N) - 1) (max b_j - min b_j)/2

(Ehlich and Zeller, Math. Z. 86 (1964) 41, whose bound of |b| is taken of b less its middle). What
holds there and for the slopes at r = 1 holds beyond: the continuation is linear, and F a mean of
the two. Rounding adds ROUNDING of the largest coefficient.
"""

from functools import cache
from math import comb

import numpy as np

ANGLES, PARTS = 1024, 128  # of half a circle, which its mirror image completes, and of the radius
ROUNDING = 1e-12


def bounds(coefficients: np.ndarray, powers: np.ndarray) -> tuple[float, float]:
    """What the damping and the turning are nowhere above, of a fit with these coefficients (l,) of
    monomials with these powers (l, 2), in units of the range.
    """
    angle = np.pi * np.arange(ANGLES + 1) / ANGLES  # F is the same of z' and -z'
    z, v = np.cos(angle)[:, None], np.sin(angle)[:, None]
    odd, degree = powers[:, 1] % 2 == 1, powers.sum(axis=1)
    damping = np.where(odd, z ** powers[:, 0] * v ** np.maximum(powers[:, 1] - 1, 0), 0.0)
    turning = np.where(odd, 0.0, z ** (powers[:, 0] + 1) * v ** powers[:, 1])
    return _largest(damping * coefficients, degree), _largest(turning * coefficients, degree, v**2)


def _largest(terms: np.ndarray, degree: np.ndarray, less: np.ndarray | float = 0.0) -> float:
    """Bound of sum_k r^(d_k - 1) terms_k - less, inside and of the slope at the edge."""
    highest = int(degree.max())
    along = np.stack([terms[:, degree == d].sum(axis=1) for d in range(1, highest + 1)], axis=1)
    spread = along @ _bernstein(highest - 1).T - less
    slope = along @ np.arange(1, highest + 1) - np.ravel(less)
    inside = between(spread, highest + 1).max()
    return float(max(inside, between(slope[:, None], highest + 1).max()))


def between(values: np.ndarray, degree: int) -> np.ndarray:
    """Bounds (k,) of even trigonometric polynomials of this degree with these values on half the
    circle (ANGLES + 1, k).
    """
    high, low = values.max(axis=0), values.min(axis=0)
    rise = 1.0 / np.cos(np.pi * degree / (2 * ANGLES)) - 1.0
    return high + 0.5 * rise * (high - low) + ROUNDING * np.abs(values).max()


@cache
def _bernstein(degree: int) -> np.ndarray:
    """(PARTS (degree + 1), degree + 1): of a polynomial's coefficients the Bernstein coefficients
    on each part of [0, 1].
    """
    q, rows, h = range(degree + 1), [], 1.0 / PARTS
    for part in range(PARTS):
        shifted = np.array([[_shifted(m, k, part * h, h) for m in q] for k in q])
        rows.append(np.array([[comb(i, k) / comb(degree, k) for k in q] for i in q]) @ shifted)
    return np.concatenate(rows)


def _shifted(m: int, k: int, start: float, h: float) -> float:
    """The coefficient of t^k in (start + h t)^m."""
    return comb(m, k) * start ** (m - k) * h**k if k <= m else 0.0
