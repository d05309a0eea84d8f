"""Normalised mean-trajectory error:  NMTE = 100 mean_t |y - y_model| / max_t |y|  in percent, |.| the Euclidean norm over the free dofs."""

import numpy as np


def nmte_percent(error: np.ndarray, truth: np.ndarray) -> float:
    """From |y - y_model| (m,) and y (m, n); NaN when the model failed before the end."""
    return float(100.0 * error.mean() / np.linalg.norm(truth, axis=-1).max())
