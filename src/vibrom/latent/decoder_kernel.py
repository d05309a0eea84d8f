"""The force map of an autoencoder, compiled for eight states side by side.

    tangents:  (T'T)^-1 T' l,  T = A dv/dz      encoder:  w'(v(z)) l

with the load l and the weight A of a `Push`; beyond its edge v is extrapolated along its tangent.
V and its d tangents are carried through the network together; the Gram matrix is solved by
Cholesky's method.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from vibrom.kernels.lanes import WIDTH, fill, get, positive, put, sqrt
from vibrom.latent.force_rules import Push
from vibrom.latent.network_kernel import Layers, Packed, Scratch, code, network_along, packed
from vibrom.latent.networks import Network
from vibrom.solvers.reduced.field import Kernel, field_kernel


class Places(NamedTuple):
    """The head of the index: sizes, and where things stand in the tables."""

    d: int  # positions
    k: int  # outputs of the decoder
    apart: int  # rows of scratch from one channel to the next
    activation: int
    load: int  # place of l (k,) in the numbers
    edge: int  # place of the training range (d,) in the numbers
    encoder: int  # place of the encoder's weights in the numbers; the decoder's come first
    encoder_sizes: int  # place of the encoder's sizes in the index; the decoder's follow this head


HEAD = len(Places._fields)


@njit(error_model="numpy")
def _places(index):
    return Places(index[0], index[1], index[2], index[3], index[4], index[5], index[6], index[7])


@njit(error_model="numpy")
def _clipped(position, edge):
    """`position` within -edge and edge; NaN stays."""
    return positive(
        position - edge, fill(edge, WIDTH), positive(-edge - position, fill(-edge, WIDTH), position)
    )


@njit(error_model="numpy")
def _decode(z, tables, work, places, target):
    """v(c) and its d tangents at the position c = z within its edge, to row `target` on; gives the
    scratch. The channels are made even by a zero.
    """
    numbers, d, apart = tables[0], places.d, places.apart
    channels = 2 + 2 * (d // 2)
    for i in range(d):
        put(work, i, _clipped(get(z, i, WIDTH), numbers[places.edge + i]))
        for axis in range(channels - 1):
            along = fill(1.0 if i == axis else 0.0, WIDTH)
            put(work, (1 + axis) * apart + i, along)
    scratch = Scratch(apart, 2 * channels * apart, 3 * channels * apart)
    layers = Layers(0, HEAD, places.activation)
    network_along(tables, layers, channels, work, scratch, 0, target)
    return scratch


@njit(error_model="numpy")
def _solve(work, gram, right, d):
    """x of G x = b, from row `right` on in the place of b: Cholesky's factor row by row, and the
    forward substitution with it; the diagonal keeps 1/L_aa.
    """
    for a in range(d):
        for b in range(a + 1):
            total = get(work, gram + a * d + b, WIDTH)
            for i in range(b):
                left = get(work, gram + a * d + i, WIDTH)
                total = total - left * get(work, gram + b * d + i, WIDTH)
            scaled = 1.0 / sqrt(total) if a == b else total * get(work, gram + b * d + b, WIDTH)
            put(work, gram + a * d + b, scaled)
        total = get(work, right + a, WIDTH)
        for i in range(a):
            total = total - get(work, gram + a * d + i, WIDTH) * get(work, right + i, WIDTH)
        put(work, right + a, total * get(work, gram + a * d + a, WIDTH))
    for a in range(d - 1, -1, -1):
        total = get(work, right + a, WIDTH)
        for i in range(a + 1, d):
            total = total - get(work, gram + i * d + a, WIDTH) * get(work, right + i, WIDTH)
        put(work, right + a, total * get(work, gram + a * d + a, WIDTH))


@field_kernel
def _on_tangents(z, numbers, index, work, out):
    # The weight A is part of the decoder's last layer and linear part.
    places = _places(index)
    d, apart = places.d, places.apart
    channels = 2 + 2 * (d // 2)
    tangents, gram = channels * apart, 4 * channels * apart
    right = gram + d * d
    _decode(z, (numbers, index), work, places, tangents)
    for a in range(d):
        mine = tangents + (1 + a) * apart
        total = fill(0.0, WIDTH)
        for i in range(places.k):
            total = total + get(work, mine + i, WIDTH) * numbers[places.load + i]
        put(work, right + a, total)
        for b in range(a + 1):
            other = tangents + (1 + b) * apart
            total = fill(0.0, WIDTH)
            for i in range(places.k):
                total = total + get(work, mine + i, WIDTH) * get(work, other + i, WIDTH)
            put(work, gram + a * d + b, total)
    _solve(work, gram, right, d)
    for a in range(d):
        put(out, a, fill(0.0, WIDTH))
        put(out, d + a, get(work, right + a, WIDTH))


@field_kernel
def _on_encoder(z, numbers, index, work, out):
    places = _places(index)
    d, k, apart = places.d, places.k, places.apart
    value = (2 + 2 * (d // 2)) * apart
    scratch = _decode(z, (numbers, index), work, places, value)
    for a in range(d):
        position = get(z, a, WIDTH)
        beyond = position - _clipped(position, numbers[places.edge + a])
        for i in range(k):
            slope = get(work, value + (1 + a) * apart + i, WIDTH)
            put(work, value + i, get(work, value + i, WIDTH) + beyond * slope)
    for i in range(k):
        put(work, value + apart + i, fill(numbers[places.load + i], WIDTH))
    layers = Layers(places.encoder, places.encoder_sizes, places.activation)
    network_along((numbers, index), layers, 2, work, scratch, value, 0)
    for a in range(d):
        put(out, a, fill(0.0, WIDTH))
        put(out, d + a, get(work, apart + a, WIDTH))


def force_kernel(decoder: Network, encoder: Network | None, push: Push, edge: np.ndarray) -> Kernel:
    """The force map of a load in network units: on the decoder's tangents, or on the encoder where
    one is given; `edge` (d,) is where the extrapolation of the decoder begins.
    """
    k, d = decoder.linear.shape
    back = packed(decoder if push.weight is None else weighted(decoder, push.weight))
    to = Packed(np.zeros(0), [], 0) if encoder is None else packed(encoder)
    load, edge_at = len(back.numbers), len(back.numbers) + k
    apart = max(back.width, to.width)
    head = Places(d, k, apart, code(decoder), load, edge_at, edge_at + d, HEAD + len(back.sizes))
    return Kernel(
        _on_tangents if encoder is None else _on_encoder,
        np.concatenate([back.numbers, push.load, edge, to.numbers]).astype(float),
        np.array([*head, *back.sizes, *to.sizes], dtype=np.int64),
        4 * (2 + 2 * (d // 2)) * apart + d * d + d,
        2 * d,
    )


def weighted(network: Network, weight: np.ndarray) -> Network:
    """A (N(y) + L y)."""
    last = weight @ network.weights[-1]
    return Network([*network.weights[:-1], last], weight @ network.linear, network.activation)
