"""One damped linear oscillator as a reduced model of one degree of freedom."""

import numpy as np

from vibrom.latent.polynomial_rom import PolynomialRom

OMEGA, DAMPING = 400.0, 8.0


def linear_rom(reach=np.array([1.0, OMEGA]), force=np.eye(1)):
    """x = z,  z'' = -OMEGA^2 z - DAMPING z' + p u."""
    one = np.eye(2, dtype=np.int64)
    dynamics = np.array([[0.0, 1.0], [-(OMEGA**2), -DAMPING]])
    return PolynomialRom(
        reach, np.eye(1), reach, np.eye(2) * reach, one, dynamics * reach, one, force
    )
