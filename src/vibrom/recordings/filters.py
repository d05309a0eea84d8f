"""Filtering and differentiation of samples that carry noise.

    regularised        min_y  sum_j (y_j - x_j)^2 + lambda sum_j (D^4 y)_j^2,
                       which keeps the share 1/(1 + (f/f_c)^8) of a frequency f (below the sampling
                       rate), lambda = (2 pi f_c h)^-8; velocity and acceleration are differences of
                       y of sixth order, so that all three are one motion
    savitzky_golay     a polynomial of degree 5 moves along; its value and derivatives in the
                       middle. Each is attenuated by another factor, which shifts frequencies
    none               differences of x of sixth order

Sources: Whittaker, Proc. Edinb. Math. Soc. 41 (1923) 63; Savitzky and Golay, Anal. Chem. 36 (1964)
1627.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solveh_banded
from scipy.signal import periodogram, savgol_coeffs, savgol_filter
from scipy.special import binom

from vibrom.models.recorded import FIRST, differences

ORDER = 4  # of the differences that the regularised filter keeps small
DEGREE = 5  # of the polynomials of Savitzky and Golay
CHANGED = 1e-3  # of the acceleration, by their window
STANDS_OUT = 20.0  # times the median power of noise: 60 lines of it reach 7 times
VISIBLE = 1e-8  # of the power of the first line: 1e-4 of its amplitude
MARGIN = 2  # the cut-off is at this many multiples of the first frequency above the last one kept
MOST = 15  # multiples of the first frequency, that are kept

Motion = tuple[np.ndarray, np.ndarray, np.ndarray]  # x (m, c), and its two derivatives


def harmonics(x: np.ndarray, step: float, frequency: float) -> int:
    """The highest multiple of the first frequency [Hz] whose line in x (m, c) is visible beside the
    first one's, and stands out of the noise.
    """
    lines, power = periodogram(x.T, 1.0 / step, window="blackmanharris", detrend="constant")
    total = power.sum(axis=0)
    above = total[lines > frequency / 2]
    floor = max(STANDS_OUT * float(np.median(above[len(above) // 2 :])), VISIBLE * total.max())
    kept = 1
    for multiple in range(2, min(MOST, int(0.4 / (step * frequency))) + 1):
        near = np.abs(lines / frequency - multiple) < 0.25
        if total[near].max(initial=0.0) > floor:
            kept = multiple
    return kept


def regularised(x: np.ndarray, cut_off: float) -> np.ndarray:
    """y (m, c) of x (m, c); the cut-off is in cycles a sample."""
    weight = (2.0 * np.pi * cut_off) ** (-2 * ORDER)
    stencil = (-1.0) ** np.arange(ORDER + 1) * binom(ORDER, np.arange(ORDER + 1))
    band, m = np.zeros((ORDER + 1, len(x))), len(x)
    for i in range(ORDER + 1):
        for j in range(i, ORDER + 1):
            band[ORDER - (j - i), j : m - ORDER + j] += weight * stencil[i] * stencil[j]
    band[ORDER] += 1.0
    return solveh_banded(band, x)


def window(step: float, frequency: float) -> int:
    """Samples of the polynomial's window: the longest, up to half a period, that changes the
    acceleration at the first frequency [Hz] by no more than `CHANGED`, which is twice what it
    changes that frequency by.
    """
    angle, found = 2.0 * np.pi * frequency * step, DEGREE + 2
    for length in range(found, int(0.5 / (frequency * step)) + 1, 2):
        weights = savgol_coeffs(length, DEGREE, deriv=2, use="dot")
        gain = weights @ np.cos(angle * (np.arange(length) - length // 2)) / -(angle**2)
        if abs(gain - 1.0) <= CHANGED:
            found = length
    return found


def differentiated(
    x: np.ndarray, step: float, frequency: float, kind: str, kept: int
) -> tuple[Motion, int, dict[str, float]]:
    """Filtered displacement, velocity and acceleration (m - 2 lost, c), the samples lost at each
    end, and the filter's setting; `kept` multiples of the first frequency [Hz] stay.
    """
    lost, edge = len(FIRST) // 2, int(0.5 / (frequency * step))
    if kind == "savitzky_golay":
        length = window(step, frequency)
        parts = [
            savgol_filter(x, length, DEGREE, deriv=k, delta=step, axis=0)[
                length // 2 : len(x) - length // 2
            ]
            for k in range(3)
        ]
        return tuple(parts), length // 2, {"window_s": length * step, "degree": DEGREE}
    cut_off = (kept + MARGIN) * frequency
    if kind == "none" or cut_off * step > 0.25:
        return (x[lost:-lost], *differences(x, step)), lost, {"cut_off_hz": np.inf}
    y = regularised(x, cut_off * step)
    v, a = differences(y, step)
    inner = slice(edge, len(v) - edge)
    motion = y[lost:-lost][inner], v[inner], a[inner]
    return motion, lost + edge, {"cut_off_hz": cut_off, "harmonics": kept}
