"""A decay whose frequency and damping over amplitude are known in closed form.

    r' = -a r - b r^3,    phi' = omega + g r^2,    x = r cos phi

With u = r^2 and w = (a/u_0 + b) - b exp(-2 a t):  u = a exp(-2 a t)/w, and the integral of u is
ln(w u_0/a)/(2 b).
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Oscillator:
    omega: float = 2 * np.pi * 5.0  # rad/s, of small motions
    hardening: float = 1.5  # g, rad/s/m2
    damping: float = 0.3  # a, 1/s
    cubic: float = 0.2  # b, 1/s/m2

    def polar(self, time, start):
        """(r, phi) from the amplitude `start` [m]."""
        a, b, u0 = self.damping, self.cubic, start**2
        fall = np.exp(-2 * a * time)
        w = a / u0 + b - b * fall
        phase = self.omega * time + self.hardening * np.log(w * u0 / a) / (2 * b)
        return np.sqrt(a * fall / w), phase

    def motion(self, time, start):
        """x (m,) [m]."""
        r, phase = self.polar(time, start)
        return r * np.cos(phase)

    def frequency_at(self, amplitude):
        """[rad/s]."""
        return self.omega + self.hardening * amplitude**2

    def damping_at(self, amplitude):
        """-(d ln r/dt) [1/s]."""
        return self.damping + self.cubic * amplitude**2


def noisy(x, share, seed=0):
    """With white noise whose deviation is a share of the largest |x|."""
    noise = np.random.default_rng(seed).standard_normal(np.shape(x))
    return x + share * np.abs(x).max() * noise
