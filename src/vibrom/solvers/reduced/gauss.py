"""Gauss's implicit Runge-Kutta method of two stages and order 4, with fixed steps, for compiled
fields, eight runs side by side.

    K_i = f(t + c_i h, y + h sum_j A_ij K_j),   y <- y + h (K_1 + K_2)/2,    A = [[1/4, 1/4 - s],
    [1/4 + s, 1/4]],  c = 1/2 -+ s,  s = sqrt(3)/6

A-stable and symplectic: no step is too long for a damped mode, and no numerical damping hides what
a model does (Hairer, Lubich, Wanner, Geometric Numerical Integration, II.1.3). Newton's iteration
keeps the Jacobian of the step's start, taken by differences. A run whose iteration fails ends as
`no_convergence`, one that grows beyond `limit` as `diverged`. Samples come from the cubic through
value and slope at both ends of a step, which is of the method's order.
"""

import numpy as np
from numba import njit

from vibrom.kernels.lanes import WIDTH
from vibrom.solvers.reduced.field import Field, Solution, compiled, slope, solve

OUTCOMES = np.array(["ok", "diverged", "no_convergence"], dtype=object)
_OK, _DIVERGED, _FAILED = range(3)
_RUNNING = -1
_S = np.sqrt(3.0) / 6.0
_A11, _A12, _A21, _A22, _C1, _C2 = 0.25, 0.25 - _S, 0.25 + _S, 0.25, 0.5 - _S, 0.5 + _S
ITERATIONS = 20
# of the range: the differences behind the Jacobian; half the digits, which costs Newton an
# iteration and the solution nothing
NUDGE = 1e-7


@njit
def _eliminate(matrix, right):
    """Solves matrix x = right in place, by Gauss's elimination with row exchanges."""
    n = len(right)
    for k in range(n):
        top = k
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > abs(matrix[top, k]):
                top = i
        if top != k:
            for j in range(k, n):
                matrix[k, j], matrix[top, j] = matrix[top, j], matrix[k, j]
            right[k], right[top] = right[top], right[k]
        for i in range(k + 1, n):
            part = matrix[i, k] / matrix[k, k]
            for j in range(k + 1, n):
                matrix[i, j] -= part * matrix[k, j]
            right[i] -= part * right[k]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            right[i] -= matrix[i, j] * right[j]
        right[i] /= matrix[i, i]


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
    """Integrates all runs, eight after eight, and fills the last six arrays; returns the number of
    steps.
    """
    runs, r = start.shape
    m, longest, rtol, taken = times.shape[1], numbers[0], numbers[1], 0
    t, h, instant, signal, amplitude, frequency = (
        np.zeros(WIDTH),
        np.zeros(WIDTH),
        np.zeros(WIDTH),
        np.zeros(WIDTH),
        np.zeros(WIDTH),
        np.zeros(WIDTH),
    )
    run, steps, wanted, status = (
        np.zeros(WIDTH, np.int64),
        np.zeros(WIDTH, np.int64),
        np.zeros(WIDTH, np.int64),
        np.zeros(WIDTH, np.int64),
    )
    done = np.zeros(WIDTH, np.bool_)
    y, f, new, ahead, stage, push = (
        np.zeros((r, WIDTH)),
        np.zeros((r, WIDTH)),
        np.zeros((r, WIDTH)),
        np.zeros((r, WIDTH)),
        np.zeros((r, WIDTH)),
        np.zeros((r, WIDTH)),
    )
    k, found, jacobian = np.zeros((2, r, WIDTH)), np.zeros((2, r, WIDTH)), np.zeros((r, r, WIDTH))
    matrix, right = np.zeros((2 * r, 2 * r)), np.zeros(2 * r)
    for first in range(0, runs, WIDTH):
        longest_run = 0
        for w in range(WIDTH):
            run[w] = min(first + w, runs - 1)
            status[w] = (
                _RUNNING if first + w < runs else _OK
            )  # the last run fills the batch, and its copies stand still
            end = times[run[w], m - 1]
            steps[w] = max(int(np.ceil(end / longest)), 1)
            longest_run = max(longest_run, steps[w])
            t[w], h[w], wanted[w], amplitude[w], frequency[w] = (
                0.0,
                end / steps[w],
                0,
                amplitudes[run[w]],
                frequencies[run[w]],
            )
            for i in range(r):
                y[i, w] = start[run[w], i]
            if status[w] == _RUNNING:
                for i in range(r):
                    last[run[w], i], peak[run[w], i] = y[i, w], abs(y[i, w])
                while wanted[w] < m and times[run[w], wanted[w]] <= 0.0:
                    samples[run[w], wanted[w]] = start[run[w]]
                    wanted[w] += 1
        slope(
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
            f,
        )
        for number in range(longest_run):
            for j in range(r):
                for i in range(r):
                    for w in range(WIDTH):
                        stage[i, w] = y[i, w] + (NUDGE * reach[j] if i == j else 0.0)
                slope(
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
                    stage,
                    push,
                    found[0],
                )
                for i in range(r):
                    for w in range(WIDTH):
                        jacobian[i, j, w] = (found[0, i, w] - f[i, w]) / (NUDGE * reach[j])
            for w in range(WIDTH):
                done[w] = status[w] != _RUNNING
                for i in range(r):
                    k[0, i, w], k[1, i, w] = f[i, w], f[i, w]
            for iteration in range(ITERATIONS):
                for s in range(2):
                    a, b, c = (_A11, _A12, _C1) if s == 0 else (_A21, _A22, _C2)
                    for w in range(WIDTH):
                        instant[w] = t[w] + c * h[w]
                        for i in range(r):
                            stage[i, w] = y[i, w] + h[w] * (a * k[0, i, w] + b * k[1, i, w])
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
                        found[s],
                    )
                all_done = True
                for w in range(WIDTH):
                    if done[w]:
                        continue
                    for i in range(r):
                        right[i], right[r + i] = (
                            found[0, i, w] - k[0, i, w],
                            found[1, i, w] - k[1, i, w],
                        )
                        for j in range(r):
                            one, part = (1.0 if i == j else 0.0), h[w] * jacobian[i, j, w]
                            matrix[i, j], matrix[i, r + j] = one - _A11 * part, -_A12 * part
                            matrix[r + i, j], matrix[r + i, r + j] = -_A21 * part, one - _A22 * part
                    _eliminate(matrix, right)
                    small = True
                    for i in range(r):
                        k[0, i, w] += right[i]
                        k[1, i, w] += right[r + i]
                        size = h[w] * max(abs(right[i]), abs(right[r + i]))
                        small = small and size <= 0.1 * (
                            atol[i] + rtol * abs(y[i, w])
                        )  # False for NaN too
                    done[w] = small
                    all_done = all_done and small
                if all_done:
                    break
            for w in range(WIDTH):
                going = status[w] == _RUNNING
                for i in range(r):
                    new[i, w] = y[i, w] + (
                        0.5 * h[w] * (k[0, i, w] + k[1, i, w]) if going and done[w] else 0.0
                    )
                instant[w] = times[run[w], m - 1] if number + 1 == steps[w] else (number + 1) * h[w]
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
                new,
                push,
                ahead,
            )
            any_left = False
            for w in range(WIDTH):
                if status[w] != _RUNNING:
                    continue
                j = run[w]
                if not done[w]:
                    status[w] = _FAILED
                else:
                    taken += 1
                    while wanted[w] < m and times[j, wanted[w]] <= instant[w]:
                        x = (times[j, wanted[w]] - t[w]) / h[w]
                        for i in range(r):
                            change = new[i, w] - y[i, w]
                            samples[j, wanted[w], i] = (
                                y[i, w]
                                + x * change
                                + x
                                * (1.0 - x)
                                * (
                                    (1.0 - x) * (h[w] * f[i, w] - change)
                                    - x * (h[w] * ahead[i, w] - change)
                                )
                            )
                        wanted[w] += 1
                    outside, blown = False, False
                    for i in range(r):
                        y[i, w] = last[j, i] = new[i, w]
                        f[i, w] = ahead[i, w]
                        size = abs(new[i, w])
                        peak[j, i] = max(peak[j, i], size)
                        outside = outside or size > reach[i]
                        blown = blown or not size <= limit[i]
                    t[w] = instant[w]
                    if outside and left_at[j] != left_at[j]:
                        left_at[j] = t[w]
                    if blown:
                        status[w] = _DIVERGED
                    elif number + 1 == steps[w]:
                        status[w] = _OK
                if status[w] != _RUNNING:
                    outcome[j], ended_at[j], h[w] = status[w], t[w], 0.0
                    for i in range(r):
                        y[i, w] = 0.0
                else:
                    any_left = True
            if not any_left:
                break
    return taken


_compiled = compiled(_loop)


def integrate(
    field: Field,
    start: np.ndarray,
    times: np.ndarray,
    *,
    step: float,
    rtol: float,
    atol: np.ndarray,
    reach: np.ndarray,
    limit: np.ndarray,
    amplitude: np.ndarray | None = None,
    frequency: np.ndarray | None = None,
) -> Solution:
    """As `dop853_loop.integrate`, in equal steps of at most `step` [s]; the tolerances are those of
    Newton's iteration.
    """
    return solve(
        _compiled,
        OUTCOMES,
        field,
        start,
        times,
        (step, rtol),
        atol=atol,
        reach=reach,
        limit=limit,
        amplitude=amplitude,
        frequency=frequency,
    )
