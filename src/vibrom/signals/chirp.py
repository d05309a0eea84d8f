"""A sine whose frequency moves:  u = a sin(int_0^t w dt),  w = w_0 + (w_1 - w_0) x  or
w_0 (w_1/w_0)^x  with x = t/duration up to one, where it ends; linear or exponential.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from vibrom.config.kinds import Positive


@dataclass(frozen=True)
class Chirp:
    first: Positive  # rad/s, w_0
    last: Positive  # rad/s, w_1, which may be the lower one
    duration: Positive  # s
    amplitude: float = 1.0  # a
    law: Literal["linear", "exponential"] = "linear"

    def at(self, t: np.ndarray) -> np.ndarray:
        x = np.minimum(t / self.duration, 1.0)
        rate = np.log(self.last / self.first)
        if self.law == "linear" or rate == 0.0:
            turns = x * (self.first + 0.5 * (self.last - self.first) * x)
        else:
            turns = self.first * np.expm1(rate * x) / rate
        return np.where(t <= self.duration, self.amplitude * np.sin(self.duration * turns), 0.0)
