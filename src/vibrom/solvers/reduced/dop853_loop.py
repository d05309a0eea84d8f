"""The compiled form of `dop853`: eight runs side by side, no Python between the first step and the
last.

    dy/dt = drift(y) + force(y) a sin(w t)

Each lane carries one run with its own time, step and error control. When a run ends, by reaching
its end or by an event, its lane takes the next of the queue, so no lane waits for another. The
samples are those of the seventh-order interpolant, written as the steps go by.
"""

import numpy as np
from numba import njit

from vibrom.kernels.lanes import WIDTH, get, put, sqrt
from vibrom.solvers.reduced.dop853 import (
    A_EXTRA,
    C_EXTRA,
    E3,
    E5,
    FASTEST,
    SAFETY,
    SLOWEST,
    STAGES,
    A,
    B,
    C,
    D,
)
from vibrom.solvers.reduced.field import Field, Solution, compiled, slope, solve

OUTCOMES = np.array(["ok", "diverged", "step_underflow"], dtype=object)
_OK, _DIVERGED, _UNDERFLOW = range(3)
_ALL = STAGES + 4  # with the slope at the end of the step and the three stages of the interpolant
_TINY = np.finfo(float).tiny
# Row s: the weights of the slopes before it that lead to stage s; the extra stages follow the slope
# at the end.
_WEIGHTS = np.zeros((_ALL, _ALL))
_WEIGHTS[:STAGES, :STAGES], _WEIGHTS[STAGES, :STAGES], _WEIGHTS[STAGES + 1 :, :_ALL] = (
    A[:STAGES, :STAGES],
    B,
    A_EXTRA,
)
_NODES = np.concatenate([C[:STAGES], [1.0], C_EXTRA])


@njit
def _weighed(weights, count, slopes, i):
    """sum_j weights_j slopes_j of coordinate i."""
    r, total = slopes.shape[1], get(slopes, i, WIDTH) * weights[0]
    for j in range(1, count):
        if weights[j] != 0.0:  # a third of them
            total = total + get(slopes, j * r + i, WIDTH) * weights[j]
    return total


def _loop(
    drift,
    drift_tables,
    force,
    force_tables,
    driven,
    amplitudes,
    frequencies,
    work,
    start,
    times,
    numbers,
    atol,
    reach,
    limit,
    samples,
    outcome,
    ended_at,
    last,
    peak,
    left_at,
):
    """Integrates all runs and fills the last six arrays; returns the number of accepted steps."""
    runs, r = start.shape
    m, rtol, first_step, max_steps = times.shape[1], numbers[0], numbers[1], int(numbers[2])
    run, tried, wanted, rejected, fresh = (
        np.full(WIDTH, -1),
        np.zeros(WIDTH, np.int64),
        np.zeros(WIDTH, np.int64),
        np.zeros(WIDTH, np.bool_),
        np.zeros(WIDTH, np.bool_),
    )
    good, t, h, hk, instant = (
        np.zeros(WIDTH, np.bool_),
        np.zeros(WIDTH),
        np.zeros(WIDTH),
        np.zeros(WIDTH),
        np.zeros(WIDTH),
    )
    amplitude, frequency, signal, error = (
        np.zeros(WIDTH),
        np.zeros(WIDTH),
        np.zeros(WIDTH),
        np.zeros(WIDTH),
    )
    y, new, stage, push = (
        np.zeros((r, WIDTH)),
        np.zeros((r, WIDTH)),
        np.zeros((r, WIDTH)),
        np.zeros((r, WIDTH)),
    )
    slopes, dense = np.zeros((_ALL, r, WIDTH)), np.zeros((7, r, WIDTH))
    queue, going, accepted = 0, 0, 0
    while True:
        started = False
        for w in range(WIDTH):
            fresh[w] = run[w] < 0 and queue < runs
            if fresh[w]:
                started = True
                going += 1
                k = queue
                queue += 1
                run[w], t[w], h[w], tried[w], wanted[w], rejected[w] = (
                    k,
                    0.0,
                    first_step,
                    0,
                    0,
                    False,
                )
                amplitude[w], frequency[w] = amplitudes[k], frequencies[k]
                for i in range(r):
                    y[i, w] = last[k, i] = start[k, i]
                    peak[k, i] = abs(start[k, i])
                while wanted[w] < m and times[k, wanted[w]] <= 0.0:
                    samples[k, wanted[w]] = start[k]
                    wanted[w] += 1
        if going == 0:
            return accepted
        if started:
            instant[:] = t
            slope(
                drift,
                drift_tables,
                force,
                force_tables,
                driven,
                amplitude,
                frequency,
                work,
                instant,
                signal,
                y,
                push,
                slopes[1],
            )
            for i in range(r):
                for w in range(WIDTH):
                    if fresh[w]:
                        slopes[0, i, w] = slopes[1, i, w]
        for w in range(WIDTH):
            hk[w] = (
                min(h[w], times[run[w], m - 1] - t[w]) if run[w] >= 0 else 0.0
            )  # an empty lane stands still
        step = get(hk, 0, WIDTH)
        for s in range(1, STAGES + 1):
            target = new if s == STAGES else stage
            for i in range(r):
                put(target, i, get(y, i, WIDTH) + step * _weighed(_WEIGHTS[s], s, slopes, i))
            for w in range(WIDTH):
                instant[w] = t[w] + _NODES[s] * hk[w]
            slope(
                drift,
                drift_tables,
                force,
                force_tables,
                driven,
                amplitude,
                frequency,
                work,
                instant,
                signal,
                target,
                push,
                slopes[s],
            )
        fifth, third = step * 0.0, step * 0.0
        for i in range(r):
            for w in range(WIDTH):
                instant[w] = atol[i] + rtol * max(abs(y[i, w]), abs(new[i, w]))
            scale = get(instant, 0, WIDTH)
            e5, e3 = (
                _weighed(E5, STAGES + 1, slopes, i) / scale,
                _weighed(E3, STAGES + 1, slopes, i) / scale,
            )
            fifth, third = fifth + e5 * e5, third + e3 * e3
        put(error, 0, step * fifth / sqrt((fifth + third * 0.01 + _TINY) * r))
        sampling = False
        for w in range(WIDTH):
            good[w] = run[w] >= 0 and error[w] < 1.0  # False for NaN too
            if good[w] and wanted[w] < m and times[run[w], wanted[w]] <= t[w] + hk[w]:
                sampling = True
        if sampling:
            for s in range(STAGES + 1, _ALL):
                for i in range(r):
                    put(stage, i, get(y, i, WIDTH) + step * _weighed(_WEIGHTS[s], s, slopes, i))
                for w in range(WIDTH):
                    instant[w] = t[w] + _NODES[s] * hk[w]
                slope(
                    drift,
                    drift_tables,
                    force,
                    force_tables,
                    driven,
                    amplitude,
                    frequency,
                    work,
                    instant,
                    signal,
                    stage,
                    push,
                    slopes[s],
                )
            for i in range(r):
                change = get(new, i, WIDTH) - get(y, i, WIDTH)
                put(dense[0], i, change)
                put(dense[1], i, step * get(slopes[0], i, WIDTH) - change)
                put(
                    dense[2],
                    i,
                    2.0 * change
                    - step * (get(slopes[STAGES], i, WIDTH) + get(slopes[0], i, WIDTH)),
                )
                for k in range(4):
                    put(dense[3 + k], i, step * _weighed(D[k], _ALL, slopes, i))
        for w in range(WIDTH):
            k = run[w]
            if k < 0:
                continue
            end = times[k, m - 1]
            tried[w] += 1
            factor = FASTEST if error[w] == 0.0 else SAFETY / np.sqrt(np.sqrt(np.sqrt(error[w])))
            factor = (
                min(max(factor, SLOWEST), FASTEST if good[w] and not rejected[w] else 1.0)
                if factor == factor
                else SLOWEST
            )
            rejected[w] = not good[w]
            h[w] = hk[w] * factor
            blown = False
            if good[w]:
                accepted += 1
                # Landing on the end exactly, not by a sum that may fall short of it.
                now = end if hk[w] == end - t[w] else t[w] + hk[w]
                while wanted[w] < m and times[k, wanted[w]] <= now:
                    x = (times[k, wanted[w]] - t[w]) / hk[w]
                    for i in range(r):
                        value = 0.0
                        for j in range(7):
                            value = (value + dense[6 - j, i, w]) * (x if j % 2 == 0 else 1.0 - x)
                        samples[k, wanted[w], i] = y[i, w] + value
                    wanted[w] += 1
                outside = False
                for i in range(r):
                    y[i, w] = last[k, i] = new[i, w]
                    slopes[0, i, w] = slopes[STAGES, i, w]
                    size = abs(new[i, w])
                    peak[k, i] = max(peak[k, i], size)
                    outside = outside or size > reach[i]
                    blown = blown or not size <= limit[i]
                if outside and left_at[k] != left_at[k]:
                    left_at[k] = now
                t[w] = now
            over = t[w] >= end
            stuck = not over and (tried[w] >= max_steps or h[w] < 10 * np.spacing(max(t[w], _TINY)))
            if blown or stuck or over:
                outcome[k] = _DIVERGED if blown else _UNDERFLOW if stuck else _OK
                ended_at[k] = t[w]
                run[w], going, hk[w], t[w], amplitude[w] = -1, going - 1, 0.0, 0.0, 0.0
                for i in range(r):
                    y[i, w] = 0.0


_compiled = compiled(_loop)


def integrate(
    field: Field,
    start: np.ndarray,
    times: np.ndarray,
    *,
    rtol: float,
    atol: np.ndarray,
    first_step: float,
    reach: np.ndarray,
    limit: np.ndarray,
    max_steps: int,
    amplitude: np.ndarray | None = None,
    frequency: np.ndarray | None = None,
) -> Solution:
    """As `dop853.integrate`, for a compiled field; arguments as those of `field.solve`."""
    return solve(
        _compiled,
        OUTCOMES,
        field,
        start,
        times,
        (rtol, first_step, max_steps),
        atol=atol,
        reach=reach,
        limit=limit,
        amplitude=amplitude,
        frequency=frequency,
    )
