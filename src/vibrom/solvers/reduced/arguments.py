"""Checks of what is given to an integrator: compiled code reads it unchecked."""

import numpy as np


class ArgumentError(ValueError):
    """An argument of a wrong shape or value; the message names it and says what is needed."""


def checked_sizes(name: str, sizes, r: int) -> np.ndarray:
    """A positive number of each coordinate (r,), a copy."""
    values = _numbers(name, sizes)
    if values.shape != (r,):
        raise ArgumentError(
            f"{name} has shape {values.shape}; give ({r},), one for each coordinate"
        )
    _refuse(name, values, ~(values > 0.0), "give positive numbers")
    return values


def checked_start(start, r: int) -> np.ndarray:
    """States (b, r), a copy."""
    values = _numbers("start", start)
    if values.ndim != 2 or values.shape[1] != r:
        raise ArgumentError(
            f"start has shape {values.shape}; give (runs, {r}), the reduced coordinates of each run"
        )
    _refuse("start", values, ~np.isfinite(values), "give finite numbers")
    return values


def checked_times(times, runs: int) -> np.ndarray:
    """Instants (b, m) [s], a copy."""
    values = _numbers("times", times)
    if values.ndim != 2 or len(values) != runs or values.shape[1] == 0:
        raise ArgumentError(
            f"times has shape {values.shape}; give ({runs}, instants), at least one of each run"
        )
    # Comparisons with NaN are false.
    _refuse("times", values, ~((values >= 0.0) & np.isfinite(values)), "give seconds from 0 on")
    falling = np.diff(values, axis=1, prepend=0.0) < 0.0
    _refuse("times", values, falling, "give the instants of each run in ascending order")
    return values


def checked_signal(name: str, signal, runs: int) -> np.ndarray:
    """One finite number for each run (b,), a copy."""
    values = _numbers(name, signal)
    if values.shape != (runs,):
        raise ArgumentError(f"{name} has shape {values.shape}; give ({runs},), one for each run")
    _refuse(name, values, ~np.isfinite(values), "give finite numbers")
    return values


def _numbers(name: str, values) -> np.ndarray:
    if np.iscomplexobj(values):
        raise ArgumentError(f"{name} is complex; give real numbers")
    try:
        return np.array(values, dtype=float, order="C")
    except (TypeError, ValueError) as error:
        raise ArgumentError(f"{name} is no array of numbers: {error}") from None


def _refuse(name: str, values: np.ndarray, wrong: np.ndarray, cure: str) -> None:
    """The first wrong number, by its place."""
    if wrong.any():
        place = tuple(int(k) for k in np.argwhere(wrong)[0])
        raise ArgumentError(
            f"{name}{list(place)} is {values[place]:g}, in shape {values.shape}; {cure}"
        )
