"""A step:  u = 0 before it begins, then `size`, which it reaches on a straight line.

Without a rise it jumps within a step of the time integration; a jump at the start is there at once.
"""

from dataclasses import dataclass

import numpy as np

from vibrom.config.kinds import NonNegative


@dataclass(frozen=True)
class Step:
    size: float = 1.0
    begin: NonNegative = 0.0  # s
    rise: NonNegative = 0.0  # s

    def at(self, t: np.ndarray) -> np.ndarray:
        if self.rise:
            return self.size * np.clip((t - self.begin) / self.rise, 0.0, 1.0)
        return self.size * np.where(t >= self.begin, 1.0, 0.0)
