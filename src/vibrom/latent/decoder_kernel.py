"""The force map of an autoencoder, compiled for eight states side by side.

    V = dv/dz by d tangents carried along with the value;   decoder: (V'V)^-1 V' l,   decoder_mass:
    (V'MV)^-1 V' l,   encoder: w'(v(z)) l

with the load l in network units, as `autoencoder_rom` has it; beyond an edge v goes on along its
tangent. The Gram matrix is solved by Cholesky's method. The exponential: e^a = 2^n e^(a - n ln 2),
with ln 2 in two parts (Cody and Waite) and Taylor's series to degree 13 on |a - n ln 2| <= 0.35:
4e-18.
"""

from math import factorial

import numpy as np
from numba import njit

from vibrom.kernels.lanes import WIDTH, fill, floor, get, positive, power_of_two, put, sqrt
from vibrom.latent.autoencoder_rom import RULES
from vibrom.solvers.reduced.field import Kernel, field_kernel

ACTIVATIONS = ("silu", "elu", "tanh", "softplus")
_HIGH, _LOW = 0.6931471803691238, 1.9082149292705877e-10  # ln 2 = high + low; n high is exact
_SERIES = tuple(1.0 / factorial(k) for k in range(13, -1, -1))
_ATANH = tuple(1.0 / k for k in range(37, 0, -2))
_LOG2 = float(np.log(2.0))


@njit(error_model="numpy")
def _exp(a):
    """e^a for |a| <= 708, beyond it that of the bound."""
    a = positive(a - 708.0, 708.0, positive(-708.0 - a, -708.0, a))  # NaN stays
    n = floor(a * (1.0 / _LOG2) + 0.5)
    rest = (a - n * _HIGH) - n * _LOW
    total = fill(_SERIES[0], WIDTH)
    for k in range(1, len(_SERIES)):
        total = total * rest + _SERIES[k]
    return total * power_of_two(n)


@njit(error_model="numpy")
def _log_one_plus(x):
    """ln(1 + x) for 0 <= x <= 1:  2 atanh(s) with s = x/(2 + x) <= 1/3; the first term left out is
    below 1e-19.
    """
    s = x / (x + 2.0)
    square = s * s
    total = fill(_ATANH[0], WIDTH)
    for k in range(1, len(_ATANH)):
        total = total * square + _ATANH[k]
    return 2.0 * s * total


@njit(error_model="numpy")
def _activate(activation, a):
    """(s, s') of a. tanh is good to 1e-16 absolutely, which is what sums of it need, not relatively
    near zero.
    """
    if activation == 1:
        bent = _exp(positive(a, 0.0, a))
        return positive(a, a, bent - 1.0), bent
    if activation == 2:
        t = 1.0 - 2.0 / (_exp(2.0 * a) + 1.0)
        return t, 1.0 - t * t
    falling = _exp(positive(a, 0.0 - a, a))  # e^-|a| overflows nowhere
    share = 1.0 / (falling + 1.0)
    logistic = positive(a, 1.0, falling) * share
    if activation == 3:
        return positive(a, a, 0.0) + _log_one_plus(falling) - _LOG2, logistic
    return a * logistic, logistic + a * logistic * positive(a, falling, 1.0) * share


@njit(error_model="numpy")
def _multiply(numbers, first, rows, columns, work, source, target, apart, onto):
    """A x of two channels at once, added to what is there if `onto`: x at row `source` and `apart`
    rows later, A x from `target` in the same way.

    A (rows, columns) begins at numbers[first]; its rows come in fours, so that eight sums are in
    flight.
    """
    for j in range(0, rows, 4):
        at, to, too = first + j * columns, target + j, target + apart + j
        if onto:
            s0, s1, s2, s3 = (
                get(work, to, WIDTH),
                get(work, to + 1, WIDTH),
                get(work, to + 2, WIDTH),
                get(work, to + 3, WIDTH),
            )
            t0, t1, t2, t3 = (
                get(work, too, WIDTH),
                get(work, too + 1, WIDTH),
                get(work, too + 2, WIDTH),
                get(work, too + 3, WIDTH),
            )
        else:
            s0 = fill(0.0, WIDTH)
            s1, s2, s3, t0, t1, t2, t3 = s0, s0, s0, s0, s0, s0, s0
        for i in range(columns):
            x, y = get(work, source + i, WIDTH), get(work, source + apart + i, WIDTH)
            a0, a1, a2, a3 = (
                numbers[at + i],
                numbers[at + columns + i],
                numbers[at + 2 * columns + i],
                numbers[at + 3 * columns + i],
            )
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
def _network(numbers, first, index, layers, activation, channels, work, wide, begin, end, one, two):
    """N(y) + L y and its tangents: channel c of y lies `wide` rows after channel c - 1, from row
    `begin`, and so do the results from `end`.

    index[layers]: how many layers, then inputs and rows of each; the weights begin at
    numbers[first], after them L. `one` and `two` are scratch.
    """
    count, at, source = index[layers], first, begin
    for layer in range(count):
        columns, rows = index[layers + 1 + 2 * layer], index[layers + 2 + 2 * layer]
        target = end if layer == count - 1 else one if layer % 2 == 0 else two
        for c in range(0, channels, 2):
            _multiply(
                numbers, at, rows, columns, work, source + c * wide, target + c * wide, wide, False
            )
        if layer < count - 1:
            for j in range(rows):
                value, slope = _activate(activation, get(work, target + j, WIDTH))
                put(work, target + j, value)
                for c in range(1, channels):
                    put(
                        work,
                        target + c * wide + j,
                        slope * get(work, target + c * wide + j, WIDTH),
                    )
        at += rows * columns
        source = target
    inputs, rows = index[layers + 1], index[layers + 2 * count]
    for c in range(0, channels, 2):
        _multiply(numbers, at, rows, inputs, work, begin + c * wide, end + c * wide, wide, True)


@njit(error_model="numpy")
def _drawn_back(position, edge):
    """`position` within -edge and edge; NaN stays."""
    return positive(
        position - edge, fill(edge, WIDTH), positive(-edge - position, fill(-edge, WIDTH), position)
    )


@field_kernel
def _force(z, numbers, index, work, out):
    # index: d, k, rows of the widest layer, activation, rule (0 decoder, 1 decoder_mass, 2
    # encoder), where encoder, load, edge and mass begin in numbers, where the encoder's sizes begin
    # in index, then the decoder's. work: four blocks of an even number of channels, then the Gram
    # matrix and its right side.
    (
        d,
        k,
        wide,
        activation,
        rule,
        encoder,
        load_at,
        edge_at,
        mass_at,
        encoder_layers,
        decoder_layers,
    ) = (
        index[0],
        index[1],
        index[2],
        index[3],
        index[4],
        index[5],
        index[6],
        index[7],
        index[8],
        index[9],
        10,
    )
    channels = 2 + 2 * (d // 2)  # the value and d tangents, made even by a zero
    begin, back, one, two, gram = (
        0,
        channels * wide,
        2 * channels * wide,
        3 * channels * wide,
        4 * channels * wide,
    )
    right = gram + d * d
    for i in range(d):
        put(work, begin + i, _drawn_back(get(z, i, WIDTH), numbers[edge_at + i]))
        for axis in range(channels - 1):
            put(work, begin + (1 + axis) * wide + i, fill(1.0 if i == axis else 0.0, WIDTH))
    _network(
        numbers, 0, index, decoder_layers, activation, channels, work, wide, begin, back, one, two
    )
    if rule == 2:
        for a in range(d):
            beyond = get(z, a, WIDTH) - _drawn_back(get(z, a, WIDTH), numbers[edge_at + a])
            for i in range(k):
                put(
                    work,
                    back + i,
                    get(work, back + i, WIDTH)
                    + beyond * get(work, back + (1 + a) * wide + i, WIDTH),
                )
        for i in range(k):
            put(work, back + wide + i, fill(numbers[load_at + i], WIDTH))
        _network(
            numbers,
            encoder,
            index,
            encoder_layers,
            activation,
            2,
            work,
            wide,
            back,
            begin,
            one,
            two,
        )
        for i in range(d):
            put(out, i, fill(0.0, WIDTH))
            put(out, d + i, get(work, begin + wide + i, WIDTH))
        return
    weighted_by = back
    if rule == 1:
        weighted_by = one
        for c in range(0, channels, 2):
            _multiply(
                numbers,
                mass_at,
                k + (-k) % 4,
                k,
                work,
                back + c * wide,
                one + c * wide,
                wide,
                False,
            )
    for a in range(d):
        tangent, weighted = back + (1 + a) * wide, weighted_by + (1 + a) * wide
        total = fill(0.0, WIDTH)
        for i in range(k):
            total = total + get(work, tangent + i, WIDTH) * numbers[load_at + i]
        put(work, right + a, total)
        for b in range(a + 1):
            total = fill(0.0, WIDTH)
            for i in range(k):
                total = total + get(work, weighted + i, WIDTH) * get(
                    work, back + (1 + b) * wide + i, WIDTH
                )
            put(work, gram + a * d + b, total)
    for a in range(
        d
    ):  # Cholesky, row by row, and the forward substitution with it; the diagonal keeps 1/L_aa
        for b in range(a + 1):
            total = get(work, gram + a * d + b, WIDTH)
            for i in range(b):
                total = total - get(work, gram + a * d + i, WIDTH) * get(
                    work, gram + b * d + i, WIDTH
                )
            put(
                work,
                gram + a * d + b,
                1.0 / sqrt(total) if a == b else total * get(work, gram + b * d + b, WIDTH),
            )
        total = get(work, right + a, WIDTH)
        for i in range(a):
            total = total - get(work, gram + a * d + i, WIDTH) * get(work, right + i, WIDTH)
        put(work, right + a, total * get(work, gram + a * d + a, WIDTH))
    for a in range(d - 1, -1, -1):
        total = get(work, right + a, WIDTH)
        for i in range(a + 1, d):
            total = total - get(work, gram + i * d + a, WIDTH) * get(work, right + i, WIDTH)
        put(work, right + a, total * get(work, gram + a * d + a, WIDTH))
        put(out, d + a, get(work, right + a, WIDTH))
        put(out, a, fill(0.0, WIDTH))


def force_kernel(
    encoder: list[np.ndarray],
    decoder: list[np.ndarray],
    encoder_linear: np.ndarray,
    decoder_linear: np.ndarray,
    activation: str,
    load: np.ndarray,
    rule: str,
    mass: np.ndarray | None,
    edge: np.ndarray,
) -> Kernel:
    """The force map of these layers, straight parts and load, all in network units; `mass` (k, k)
    for the rule decoder_mass; beyond `edge` (d,) the decoder goes on along its tangent.
    """
    networks = [
        [_in_fours(weights) for weights in part]
        for part in ([*decoder, decoder_linear], [*encoder, encoder_linear])
    ]
    sizes = [
        [len(part) - 1, *(size for weights in part[:-1] for size in weights.shape[::-1])]
        for part in networks
    ]
    parts = [*networks[0], *networks[1], load, edge, *([] if mass is None else [_in_fours(mass)])]
    begins = np.cumsum([0] + [part.size for part in parts])
    at_encoder, at_load = len(networks[0]), len(networks[0]) + len(networks[1])
    d, k, wide = (
        decoder_linear.shape[1],
        len(decoder_linear),
        max(len(part) for part in parts if part.ndim == 2),
    )
    places = begins[[at_encoder, at_load, at_load + 1, at_load + 2]]
    index = [
        d,
        k,
        wide,
        ACTIVATIONS.index(activation),
        RULES.index(rule),
        *places,
        10 + len(sizes[0]),
        *sizes[0],
        *sizes[1],
    ]
    rows = 4 * (2 + 2 * (d // 2)) * wide + d * d + d
    return Kernel(
        _force,
        np.concatenate([np.ravel(part) for part in parts]).astype(float),
        np.array(index, dtype=np.int64),
        rows,
    )


def _in_fours(weights: np.ndarray) -> np.ndarray:
    """Zero rows below, to a multiple of four."""
    return np.pad(weights, ((0, -len(weights) % 4), (0, 0)))
