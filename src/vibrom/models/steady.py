"""How far a forced motion still changes:  c = max |x(t) - x(t - 5 T)| / max |x|,

at the end of a run and a quarter of a period before it, over the probes; T is the period of the
forcing. A steady response has c = 0 up to the errors of the integration; what is left of a
transient of damping ratio zeta shrinks by 10 pi zeta over those five periods, so that c = 0.01 with
zeta = 0.001 leaves a third of the amplitude open. Runs of five periods or fewer are not judged.
"""

import numpy as np

from vibrom.artefacts.outcome import Outcome
from vibrom.models.model import Watch

PERIODS = 5  # between two states that are compared


def strobe(period: np.ndarray, periods: int, samples: int, dofs: np.ndarray) -> Watch:
    """What to watch in runs of so many `period`s (b,) [s], known at `samples` instants of each."""
    ends = periods * samples - np.array([samples // 4, 0])
    steps = np.concatenate([ends - min(PERIODS, periods - 1) * samples, ends])
    return Watch(period[:, None] * steps / samples, dofs)


def change(seen: np.ndarray, amplitude: np.ndarray, periods: int) -> np.ndarray:
    """c (b,) of what `strobe` saw (b, 4, k) [m] and the largest displacements (b, k) [m] of the
    last period; NaN where it is not judged.
    """
    if periods <= PERIODS:
        return np.full(len(seen), np.nan)
    apart = np.abs(seen[:, 2:] - seen[:, :2]).max(axis=(1, 2))
    with np.errstate(invalid="ignore", divide="ignore"):
        return apart / np.abs(amplitude).max(axis=1)


def judged(outcome: np.ndarray, changes: np.ndarray, tolerance: float) -> np.ndarray:
    """The outcomes (b,); what ended as asked and changes by more than the tolerance is not
    steady.
    """
    unsteady = (outcome == Outcome.OK) & (changes > tolerance)
    return np.where(unsteady, Outcome.NOT_STEADY, outcome).astype(object)
