"""Gaussian noise of a flat spectrum in a band:

    u(t) = s sqrt(1/n) sum_j [a_j cos(w_j t) + b_j sin(w_j t)],    S = s^2/(highest - lowest)

with standard normal a_j, b_j, and one w_j at a random place of each of n equal parts of the band.
s is its standard deviation, S its one-sided spectral density. A seed gives the same noise on every
machine, but for rounding. Source: Shinozuka and Deodatis, Appl. Mech. Rev. 44 (1991) 191.
"""

from dataclasses import dataclass

import numpy as np

from vibrom.config.kinds import Count, NonNegative, Positive, Seed

ROW = 256  # instants at a time
EVEN = 1e-12  # of the last instant: how far steps differ that are equal but for rounding


@dataclass(frozen=True)
class Noise:
    highest: Positive  # rad/s, of the band
    lowest: NonNegative = 0.0  # rad/s
    deviation: Positive = 1.0  # s
    lines: Count = 1000  # n: their distance must be small beside the width of a resonance
    seed: Seed = 0

    def at(self, t: np.ndarray) -> np.ndarray:
        return self.realised(t, [self.seed])[0]

    def realised(self, t: np.ndarray, seeds: list[int]) -> np.ndarray:
        """(seeds, m) at instants (m,), of the same w_j, which are those of the setting `seed`."""
        place = np.arange(self.lines) + np.random.default_rng(self.seed).random(self.lines)
        frequency = self.lowest + (self.highest - self.lowest) * place / self.lines
        numbers = [
            np.random.default_rng([seed, 1]).standard_normal((2, self.lines)) for seed in seeds
        ]
        weights = np.array([a - 1j * b for a, b in numbers]) * self.deviation / np.sqrt(self.lines)
        waves = _even if len(t) > ROW and np.ptp(np.diff(t)) < EVEN * t[-1] else _any
        return waves(frequency, weights, t)


def _any(frequency: np.ndarray, weights: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Re sum_j c_j e^(i w_j t), some instants at a time."""
    rows = [t[first : first + ROW] for first in range(0, len(t), ROW)]
    parts = [weights @ np.exp(1j * np.outer(frequency, row)) for row in rows]
    return np.concatenate(parts, axis=1).real


def _even(frequency: np.ndarray, weights: np.ndarray, t: np.ndarray) -> np.ndarray:
    """The same at instants in equal steps, by products of few exponentials: t = T_b + s_o."""
    begin = np.exp(1j * np.outer(t[::ROW], frequency))
    within = np.exp(1j * np.outer(frequency, t[:ROW] - t[0]))
    whole = [((begin * own) @ within).real.reshape(-1) for own in weights]
    return np.stack(whole)[:, : len(t)]
