"""Where a motion passes a kink of its vector field, |z_i| = Z_i, and steps that are short there.

    z_i(s) by Hermite's cubic through the beginning and end of a step and the velocities there

A Runge-Kutta step over a kink has an error of the second power of the step, whatever its order, and
its derivative one of the first power. Short steps over the kinks keep both small, and the others
see a smooth field.
"""

from __future__ import annotations

import numpy as np

HALF = 1e-4  # of the whole: of a short step
ROUNDS = 3  # of Newton's iteration, from the chord
SAME = 0.25  # of half a short step
APART = 1e-9  # of the whole: passages nearer to each other are one


def passed(
    path: np.ndarray,  # (n + 1, d) z in units of Z
    rate: np.ndarray,  # (n + 1, d) dz/ds
    at: np.ndarray,  # (n + 1,) s, from zero to one
) -> np.ndarray:
    """(k,) the s at which |z_i| = 1 for any i, in order."""
    found = []
    beyond = np.abs(path) > 1.0
    for step, axis in zip(*np.nonzero(beyond[1:] != beyond[:-1])):
        ends, h = path[step : step + 2, axis].tolist(), float(at[step + 1] - at[step])
        sign = 1.0 if ends[0] + ends[1] > 0.0 else -1.0
        a, b = (sign * end - 1.0 for end in ends)
        da, db = (sign * h * float(slope) for slope in rate[step : step + 2, axis])
        square, cubic = 3.0 * (b - a) - 2.0 * da - db, 2.0 * (a - b) + da + db
        x = a / (a - b)
        for _ in range(ROUNDS):
            slope = da + x * (2.0 * square + 3.0 * x * cubic)
            x -= (a + x * (da + x * (square + x * cubic))) / (slope or 1.0)
        found.append(float(at[step]) + h * min(max(x, 0.0), 1.0))
    found = np.sort(found)
    return found[np.diff(found, prepend=0.0, append=1.0)[:-1] > APART]


def moved(old: np.ndarray, new: np.ndarray) -> bool:
    """Are these other passages?"""
    return len(old) != len(new) or bool(np.abs(old - new).max(initial=0.0) > SAME * HALF)


def between(number: int, at: np.ndarray) -> np.ndarray:
    """(n + 1,) from zero to one: `number` equal steps, but for short ones over kinks `at` (k,)."""
    around = np.clip(np.sort(np.concatenate([at - HALF, at + HALF])), 0.0, 1.0)
    ends = np.unique(np.concatenate([[0.0], around, [1.0]]))
    counts = np.maximum(np.ceil(number * np.diff(ends) - 1e-3), 1.0).astype(int)
    first = np.concatenate([[0], np.cumsum(counts)])
    return np.interp(np.arange(first[-1] + 1), first, ends)
