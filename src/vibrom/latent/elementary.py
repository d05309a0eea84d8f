"""Activations and their slopes, compiled for eight states side by side.

The exponential: e^a = 2^n e^(a - n ln 2), with ln 2 in two parts (Cody and Waite) and Taylor's
series to degree 13 on |a - n ln 2| <= 0.35: 4e-18.
"""

from math import factorial
from typing import get_args

import numpy as np
from numba import njit

from vibrom.kernels.lanes import WIDTH, fill, floor, positive, power_of_two
from vibrom.latent.networks import Activation

CODES = {name: code for code, name in enumerate(get_args(Activation))}
ELU, SILU, SOFTPLUS, TANH = (CODES[name] for name in ("elu", "silu", "softplus", "tanh"))
_HIGH, _LOW = 0.6931471803691238, 1.9082149292705877e-10  # ln 2 = high + low; n high is exact
_SERIES = tuple(1.0 / factorial(k) for k in range(13, -1, -1))
_ATANH = tuple(1.0 / k for k in range(37, 0, -2))
_LOG2 = float(np.log(2.0))


@njit(error_model="numpy")
def exponential(a):
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
def activate(code, a):
    """(s, s') of a. tanh is good to 1e-16 absolutely, which is what sums of it need, not relatively
    near zero.
    """
    if code == ELU:
        bent = exponential(positive(a, 0.0, a))
        return positive(a, a, bent - 1.0), bent
    if code == TANH:
        t = 1.0 - 2.0 / (exponential(2.0 * a) + 1.0)
        return t, 1.0 - t * t
    falling = exponential(positive(a, 0.0 - a, a))  # e^-|a| overflows nowhere
    share = 1.0 / (falling + 1.0)
    logistic = positive(a, 1.0, falling) * share
    if code == SOFTPLUS:
        return positive(a, a, 0.0) + _log_one_plus(falling) - _LOG2, logistic
    return a * logistic, logistic + a * logistic * positive(a, falling, 1.0) * share
