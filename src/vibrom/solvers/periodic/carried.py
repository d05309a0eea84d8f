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
        (swing,) = flow.swings(x[None], np.array([omega]), np.array([amplitude]))
        rows.append(swing.displacement)
    shape = rows[0].shape if rows else (1, 1)
    lost = np.full((len(frequency) - len(rows), *shape), np.nan)
    return np.concatenate([np.reshape(rows, (len(rows), *shape)), lost])
