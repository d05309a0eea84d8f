"""The records that an integration consists of: what it is given, the runs under way, what is found.

Compiled code knows a record by the types of its fields, and reads them by their names.
"""

from typing import NamedTuple

import numpy as np
from numba import types

from vibrom.artefacts.outcome import Outcome
from vibrom.kernels.lanes import WIDTH
from vibrom.solvers.reduced.parts import maker, record, zeros

OUTCOMES = (Outcome.OK, Outcome.DIVERGED, Outcome.STEP_UNDERFLOW, Outcome.NO_CONVERGENCE)
OK, DIVERGED, STEP_UNDERFLOW, NO_CONVERGENCE = range(4)
RETRY = -1  # the verdict on a step that is to be taken again, shorter
HERMITE = 3  # terms
_f1, _f2, _f3 = types.float64[::1], types.float64[:, ::1], types.float64[:, :, ::1]
_i1 = types.int64[::1]


class Tolerance(NamedTuple):
    """What counts as an error of one step: atol + rtol |y|."""

    rtol: float
    atol: np.ndarray  # (r,)


class Bounds(NamedTuple):
    """Sizes |y| of which the loop takes note."""

    reach: np.ndarray  # (r,) beyond it a run has left its range, and goes on
    limit: np.ndarray  # (r,) beyond it a run has diverged, and ends


class Forcing(NamedTuple):
    """The signal a sin(w t) of each run."""

    amplitude: np.ndarray  # (b,)
    frequency: np.ndarray  # (b,) [rad/s]


class Problem(NamedTuple):
    """What the loop reads."""

    start: np.ndarray  # (b, r) at t = 0
    times: np.ndarray  # (b, m) ascending [s]; the last one is the end of the run
    first_step: np.ndarray  # (b,) [s]
    most_steps: np.ndarray  # (b,) attempts after which a run counts as underflown: it crawls
    tolerance: Tolerance
    bounds: Bounds
    forcing: Forcing


class Solution(NamedTuple):
    """What the loop writes."""

    samples: np.ndarray  # (b, m, r), NaN after a failure
    ending: np.ndarray  # (b,) places in OUTCOMES
    ended_at: np.ndarray  # (b,) [s]
    last: np.ndarray  # (b, r) the last state, which is finite
    peak: np.ndarray  # (b, r) the largest |y| at the ends of steps
    left_at: np.ndarray  # (b,) [s] the end of the first step beyond `reach`; NaN: never
    steps: np.ndarray  # (b,) accepted ones

    @property
    def outcome(self) -> list[Outcome]:
        """How each run ended."""
        return [OUTCOMES[place] for place in self.ending]


class Lanes(NamedTuple):
    """The runs under way."""

    run: np.ndarray  # (WIDTH,) place in the batch; -1: the lane is empty, and stands still
    tried: np.ndarray  # (WIDTH,) attempts
    sampled: np.ndarray  # (WIDTH,) instants behind it
    verdict: np.ndarray  # (WIDTH,) on the last attempt
    t: np.ndarray  # (WIDTH,) [s]
    end: np.ndarray  # (WIDTH,) [s]
    h: np.ndarray  # (WIDTH,) the next step [s]
    step: np.ndarray  # (WIDTH,) the last attempt [s]
    arrival: np.ndarray  # (WIDTH,) the end of the last attempt [s]
    y: np.ndarray  # (r, WIDTH) at t
    rate: np.ndarray  # (r, WIDTH) dy/dt at t
    new: np.ndarray  # (r, WIDTH) at arrival
    new_rate: np.ndarray  # (r, WIDTH)
    dense: np.ndarray  # (terms, r, WIDTH) of the interpolant


_TOLERANCE = record(Tolerance, types.float64, _f1)
PROBLEM = record(
    Problem, _f2, _f2, _f1, _i1, _TOLERANCE, record(Bounds, _f1, _f1), record(Forcing, _f1, _f1)
)
SOLUTION = record(Solution, _f3, _i1, _f1, _f2, _f2, _f1, _i1)


@maker
def lanes_for(r, terms):
    """Empty lanes for states of r numbers and interpolants of so many terms beyond Hermite's."""
    whole, lane = np.zeros((4, WIDTH), np.int64), zeros(5)
    whole[0] = -1
    return Lanes(
        whole[0],
        whole[1],
        whole[2],
        whole[3],
        lane[0],
        lane[1],
        lane[2],
        lane[3],
        lane[4],
        zeros(r),
        zeros(r),
        zeros(r),
        zeros(r),
        zeros((HERMITE + terms) * r).reshape(HERMITE + terms, r, WIDTH),
    )
