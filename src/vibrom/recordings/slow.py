"""Where the slow manifold begins: where the fast motion has died out.

On the manifold, the accelerations of all channels are functions of the slow coordinate z and its
velocity. These are fitted, as polynomials, to all that follows a period of the recording, and the
period is judged by what they leave of it:

    share = sum_c |a_c - F_c(z, z')|^2 / sum_c |omega^2 q_c|^2,    z = phi'q,

omega the first frequency, phi the first proper orthogonal direction of the displacements q. A fast
motion is no function of the slow state, even where its frequency is a multiple of the first one. Of
the degrees 3, 5 and 7 the one counts that leaves least. The slow motion begins where the share
first is no more than a limit, or no more than four times the least that it ever is (twice, in
amplitude): noise keeps it from falling farther. Of a motion so strongly nonlinear that no such
polynomial describes its beginning, the rule leaves that out.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from vibrom.latent.coordinates import principal
from vibrom.latent.polynomial import exponents, monomials

DEGREES = (3, 5, 7)
FOLLOW = 8  # periods at least, that the polynomials are fitted to
SMALLEST = 0.05  # of the largest amplitude: below, samples weigh no more
LEAST = 4.0  # times the least share


@dataclass(frozen=True)
class Slow:
    """The share of fast motion over time, and where the slow motion begins."""

    instant: np.ndarray  # (k,) s after the first sample, of the beginning of each period
    share: np.ndarray  # (k,) of the power of omega^2 q
    limit: float  # that the share is no more than
    begin: float  # s after the first sample


def begins(
    motion: tuple[np.ndarray, np.ndarray, np.ndarray], step: float, frequency: float, limit: float
) -> Slow:
    """Of displacement, velocity and acceleration (m, c), sampled at `step` [s], with this first
    frequency [Hz].
    """
    length = max(1, round(1.0 / (frequency * step)))
    q, v, a = motion
    phi, slow = principal([q], 1), (2.0 * np.pi * frequency) ** 2 * q
    y = np.concatenate([part @ phi / np.abs(part @ phi).max() for part in (q, v)], axis=1)
    left = np.min([[*_left(y, a, length, degree)][::-1] for degree in DEGREES], axis=0)
    there = [(part**2).sum() for part in np.split(slow, range(length, len(q), length))]
    share = left / there[: len(left)]
    allowed = max(limit, LEAST * float(share.min()))
    instant = step * length * np.arange(len(share))
    return Slow(instant, share, allowed, float(instant[np.argmax(share <= allowed)]))


def _left(y: np.ndarray, a: np.ndarray, length: int, degree: int) -> Iterator[float]:
    """What polynomials of this degree leave of |a|^2 (m, c), in each period from the last one that
    is judged to the first.
    """
    library = monomials(y, exponents(2, 1, degree))
    weight = 1.0 / np.maximum(np.linalg.norm(y, axis=1, keepdims=True), SMALLEST)
    rows, terms = weight * np.hstack([library, a]), library.shape[1]
    periods = len(y) // length
    first = periods - min(FOLLOW, periods // 2)
    triangle = np.linalg.qr(rows[first * length :]).R
    for period in reversed(range(first)):
        own = slice(period * length, (period + 1) * length)
        fitted = np.linalg.lstsq(triangle[:, :terms], triangle[:, terms:], rcond=None)[0]
        yield float(((a[own] - library[own] @ fitted) ** 2).sum())
        triangle = np.linalg.qr(np.vstack([triangle, rows[own]])).R
