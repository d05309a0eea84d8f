"""How far a forced motion still changes:  c = max_k |x(t) - x(t - k T)| / max |x|,

k = 1, 2, 4, ..., N/4 periods T of the forcing, in a run of N periods, at its end and a quarter of a
period before it, at the probes. A steady response has c = 0 up to the errors of the integration. Of
a transient a exp(-s t / (N T)) of the amplitude, in step with the forcing, the end has a e^-s left
and c is a e^-s (e^(s/4) - 1) / (1 - a e^-s). From rest at resonance a = 1: a light damping leaves c
near 1/4, however small s is, and a c below 1/20 is more than what is left. Runs of less than four
periods are not judged.
"""

import numpy as np
import xarray as xr

from vibrom.artefacts.data import variable
from vibrom.artefacts.outcome import Outcome
from vibrom.models.model import Watch

PART = 4  # of a run: its last fourth is compared with itself


def strobe(period: np.ndarray, periods: int, samples: int, dofs: np.ndarray) -> Watch:
    """What to watch in runs of so many `period`s (b,) [s], known at `samples` instants of each."""
    quarter = -(-periods // PART)
    lags = {0, quarter, *(2**k for k in range(quarter.bit_length()) if 2**k < quarter)}
    ends = periods * samples - np.array([samples // 4, 0])
    steps = ends - samples * np.array(sorted(lags, reverse=True))[:, None]
    return Watch(period[:, None] * np.maximum(steps, 0).ravel() / samples, dofs)


def change(seen: np.ndarray, amplitude: np.ndarray, periods: int) -> np.ndarray:
    """c (b,) of what `strobe` saw (b, m, k) [m] and the largest displacements (b, k) [m] of the
    last period; NaN where it is not judged.
    """
    if periods < PART:
        return np.full(len(seen), np.nan)
    moments = seen.reshape(len(seen), -1, 2, seen.shape[-1])
    apart = np.abs(moments[:, -1:] - moments[:, :-1]).max(axis=(1, 2, 3))
    with np.errstate(invalid="ignore", divide="ignore"):
        return apart / np.abs(amplitude).max(axis=1)


def change_variable(dims: tuple[str, ...] | str, changes: np.ndarray) -> dict[str, xr.Variable]:
    """As answers keep it."""
    words = "change in the last quarter of the run, over the amplitude"
    return {"change": variable(dims, changes, "1", words)}


def judged(outcome: np.ndarray, changes: np.ndarray, tolerance: float) -> np.ndarray:
    """The outcomes (b,); what has a value and changes by more than the tolerance is not steady,
    within the training range or beyond it.
    """
    unsteady = np.isin(outcome.astype(str), [Outcome.OK, Outcome.LEFT_RANGE])
    unsteady &= changes > tolerance
    return np.where(unsteady, Outcome.NOT_STEADY, outcome).astype(object)
