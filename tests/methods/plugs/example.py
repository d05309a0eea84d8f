"""The method that README shows how to add: four functions, and no compiled code."""

from dataclasses import dataclass

import numpy as np

from vibrom.models.method import Method
from vibrom.models.rom import Rom, stored


@dataclass(frozen=True)
class OneMode(Rom):
    """q = phi z,  z'' = -k z - c z' + phi' p u."""

    phi: np.ndarray = stored("kg-0.5", "mode", "dof")
    weight: np.ndarray = stored("kg0.5", "mass times mode", "dof")
    stiffness: float = stored("s-2", "stiffness over mass")
    damping: float = stored("s-1", "damping over mass")

    def encode(self, x):
        q, v = np.split(np.asarray(x), 2, axis=-1)
        return np.stack([q @ self.weight, v @ self.weight], axis=-1)

    def decode(self, z):
        return np.concatenate([z[..., :1] * self.phi, z[..., 1:] * self.phi], axis=-1)

    def drift(self, z):
        position, velocity = np.moveaxis(z, -1, 0)
        return np.stack([velocity, -self.stiffness * position - self.damping * velocity], axis=-1)

    def force_map(self, z, p):
        return np.stack([np.zeros(z.shape[:-1]), np.full(z.shape[:-1], self.phi @ p)], axis=-1)


@dataclass(frozen=True)
class Example(Method):
    mode: int = 1  # which mode, counted from one

    def fit(self, training) -> Rom:
        structure = training.require_structure("example")
        phi = structure.modes[self.mode - 1]
        weight, damping = structure.mass @ phi, float(phi @ structure.damping @ phi)
        largest = [
            np.abs(training.joined(what) @ weight).max() for what in ("displacement", "velocity")
        ]
        frequency = float(structure.frequencies[self.mode - 1])
        return OneMode(np.array(largest), phi, weight, frequency**2, damping)
