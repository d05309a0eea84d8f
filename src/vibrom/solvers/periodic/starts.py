"""Guesses of motions that do not hang together with rest: near the backbone, and at the ends of
sweeps.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vibrom.solvers.periodic.carried import swept
from vibrom.solvers.periodic.continuation import Lost
from vibrom.solvers.periodic.maps import ReturnMap
from vibrom.solvers.periodic.resonance import backbone
from vibrom.solvers.periodic.response import Near

BEYOND = 2.0  # times the forcing: how far a backbone is followed that may come back


def from_backbone(
    flow: ReturnMap,
    amplitude: float,
    points: int,
    turn: float,
    heard: Callable[[int], object] = int,
) -> list[Near]:
    """Where a backbone of so many points passes this amplitude of the forcing: the peak of every
    branch, and the foot of every isola.
    """
    try:
        return backbone(flow, BEYOND * amplitude, points, turn, heard).near(amplitude)
    except Lost:
        return []


def from_sweeps(
    flow: ReturnMap,
    amplitude: float,
    frequency: np.ndarray,
    periods: int,
    heard: Callable[[int], object] = int,
) -> list[Near]:
    """The motions after so many periods at each frequency (k,), upwards and downwards."""
    return [
        (x, omega)
        for frequencies in (frequency, frequency[::-1])
        for x, omega in zip(
            swept(flow, frequencies, amplitude, periods, heard=lambda _: heard(1)),
            frequencies.tolist(),
        )
    ]
