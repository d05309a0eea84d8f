"""What a periodic response shows: its amplitude and its phase."""

import numpy as np


def amplitude_and_phase(samples: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(max, phase [rad] in (-2 pi, 0]) of whole periods `samples` (..., m) that start with a period of the forcing sin(Omega t).

    The phase is that of the first harmonic, y ~ A sin(Omega t + phase); the maximum is that of y, not of |y|.
    """
    m = samples.shape[-1]
    harmonic = samples @ np.exp(-2j * np.pi * np.arange(m) / m)
    phase = np.angle(1j * harmonic)  # sin(x) = Im e^ix: its own harmonic is -i m / 2
    return samples.max(axis=-1), np.where(phase > 0.0, phase - 2 * np.pi, phase)
