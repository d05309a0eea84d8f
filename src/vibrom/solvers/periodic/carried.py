"""Sweeps: a motion that is carried on from one frequency of the load to the next."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from vibrom.solvers.periodic.maps import ReturnMap

PARTS = 4  # of the fewest periods at a stop: how often it is asked whether the motion is steady


@dataclass(frozen=True)
class Stay:
    """How long a sweep stays at a frequency: `periods`, and on to `longest` while the point is not
    steady. Where parts of the stay change it by d and then by r d, r d/(1 - r) of that is left: the
    last change and what is left are to be less than `steady` of its size.
    """

    periods: int
    longest: int = 0
    steady: float = np.inf
    settle: int = 0  # more periods at the first frequency, which begins from rest

    @property
    def part(self) -> int:
        """Periods between two questions."""
        return max(self.periods // PARTS, 1)

    def goes_on(self, taken: int, ends: list[np.ndarray]) -> bool:
        """After so many periods, with these points (m,) at the ends of their parts?"""
        if taken < self.periods or taken + self.part > self.longest:
            return taken < self.periods
        before, last = (np.linalg.norm(one - other) for one, other in zip(ends[-3:], ends[-2:]))
        left = last * last / max(before - last, 1e-300)
        return bool(max(last, left) > self.steady * np.linalg.norm(ends[-1]))


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
    stay = Stay(periods, settle=settle)
    return [stop[-1] for stop in stops(flow, frequency, amplitude, stay, heard)]


def stops(
    flow: ReturnMap,
    frequency: np.ndarray,
    amplitude: float,
    stay: Stay,
    heard: Callable[[int], object] = int,
) -> list[list[np.ndarray]]:
    """Of each frequency of such a sweep the points a part and a period before its end, and it."""
    x, found = np.zeros(flow.size), []
    for number, omega in enumerate(frequency.tolist()):
        if stay.settle and not number:
            x = flow.after(x, omega, amplitude, stay.settle)
            heard(stay.settle)
        taken, ends = 0, [x, x]
        while stay.goes_on(taken, ends):
            part = min(stay.part, stay.periods - taken) if taken < stay.periods else stay.part
            before = flow.after(x, omega, amplitude, part - 1) if part > 1 else x
            x, taken = flow.after(before, omega, amplitude, 1), taken + part
            ends.append(x)
        heard(taken)
        found.append([ends[-2], before, x])
    return found


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
