"""Floquet's multipliers of a periodic motion: what is stable, and how stability is lost.

    mu = eigenvalues of dH/dx to the power of the maps in a period;   stable: all |mu| < 1

One that leaves the unit circle at +1 marks a fold, or without one a pitchfork, where a second
branch crosses; at -1 the period doubles; a pair elsewhere gives a torus. Where H is half a period
followed by a symmetry, its own multipliers tell them apart: at -1 the second half of the motion
ceases to be the mirror image of the first, which is a pitchfork too (Swift and Wiesenfeld, Phys.
Rev. Lett. 52 (1984) 705: a symmetric motion does not double its period).
"""

from __future__ import annotations

from enum import StrEnum

import numpy as np

REAL = 1e-6  # of its size: an imaginary part that is rounding
# Nothing shows a motion whose disturbances grow so much in a period, and four digits of it are
# lost. A saddle that is driven at its own rate has exp(2 pi) = 535; S-curves of a snap-through at
# low frequencies pass some thousands on their way from one well to the other.
WILD = 1e4


class Kind(StrEnum):
    """What a point of a branch is."""

    REGULAR = "regular"
    FOLD = "fold"
    MINOR_FOLD = "minor_fold"  # one of two that lie closer than a width
    PITCHFORK = "pitchfork"
    PERIOD_DOUBLING = "period_doubling"
    TORUS = "torus"
    END = "end"


def leading_first(multipliers: np.ndarray) -> np.ndarray:
    """The largest first."""
    return multipliers[np.argsort(-np.abs(multipliers), kind="stable")]


def unstable(multipliers: np.ndarray) -> int:
    """How many are outside of the unit circle."""
    return int((np.abs(multipliers) > 1.0).sum())


def wild(multipliers: np.ndarray, parts: int) -> bool:
    """Do disturbances grow too much to follow the motion? `parts` maps make a period."""
    return bool(np.abs(multipliers).max() ** parts > WILD)


def growth(multipliers: np.ndarray, number: int) -> float:
    """Log |mu| of the `number`-th largest, from one: its sign changes where that one crosses."""
    return float(np.log(np.abs(leading_first(multipliers)[number - 1])))


def crossing(multiplier: complex, parts: int) -> Kind:
    """What it means that this multiplier of H crosses the circle; `parts` maps make a period."""
    if abs(multiplier.imag) > REAL * abs(multiplier):
        return Kind.TORUS
    if multiplier.real < 0.0 and parts == 1:
        return Kind.PERIOD_DOUBLING
    return Kind.PITCHFORK
