"""A sine from the start on:  u(t) = a sin(w t + phase)."""

from dataclasses import dataclass

import numpy as np

from vibrom.config.kinds import Positive


@dataclass(frozen=True)
class Sine:
    frequency: Positive  # rad/s, w
    amplitude: float = 1.0  # a
    phase: float = 0.0  # rad

    def at(self, t: np.ndarray) -> np.ndarray:
        return self.amplitude * np.sin(self.frequency * t + self.phase)
