"""N(y) + L y and its derivatives along channels, compiled for eight states side by side.

Channel c of y lies `apart` rows of scratch after channel c - 1; channel 0 is the value. A product
takes two channels at once, so their number is even.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from vibrom.kernels.lanes import WIDTH, fill, get, put
from vibrom.latent.elementary import CODES, activate
from vibrom.latent.networks import Network


class Matrix(NamedTuple):
    """A matrix in a table of numbers, row by row; its rows come in fours."""

    first: int  # place of its first number
    rows: int
    columns: int


class Layers(NamedTuple):
    """A network in the tables: its weights layer by layer, then its linear part."""

    first: int  # place of the first weight in the numbers
    sizes: int  # place in the index: number of layers, then rows and columns of each
    activation: int


class Scratch(NamedTuple):
    """Rows of scratch, each as long as a lane is wide."""

    apart: int  # from one channel to the next
    one: int  # where hidden layers put their values in turn
    two: int


class Packed(NamedTuple):
    """What a network adds to the tables of a kernel."""

    numbers: np.ndarray
    sizes: list[int]
    width: int  # rows of its widest matrix


def in_fours(weights: np.ndarray) -> np.ndarray:
    """Zero rows below, to a multiple of four."""
    return np.pad(weights, ((0, -len(weights) % 4), (0, 0)))


def packed(network: Network) -> Packed:
    """The tables of a network, as `network_along` reads them."""
    parts = [in_fours(matrix) for matrix in (*network.weights, network.linear)]
    hidden = parts[:-1]
    sizes = [len(hidden), *(size for part in hidden for size in part.shape)]
    numbers = np.concatenate([part.ravel() for part in parts]).astype(float)
    return Packed(numbers, sizes, max(size for part in parts for size in part.shape))


def code(network: Network) -> int:
    """The number that stands for its activation in compiled code."""
    return CODES[network.activation]


@njit(error_model="numpy")
def multiply(numbers, matrix, work, source, target, apart, onto):
    """A x of two channels, x from row `source` and A x from row `target` on, added to what is there
    if `onto`. Four rows at once keep eight sums in flight.
    """
    columns = matrix.columns
    for j in range(0, matrix.rows, 4):
        at, to, too = matrix.first + j * columns, target + j, target + apart + j
        if onto:
            s0, s1 = get(work, to, WIDTH), get(work, to + 1, WIDTH)
            s2, s3 = get(work, to + 2, WIDTH), get(work, to + 3, WIDTH)
            t0, t1 = get(work, too, WIDTH), get(work, too + 1, WIDTH)
            t2, t3 = get(work, too + 2, WIDTH), get(work, too + 3, WIDTH)
        else:
            s0 = fill(0.0, WIDTH)
            s1, s2, s3, t0, t1, t2, t3 = s0, s0, s0, s0, s0, s0, s0
        for i in range(columns):
            x, y = get(work, source + i, WIDTH), get(work, source + apart + i, WIDTH)
            a0, a1 = numbers[at + i], numbers[at + columns + i]
            a2, a3 = numbers[at + 2 * columns + i], numbers[at + 3 * columns + i]
            s0, s1, s2, s3 = s0 + x * a0, s1 + x * a1, s2 + x * a2, s3 + x * a3
            t0, t1, t2, t3 = t0 + y * a0, t1 + y * a1, t2 + y * a2, t3 + y * a3
        put(work, to, s0)
        put(work, to + 1, s1)
        put(work, to + 2, s2)
        put(work, to + 3, s3)
        put(work, too, t0)
        put(work, too + 1, t1)
        put(work, too + 2, t2)
        put(work, too + 3, t3)


@njit(error_model="numpy")
def _bend(activation, rows, channels, work, target, apart):
    """The activation of a layer, in place: s(a), and s'(a) times the other channels."""
    for j in range(rows):
        value, slope = activate(activation, get(work, target + j, WIDTH))
        put(work, target + j, value)
        for c in range(1, channels):
            at = target + c * apart + j
            put(work, at, slope * get(work, at, WIDTH))


@njit(error_model="numpy")
def network_along(tables, layers, channels, work, scratch, source, target):
    """N(y) + L y and its derivatives, from `channels` of y at row `source` to row `target`;
    `tables` are the numbers and the index of the kernel.
    """
    numbers, index = tables
    count, first, begin, apart = index[layers.sizes], layers.first, source, scratch.apart
    for layer in range(count):
        at = layers.sizes + 1 + 2 * layer
        matrix = Matrix(first, index[at], index[at + 1])
        last = layer == count - 1
        end = target if last else scratch.one if layer % 2 == 0 else scratch.two
        for c in range(0, channels, 2):
            multiply(numbers, matrix, work, begin + c * apart, end + c * apart, apart, False)
        if not last:
            _bend(layers.activation, matrix.rows, channels, work, end, apart)
        first += matrix.rows * matrix.columns
        begin = end
    straight = Matrix(first, index[layers.sizes + 2 * count - 1], index[layers.sizes + 2])
    for c in range(0, channels, 2):
        multiply(numbers, straight, work, source + c * apart, target + c * apart, apart, True)
