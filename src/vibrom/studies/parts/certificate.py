"""Can a model of one oscillator gain energy? Its conditions on a fine grid of the phase plane.

    z'' = e + o,  e even and o odd in z':    damping  -o/(2 z') Z/V,    turning  (z'^2 - z e)/(z^2 +
    z'^2),    z and z' in units Z and V of the training range

Where both are nowhere negative an unforced motion shrinks from any start (`latent.dissipative`). A
dissipative fit imposes that on a few rays and radii; here it is looked at between and beyond them,
on the compiled model's own numpy functions, whatever the guard. A linear oscillator has its damping
ratio and one.
"""

import numpy as np

from vibrom.models.rollout import LIMIT
from vibrom.models.rom import Rom

ANGLES, RADII = 361, 60  # of a half plane, which parity completes; up to LIMIT times the range


def least(rom: Rom) -> tuple[float, float]:
    """The least damping ratio and the least turning; NaN of several oscillators, and where the
    model has no value.
    """
    if len(rom.reach) != 2:
        return np.nan, np.nan
    angle = (np.arange(ANGLES) + 0.5) * np.pi / ANGLES
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    # Half of the radii lie in the training range.
    inside, outside = (
        np.linspace(0.0, 1.0, RADII // 2 + 1)[1:],
        np.geomspace(1.0, LIMIT, RADII // 2),
    )
    z, v = (np.concatenate([inside, outside])[:, None, None] * ray).reshape(-1, 2).T
    one, other = (rate(rom, z, sign * v) for sign in (1.0, -1.0))
    even, odd = 0.5 * (one + other), 0.5 * (one - other)
    damping, turning = -0.5 * odd / v, (v**2 - z * even) / (z**2 + v**2)
    return float(damping.min()), float(turning.min())


def rate(rom: Rom, z: np.ndarray, v: np.ndarray) -> np.ndarray:
    """z'' (m,) in units V^2/Z."""
    position, speed = rom.reach
    with np.errstate(all="ignore"):
        found: np.ndarray = rom.drift(np.stack([z * position, v * speed], axis=1))[:, 1]
    return found * position / speed**2
