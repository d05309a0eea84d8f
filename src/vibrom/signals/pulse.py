"""A blow:  u = a sin(pi x), a or a (1 - |2 x - 1|)  with x = (t - begin)/duration between 0 and 1,
else zero: half a sine, a rectangle or a triangle.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from vibrom.config.kinds import NonNegative, Positive


@dataclass(frozen=True)
class Pulse:
    duration: Positive  # s
    size: float = 1.0  # a, the largest value
    begin: NonNegative = 0.0  # s
    shape: Literal["half_sine", "rectangle", "triangle"] = "half_sine"

    def at(self, t: np.ndarray) -> np.ndarray:
        x = (t - self.begin) / self.duration
        shapes = {
            "half_sine": np.sin(np.pi * x),
            "rectangle": np.ones_like(x),
            "triangle": 1.0 - np.abs(2.0 * x - 1.0),
        }
        return self.size * np.where((x >= 0.0) & (x <= 1.0), shapes[self.shape], 0.0)
