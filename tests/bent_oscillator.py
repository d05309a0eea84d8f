"""Decays of a bent oscillator, whose reduced dynamics are known, for methods with an autoencoder.

q = phi z + b (phi' z)^2,    z_i'' = -w_i^2 z_i - c z_i' + a z_i^3
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.sparse import csr_matrix, diags

from vibrom.models.training import Structure, Training, Trajectory

N, SIZE, DAMPING, CUBIC = 6, 0.02, 0.5, -2e5
FREQUENCIES = np.array([25.0, 60.0])
RANDOM = np.random.default_rng(5)
MASS = np.linspace(0.5, 1.5, N)
MODES = (np.linalg.qr(RANDOM.standard_normal((N, 2)))[0] / np.sqrt(MASS)[:, None]).T
BEND = 0.2 * RANDOM.standard_normal(N) / SIZE
QUICK = {"hidden": (12,), "rank": 0, "every": 1, "epochs": 5}


def oscillate(start, modes=1, periods=8):
    """One decay from modal positions `start`, 30 samples a period."""
    time = np.linspace(0.0, periods * 2 * np.pi / FREQUENCIES[0], 30 * periods)
    stiffness = FREQUENCIES[:modes] ** 2

    def rate(z):
        return -stiffness[:, None] * z[:modes] - DAMPING * z[modes:] + CUBIC * z[:modes] ** 3

    found = solve_ivp(
        lambda t, z: np.concatenate([z[modes:], rate(z[:, None])[:, 0]]),
        (0, time[-1]),
        np.r_[start, np.zeros(modes)],
        t_eval=time,
        rtol=1e-10,
        atol=1e-13,
    ).y
    z, first, second = found[:modes], found[modes:], rate(found)
    phi = MODES[:modes]
    y, y1, y2 = z[0][:, None], first[0][:, None], second[0][:, None]
    return Trajectory(
        time,
        z.T @ phi + BEND * y**2,
        first.T @ phi + 2 * BEND * y * y1,
        second.T @ phi + 2 * BEND * (y1**2 + y * y2),
    )


def structure(modes=1):
    phi = np.vstack([MODES, np.linalg.svd(MODES * np.sqrt(MASS))[2][2:] / np.sqrt(MASS)])
    frequency = np.concatenate([FREQUENCIES, [90.0, 120.0, 150.0, 180.0]])
    shapes = phi.T * frequency
    weigh = diags(MASS)
    return Structure(
        csr_matrix(weigh),
        csr_matrix(DAMPING * weigh),
        csr_matrix(weigh @ shapes @ shapes.T @ weigh),
        phi,
        frequency,
    )


def training(modes=1, **changes):
    starts = np.array([SIZE, 0.2 * SIZE])[:modes]
    return Training(
        **{
            "trajectories": (oscillate(starts, modes),),
            "structure": structure(modes),
            "seed": 0,
        }
        | changes
    )
