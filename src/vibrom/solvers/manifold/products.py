"""Products of polynomials at many points, in compiled code.

    c_o[target] += sum_pairs sum_entries x  a_i[left] b_j[right]

a and b are complex coefficients of kept monomials, real and imaginary parts apart; those of a
mirror are their conjugates. Points go through the loops in blocks that stay in the cache.
"""

from typing import NamedTuple

import numpy as np
from numba import types

from vibrom.kernels.lanes import kernel
from vibrom.solvers.manifold.monomials import Monomials, Pairs
from vibrom.solvers.threads import mapped, worth

BLOCK = 64  # points
_values = types.float64[:, :, :, ::1]
_places = types.int64[::1]
_signs = types.float64[::1]


class Entries(NamedTuple):
    """The entries of a bilinear map that are not zero."""

    out: np.ndarray  # (k,)
    left: np.ndarray  # (k,)
    right: np.ndarray  # (k,)
    factor: np.ndarray  # (k,)


class Schedule(NamedTuple):
    """What is multiplied with what: of each target, which stored coefficients."""

    begin: np.ndarray  # (targets + 1,)
    left: np.ndarray  # (k,) place among the kept monomials
    left_sign: np.ndarray  # (k,) of the imaginary part
    right: np.ndarray
    right_sign: np.ndarray


def entries(tensor: np.ndarray) -> Entries:
    """Of  c_o = sum_ij t_oij a_i b_j."""
    places = np.nonzero(tensor)
    return Entries(*(np.ascontiguousarray(part) for part in places), tensor[places])


def schedule(monomials: Monomials, degree: int, pairs: Pairs) -> Schedule:
    """For the kept targets of this degree, in their order."""
    place = np.cumsum(monomials.kept) - 1
    stored = np.minimum(np.arange(len(monomials)), monomials.conjugate)
    sign = np.where(monomials.kept, 1.0, -1.0)
    targets = kept_of(monomials, degree)
    begin = np.searchsorted(pairs.target, np.append(targets, targets[-1] + 1))
    left, right = pairs.left, pairs.right
    return Schedule(begin, place[stored[left]], sign[left], place[stored[right]], sign[right])


def kept_of(monomials: Monomials, degree: int) -> np.ndarray:
    """The kept monomials of this degree."""
    first = monomials.of_degree(degree)
    return np.arange(len(monomials))[first][monomials.kept[first]]


@kernel(
    types.void(
        _values,
        _values,
        types.Tuple((_places, _places, _signs, _places, _signs)),
        types.Tuple((_places, _places, _places, _signs)),
        _values,
        types.int64,
        types.int64,
    ),
    nogil=True,
)
def _multiply(a, b, pairs, form, c, begins, ends):
    begin, left, left_sign, right, right_sign = pairs
    outs, ones, others, factors = form
    for first in range(begins, ends, BLOCK):
        last = min(first + BLOCK, ends)
        for target in range(len(begin) - 1):
            for k in range(begin[target], begin[target + 1]):
                sa, sb = left_sign[k], right_sign[k]
                for e in range(len(outs)):
                    x, y = a[left[k], ones[e]], b[right[k], others[e]]
                    z, factor = c[target, outs[e]], factors[e]
                    real, cross = -factor * sa * sb, factor * sb
                    other = factor * sa
                    xr, xi, yr, yi = (
                        x[0, first:last],
                        x[1, first:last],
                        y[0, first:last],
                        y[1, first:last],
                    )
                    zr, zi = z[0, first:last], z[1, first:last]
                    for p in range(last - first):
                        zr[p] += factor * xr[p] * yr[p] + real * xi[p] * yi[p]
                        zi[p] += cross * xr[p] * yi[p] + other * xi[p] * yr[p]


def multiply(
    a: np.ndarray, b: np.ndarray, pairs: Schedule, form: Entries, into: np.ndarray
) -> None:
    """Adds the products to `into` (targets, outs, 2, points); a and b (kept, components, 2,
    points).
    """
    blocks = -(-into.shape[3] // BLOCK)
    parts = min(worth(into.shape[3]), blocks)
    ends = np.append(BLOCK * (blocks * np.arange(parts) // parts), into.shape[3])
    given = a, b, tuple(pairs), tuple(form), into
    mapped(lambda k: _multiply(*given, ends[k], ends[k + 1]), range(parts), parts)
