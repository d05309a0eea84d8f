"""A force map of one position as a table: polynomials of degree DEGREE on equal intervals.

    a(z) = sum_k c_ik x^k,    x = 2 (z - z_i)/h - 1 in [-1, 1],    |z| <= Z;    a(+-Z) beyond

What a load adds depends on the position alone. Of one position the network is therefore evaluated
once at a thousand points or two, which takes some milliseconds, and a rollout, which needs a(z) at
every stage of every step, reads the table: response curves take a tenth of the time, and the map is
the same to ERROR. One that is not smooth enough for that stays a network.
"""

import numpy as np
from numba import njit

from vibrom.kernels.lanes import WIDTH
from vibrom.solvers.reduced.field import Kernel, field_kernel

DEGREE = 9
ERROR = 1e-13  # of the largest |a|: how far table and network may differ
# Of the whole table, tried one after the other; multiples of twenty, as the training range, at a
# tenth of it, is where a decoder may bend.
INTERVALS = (80, 160, 320, 640, 1280)
HEAD = 2  # numbers before the coefficients: -Z and 1/h


@njit(error_model="numpy")
def _value(numbers, intervals, z):
    if z != z:  # a number that is none has no place
        return z
    at = min(max((z - numbers[0]) * numbers[1], 0.0), float(intervals))
    place = min(int(at), intervals - 1)
    x, first = 2.0 * (at - place) - 1.0, HEAD + place * (DEGREE + 1)
    total = numbers[first]
    for k in range(1, DEGREE + 1):
        total = total * x + numbers[first + k]
    return total


@field_kernel
def _table(z, numbers, index, work, out):
    for w in range(WIDTH):
        out[0, w] = 0.0
        out[1, w] = _value(numbers, index[0], z[0, w])


def tabulated(force: Kernel, far: float) -> Kernel:
    """The table of a force map of one position within |z| <= far; the map itself where no table is
    as good.
    """
    nodes = np.cos(np.pi * (np.arange(DEGREE + 1) + 0.5) / (DEGREE + 1))
    between = np.linspace(-1.0, 1.0, 7)
    inverse = np.linalg.inv(np.vander(nodes))
    for intervals in INTERVALS:
        width = 2.0 * far / intervals
        middles = -far + width * (np.arange(intervals)[:, None] + 0.5)
        coefficients = evaluated(force, middles + 0.5 * width * nodes) @ inverse.T
        truth = evaluated(force, middles + 0.5 * width * between)
        found = coefficients @ np.vander(between, DEGREE + 1).T
        if np.abs(found - truth).max() <= ERROR * np.abs(truth).max():
            numbers = np.concatenate([[-far, 1.0 / width], coefficients.ravel()])
            return Kernel(_table, numbers, np.array([intervals]), 0, 2)
    return force


def evaluated(force: Kernel, position: np.ndarray) -> np.ndarray:
    """a (as `position`) of a force map at these positions."""
    flat = position.ravel()
    lanes = np.pad(flat, (0, -len(flat) % WIDTH)).reshape(-1, 1, WIDTH)
    states = np.concatenate([lanes, np.zeros_like(lanes)], axis=1)
    out, work = np.empty_like(states), np.zeros(WIDTH * force.rows)
    for state, found in zip(states, out):
        force.function(state, force.numbers, force.index, work, found)
    return out[:, 1].ravel()[: len(flat)].reshape(position.shape)
