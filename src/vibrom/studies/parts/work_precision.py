"""What accuracy costs: observed orders, Pareto fronts, cheapest settings, break-even counts.

A setting is a point (cost, error); a setting without an error (NaN: it failed) is on no front and
never the cheapest.
"""

from __future__ import annotations

import numpy as np


def observed_order(
    size: np.ndarray, error: np.ndarray, *, floor: float = 0.0, ceiling: float = np.inf
) -> float:
    """p of  error ~ size^p  by least squares of the logarithms, over the errors between `floor`
    (below it the reference's own error shows) and `ceiling` (above it nothing has converged yet);
    NaN with fewer than two of them.
    """
    with np.errstate(invalid="ignore"):
        good = (error > max(floor, 0.0)) & (error < ceiling)
    if len(np.unique(size[good])) < 2:
        return float("nan")
    return float(np.polyfit(np.log(size[good]), np.log(error[good]), 1)[0])


def front(cost: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Indices of the settings that no other one beats in both, by rising cost: the least error for
    its cost or less.
    """
    known = np.flatnonzero(np.isfinite(cost) & np.isfinite(error))
    order = known[np.lexsort((error[known], cost[known]))]
    best = (
        np.concatenate([[np.inf], np.minimum.accumulate(error[order])[:-1]])
        if len(order)
        else np.zeros(0)
    )
    return order[error[order] < best]


def cheapest(cost: np.ndarray, error: np.ndarray, target: float) -> int | None:
    """Index of the least cost with an error of at most `target`; None where no setting has that."""
    with np.errstate(invalid="ignore"):
        good = np.flatnonzero((error <= target) & np.isfinite(cost))
    return int(good[np.argmin(cost[good])]) if len(good) else None


def break_even(offline: float, online: float, full: float) -> float:
    """The least number of questions k >= 1 with  offline + k online <= k full;  infinite where an
    answer costs more than the full order's, NaN where a time is not known.
    """
    if not np.isfinite([offline, online, full]).all():
        return float("nan")
    return max(1.0, float(np.ceil(offline / (full - online)))) if full > online else float("inf")
