"""Products of polynomials at many points, in compiled code.

    c_o[target] += sum_pairs sum_entries x  a_i[left] b_j[right]

a and b are complex coefficients of kept monomials, real and imaginary parts apart; those of a
mirror are their conjugates. A block of points stays in registers while pairs are summed up.
"""

from typing import NamedTuple

import numpy as np
from numba import types

from vibrom.kernels.lanes import cut, fill, kernel, part, paste, room
from vibrom.solvers.manifold.monomials import Monomials, Pairs
from vibrom.solvers.threads import mapped, worth

BLOCK = 32  # points, four registers
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


@part
def _copy(a, rows, first, width, into):
    """`width` points of every row, one row after the other: together they stay in the cache."""
    points, a = a.shape[3], a.reshape(a.size)
    for row in range(rows):
        paste(into, row * width, cut(a, row * points + first, width))


@part
def _add(a, b, pairs, form, c, first, width):
    """The products at `width` points from `first` on, of all of a and b."""
    begin, left, left_sign, right, right_sign = pairs
    outs, ones, others, factors = form
    (a, rows), (b, columns) = a, b
    points, c_rows, c = c.shape[3], 2 * c.shape[1], c.reshape(c.size)
    for e in range(len(outs)):
        for target in range(len(begin) - 1):
            real, imaginary = fill(0.0, width), fill(0.0, width)
            for k in range(begin[target], begin[target + 1]):
                x = (left[k] * rows + 2 * ones[e]) * width
                y = (right[k] * columns + 2 * others[e]) * width
                xr, xi = cut(a, x, width), cut(a, x + width, width) * left_sign[k]
                yr, yi = cut(b, y, width), cut(b, y + width, width) * right_sign[k]
                real += xr * yr - xi * yi
                imaginary += xr * yi + xi * yr
            z = (target * c_rows + 2 * outs[e]) * points + first
            paste(c, z, cut(c, z, width) + real * factors[e])
            paste(c, z + points, cut(c, z + points, width) + imaginary * factors[e])


@part
def _step(a, b, rooms, pairs, form, c, first, width):
    x, y = rooms
    _copy(a, len(x) // BLOCK, first, width, x)
    _copy(b, len(y) // BLOCK, first, width, y)
    _add((x, 2 * a.shape[1]), (y, 2 * b.shape[1]), pairs, form, c, first, width)


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
    rows = 2 * a.shape[1] * (1 + pairs[1].max()), 2 * b.shape[1] * (1 + pairs[3].max())
    rooms = room(rows[0], BLOCK).reshape(-1), room(rows[1], BLOCK).reshape(-1)
    whole = ends - (ends - begins) % BLOCK
    for first in range(begins, whole, BLOCK):
        _step(a, b, rooms, pairs, form, c, first, BLOCK)
    for first in range(whole, ends):
        _step(a, b, rooms, pairs, form, c, first, 1)


def multiply(
    a: np.ndarray, b: np.ndarray, pairs: Schedule, form: Entries, into: np.ndarray
) -> None:
    """Adds the products to `into` (targets, outs, 2, points); a and b (kept, components, 2,
    points).
    """
    if not len(pairs.left):
        return
    blocks = -(-into.shape[3] // BLOCK)
    parts = min(worth(into.shape[3]), blocks)
    ends = np.append(BLOCK * (blocks * np.arange(parts) // parts), into.shape[3])
    given = a, b, tuple(pairs), tuple(form), into
    mapped(lambda k: _multiply(*given, ends[k], ends[k + 1]), range(parts), parts)
