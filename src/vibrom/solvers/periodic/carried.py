"""A motion that is carried on from one frequency of the load to the next."""

import numpy as np

from vibrom.solvers.periodic.maps import ReturnMap


def swept(flow: ReturnMap, frequency: np.ndarray, amplitude: float, periods: int) -> np.ndarray:
    """(k, probes, samples) the last of so many periods at each frequency (k,) [rad/s], in their
    order and from rest; NaN from where the motion does not last.
    """
    x, rows = np.zeros(flow.size), []
    for omega in frequency:
        x = flow.after(x, float(omega), amplitude, periods)
        if not np.isfinite(x).all():
            break
        rows.append(_swing(flow, x, float(omega), amplitude))
    shape = _swing(flow, np.zeros(flow.size), float(frequency[0]), 0.0).shape
    lost = np.full((len(frequency) - len(rows), *shape), np.nan)
    return np.concatenate([np.reshape(rows, (len(rows), *shape)), lost])


def _swing(flow: ReturnMap, x: np.ndarray, frequency: float, amplitude: float) -> np.ndarray:
    """(probes, samples) [m] of the period that begins at x."""
    (swing,) = flow.swings(x[None], np.array([frequency]), np.array([amplitude]))
    return swing.displacement
