"""Where the slow manifold begins: where the fast motion has died out.

    share(t) = (power of the acceleration away from multiples of f_1) / (all of its power)

over a window of eight periods from t on (Blackman); away means farther than 3 f_1/8 from every
multiple, which is as far as such a window spreads a line: of a decay it leaves some 1e-6.
f_1 is the highest line of that window near the first frequency, which moves with the amplitude. The
acceleration is what dynamics are fitted to, and shows fast motion most. The slow motion begins
where the share first is no more than a limit, or no more than twice the least that it ever is:
noise keeps it from falling farther.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal.windows import blackman

WINDOW = 8  # periods: a line of a Blackman window is three of their eighths wide on each side
AWAY = 0.375  # of the first frequency
TWICE = 2.0


@dataclass(frozen=True)
class Slow:
    """The share of fast motion over time, and where the slow motion begins."""

    instant: np.ndarray  # (k,) s after the first sample, of the beginning of each window
    share: np.ndarray  # (k,) of the power
    limit: float  # that the share is no more than
    begin: float  # s after the first sample


def begins(acceleration: np.ndarray, step: float, frequency: float, limit: float) -> Slow:
    """Of acceleration (m, c), sampled at `step` [s], with this first frequency [Hz]."""
    period = max(1, round(1.0 / (frequency * step)))
    length = min(WINDOW * period, len(acceleration))
    whole, window = range(0, len(acceleration) - length + 1, period), blackman(length, sym=False)
    parts = np.stack([acceleration[first : first + length] for first in whole])
    spectra = (np.abs(np.fft.rfft(parts * window[:, None], axis=1)) ** 2).sum(axis=-1)
    lines = np.fft.rfftfreq(length, step) / frequency
    near_first = np.where((lines > 0.5) & (lines < 1.5), spectra, 0.0)
    own = lines / lines[near_first.argmax(axis=1)][:, None]  # (k, f) of each window
    away = np.abs(own - np.round(own)) > AWAY
    share = (spectra * away).sum(axis=1) / spectra.sum(axis=1)
    allowed = max(limit, TWICE * float(share.min()))
    instant = step * np.array(whole)
    return Slow(instant, share, allowed, float(instant[np.argmax(share <= allowed)]))
