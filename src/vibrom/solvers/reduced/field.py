"""Reduced models in compiled code:  dy/dt = drift(y) + force(y) a sin(w t), WIDTH runs side by
side, and what the loops over time share.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit, types
from numba.core.errors import NumbaExperimentalFeatureWarning

from vibrom.kernels.lanes import WIDTH, get, kernel, put

_f1, _f2, _f3, _i1 = (
    types.float64[::1],
    types.float64[:, ::1],
    types.float64[:, :, ::1],
    types.int64[::1],
)
# out (r, WIDTH) = f(y (r, WIDTH)); numbers and index are the map's own tables, work its scratch of
# `rows` times WIDTH.
KERNEL = types.void(_f2, _f1, _i1, _f1, _f2)
_MAP = (types.FunctionType(KERNEL), types.Tuple((_f1, _i1)))
# Drift and force, driven or not, amplitude and frequency of each run, scratch; start, times, the
# method's own numbers, atol, reach, limit; and to be filled: samples, outcome, ended_at, last,
# peak, left_at. Gives the number of accepted steps.
_LOOP = types.int64(
    *_MAP,
    *_MAP,
    types.boolean,
    _f1,
    _f1,
    _f1,
    _f2,
    _f2,
    _f1,
    _f1,
    _f1,
    _f1,
    _f3,
    _i1,
    _f1,
    _f2,
    _f2,
    _f1,
)
field_kernel = kernel(KERNEL, fastmath=False)  # compiles `function(y, numbers, index, work, out)`


@dataclass(frozen=True)
class Kernel:
    """A compiled map, its tables of numbers and of integers, and the rows of scratch that it needs."""

    function: Callable
    numbers: np.ndarray
    index: np.ndarray
    rows: int


@dataclass(frozen=True)
class Field:
    """Without a force the model is left alone."""

    drift: Kernel
    force: Kernel | None = None


@dataclass(frozen=True)
class Solution:
    """Samples (b, m, r) at the asked instants, NaN after a failure; outcome, end time [s] and last
    finite state of each of the b runs; peak (b, r): the largest |y|; left_at (b,): when |y| first
    exceeded `reach`, NaN if never; steps accepted in all.
    """

    samples: np.ndarray
    outcome: np.ndarray
    ended_at: np.ndarray
    last: np.ndarray
    peak: np.ndarray
    left_at: np.ndarray
    steps: int


@njit
def slope(
    drift,
    drift_tables,
    force,
    force_tables,
    driven,
    amplitude,
    frequency,
    work,
    t,
    signal,
    y,
    push,
    out,
):
    """Out = dy/dt of WIDTH runs at their times t (WIDTH,); `signal` (WIDTH,) and `push` (r, WIDTH)
    are scratch.
    """
    drift(y, drift_tables[0], drift_tables[1], work, out)
    if driven:
        force(y, force_tables[0], force_tables[1], work, push)
        for w in range(WIDTH):
            signal[w] = amplitude[w] * np.sin(frequency[w] * t[w])
        now = get(signal, 0, WIDTH)
        for i in range(len(y)):
            put(out, i, get(out, i, WIDTH) + get(push, i, WIDTH) * now)


def compiled(loop: Callable) -> Callable:
    """A loop over time with the arguments of `_LOOP`."""
    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore", NumbaExperimentalFeatureWarning
        )  # maps passed as function pointers
        return kernel(_LOOP, fastmath={"contract"})(loop)


def solve(
    loop: Callable,
    outcomes: np.ndarray,
    field: Field,
    start: np.ndarray,
    times: np.ndarray,
    numbers: tuple[float, ...],
    *,
    atol: np.ndarray,
    reach: np.ndarray,
    limit: np.ndarray,
    amplitude: np.ndarray | None,
    frequency: np.ndarray | None,
) -> Solution:
    """What the compiled `loop` makes of `start` (b, r) at `times` (b, m) ascending [s]; a force
    acts with amplitude (b,) and angular frequency (b,) [rad/s].

    Raises ValueError where a force has no amplitude or frequency.
    """
    runs, r = start.shape
    driven = field.force is not None
    if driven and (amplitude is None or frequency is None):
        raise ValueError("a field with a force needs the amplitude and the frequency of each run")
    force = field.force if driven else field.drift
    still = np.zeros(runs)
    # Copies: compiled code asks for arrays that may be written to.
    start, times, own, atol, reach, limit, amplitude, frequency = (
        np.array(value, dtype=float, order="C")
        for value in (
            start,
            times,
            numbers,
            atol,
            reach,
            limit,
            *((amplitude, frequency) if driven else (still, still)),
        )
    )
    samples, outcome = np.full((*times.shape, r), np.nan), np.zeros(runs, np.int64)
    ended_at, last, peak, left_at = (
        np.zeros(runs),
        np.empty((runs, r)),
        np.empty((runs, r)),
        np.full(runs, np.nan),
    )
    work = np.zeros(WIDTH * max(field.drift.rows, force.rows))
    steps = loop(
        field.drift.function,
        (field.drift.numbers, field.drift.index),
        force.function,
        (force.numbers, force.index),
        driven,
        amplitude,
        frequency,
        work,
        start,
        times,
        own,
        atol,
        reach,
        limit,
        samples,
        outcome,
        ended_at,
        last,
        peak,
        left_at,
    )
    return Solution(samples, outcomes[outcome], ended_at, last, peak, left_at, int(steps))
