"""Sweeps: a motion that is carried on from one frequency of the load to the next."""

from collections.abc import Callable, Sequence

import numpy as np

from vibrom.solvers.periodic.maps import ReturnMap


def swept(
    flow: ReturnMap,
    frequency: np.ndarray,
    amplitude: float,
    periods: int,
    settle: int = 0,
    heard: Callable[[int], object] = int,
) -> list[np.ndarray]:
    """Points (m,) after so many periods at each frequency (k,) [rad/s] in this order, each carried
    on from the one before; the first begins from rest and takes `settle` periods more. NaN from
    where the motion does not last. `heard` is told of the periods that are done.
    """
    return [ends[-1] for ends in stops(flow, frequency, amplitude, periods, settle, (), heard)]


def stops(
    flow: ReturnMap,
    frequency: np.ndarray,
    amplitude: float,
    periods: int,
    settle: int,
    lags: tuple[int, ...],  # periods, falling
    heard: Callable[[int], object] = int,
) -> list[list[np.ndarray]]:
    """Of each frequency of such a sweep the points so many periods before its end, and the end."""
    x, points = np.zeros(flow.size), []
    for number, omega in enumerate(frequency.tolist()):
        taken, left, seen = periods + (0 if number else settle), 0, []
        for lag in (*lags, 0):
            x = flow.after(x, omega, amplitude, taken - lag - left)
            left = taken - lag
            seen.append(x)
        points.append(seen)
        heard(taken)
    return points


def swings(
    flow: ReturnMap, points: Sequence[np.ndarray], frequency: np.ndarray, amplitude: float
) -> np.ndarray:
    """(k, probes, samples) [m] of the period that begins at each of k points, at frequencies (k,)
    [rad/s]; NaN where a point is.
    """
    return np.stack([_swing(flow, x, omega, amplitude) for x, omega in zip(points, frequency)])


def _swing(flow: ReturnMap, x: np.ndarray, frequency: float, amplitude: float) -> np.ndarray:
    """(probes, samples) [m] of one; a lost one has the shape of rest."""
    known = np.isfinite(x).all()
    start, force = (x, amplitude) if known else (np.zeros(flow.size), 0.0)
    (swing,) = flow.swings(start[None], np.array([frequency]), np.array([force]))
    return swing.displacement if known else np.full_like(swing.displacement, np.nan)
