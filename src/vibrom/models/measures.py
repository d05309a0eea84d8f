"""Numbers that compare motions: the error of a trajectory, the amplitude and the phase of a
periodic response.
"""

import numpy as np


def amplitude_and_phase(samples: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(max, phase [rad] in (-2 pi, 0]) of whole periods `samples` (..., m) that start with a period
    of the forcing sin(Omega t).

    The phase is that of the first harmonic, y ~ A sin(Omega t + phase); the maximum is that of y,
    not of |y|.
    """
    m = samples.shape[-1]
    harmonic = samples @ np.exp(-2j * np.pi * np.arange(m) / m)
    phase = np.angle(1j * harmonic)  # sin(x) = Im e^ix: its own harmonic is -i m / 2
    return samples.max(axis=-1), np.where(phase > 0.0, phase - 2 * np.pi, phase)


def nmte_percent(error: np.ndarray, truth: np.ndarray) -> float:
    """Normalised mean-trajectory error:  NMTE = 100 mean_t |y - y_model| / max_t |y|  in percent,
    |.| the Euclidean norm over the free dofs.

    From |y - y_model| (m,) and y (m, n); NaN when the model failed before the end.
    """
    return float(100.0 * error.mean() / np.linalg.norm(truth, axis=-1).max())
