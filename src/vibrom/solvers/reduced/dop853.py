"""Dormand and Prince's Runge-Kutta method of order 8(5,3), many states side by side, each with its
own adaptive step.

The coefficients are SciPy's (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I,
II.5). Each state keeps its own time, step and error control, and may end before the others: when it
grows beyond `limit` or stops being finite (`diverged`), or when its step no longer changes its time
(`step_underflow`). Between steps the seventh-order interpolant serves any instant.

This form takes any numpy function; `dop853_loop` does the same for compiled ones.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import DOP853

from vibrom.solvers.reduced.field import Solution

A, B, C, E3, E5, D = DOP853.A, DOP853.B, DOP853.C, DOP853.E3, DOP853.E5, DOP853.D
A_EXTRA, C_EXTRA = DOP853.A_EXTRA, DOP853.C_EXTRA
STAGES = DOP853.n_stages
SAFETY, SLOWEST, FASTEST = 0.9, 0.2, 10.0
Field = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]


def integrate(
    field: Field,
    start: np.ndarray,
    times: np.ndarray,
    *,
    rtol: float,
    atol: np.ndarray,
    first_step: np.ndarray,
    reach: np.ndarray,
    limit: np.ndarray,
    max_steps: int,
) -> Solution:
    """Solve dy/dt = field(t, y, run) from `start` (b, r) at t = 0 to times[:, -1]; `times` (b, m)
    ascending [s].

    A run that needs more than `max_steps` steps counts as underflown: it crawls.
    `field` takes t (k,), y (k, r) and the numbers of the runs (k,) that are still going; atol,
    reach and limit are (r,).
    """
    runs, dimension = start.shape
    t, y, h = (
        np.zeros(runs),
        start.astype(float),
        np.array(np.broadcast_to(first_step, runs), dtype=float),
    )
    f = field(t, y, np.arange(runs))
    end, wanted = times[:, -1], times[:, 0]
    outcome = np.full(runs, "ok", dtype=object)
    left_at, peak = np.full(runs, np.nan), np.abs(start)
    active = np.ones(runs, bool)
    rejected = np.zeros(runs, bool)
    records: list[tuple] = []
    accepted_steps = 0
    with np.errstate(all="ignore"):  # a model that blows up is a result, not a warning
        for _ in range(max_steps):
            (run,) = np.nonzero(active)
            if len(run) == 0:
                break
            tk, yk = t[run], y[run]
            hk = np.minimum(h[run], end[run] - tk)
            stages = np.empty((STAGES + 4, len(run), dimension))
            stages[0] = f[run]
            for s in range(1, STAGES):
                stages[s] = field(
                    tk + C[s] * hk, yk + hk[:, None] * _combine(A[s, :s], stages[:s]), run
                )
            new = yk + hk[:, None] * _combine(B, stages[:STAGES])
            stages[STAGES] = field(tk + hk, new, run)
            scale = atol + rtol * np.maximum(np.abs(yk), np.abs(new))
            e5 = np.sum((_combine(E5, stages[: STAGES + 1]) / scale) ** 2, axis=1)
            e3 = np.sum((_combine(E3, stages[: STAGES + 1]) / scale) ** 2, axis=1)
            error = np.where(e5 == 0.0, 0.0, hk * e5 / np.sqrt((e5 + 0.01 * e3) * dimension))
            good = error < 1.0  # False for NaN too
            factor = np.where(error == 0.0, FASTEST, SAFETY * error ** (-1 / 8))
            factor = np.where(np.isfinite(factor), factor, SLOWEST)
            factor = np.clip(factor, SLOWEST, np.where(good & ~rejected[run], FASTEST, 1.0))
            rejected[run] = ~good
            keep = good & (tk + hk >= wanted[run])
            if keep.any():
                records.append(
                    _dense(
                        field, stages[:, keep], tk[keep], yk[keep], new[keep], hk[keep], run[keep]
                    )
                )
            done = run[good]
            accepted_steps += len(done)
            # Landing on the end exactly, not by a sum that may fall short of it.
            t[done] = np.where(hk[good] == end[done] - tk[good], end[done], tk[good] + hk[good])
            y[done], f[done] = new[good], stages[STAGES, good]
            h[run] = hk * factor
            size = np.abs(y[done])
            peak[done] = np.maximum(peak[done], size)
            outside = np.isnan(left_at[done]) & (size > reach).any(axis=1)
            left_at[done[outside]] = t[done[outside]]
            blown = done[~(size <= limit).all(axis=1)]
            # A last step may be as short as it likes.
            stuck = run[
                (t[run] < end[run])
                & (h[run] < 10 * np.spacing(np.maximum(t[run], np.finfo(float).tiny)))
            ]
            outcome[stuck], outcome[blown] = "step_underflow", "diverged"
            active[blown] = active[stuck] = False
            active &= t < end
        outcome[active] = "step_underflow"
    return Solution(
        _sample(records, times, start, t, outcome), outcome, t, y, peak, left_at, accepted_steps
    )


def _combine(weights: np.ndarray, stages: np.ndarray) -> np.ndarray:
    return (weights @ stages.reshape(len(weights), -1)).reshape(stages.shape[1:])


def _dense(field: Field, stages: np.ndarray, t, old, new, h, run) -> tuple:
    """Coefficients (7, k, r) of the interpolant over one step of k runs; needs three more
    evaluations.
    """
    stages = np.ascontiguousarray(stages)
    for extra, (a, c) in enumerate(zip(A_EXTRA, C_EXTRA), start=STAGES + 1):
        stages[extra] = field(
            t + c * h, old + h[:, None] * _combine(a[:extra], stages[:extra]), run
        )
    change, wide = new - old, h[:, None]
    coefficients = np.empty((7, *old.shape))
    coefficients[0] = change
    coefficients[1] = wide * stages[0] - change
    coefficients[2] = 2 * change - wide * (stages[STAGES] + stages[0])
    coefficients[3:] = wide * (D @ stages.reshape(len(stages), -1)).reshape(4, *old.shape)
    return run, t, h, old, coefficients


def _sample(
    records: list[tuple],
    times: np.ndarray,
    start: np.ndarray,
    reached: np.ndarray,
    outcome: np.ndarray,
) -> np.ndarray:
    samples = np.full((*times.shape, start.shape[1]), np.nan)
    if records:
        run, t, h = (np.concatenate([record[k] for record in records]) for k in range(3))
        old = np.concatenate([record[3] for record in records])
        coefficients = np.concatenate([record[4] for record in records], axis=1)
        order = np.argsort(run, kind="stable")  # steps of one run stay in the order of time
        bounds = np.searchsorted(run[order], np.arange(len(times) + 1))
        for index, instants in enumerate(times):
            steps = order[bounds[index] : bounds[index + 1]]
            if len(steps) == 0:
                continue
            inside = instants <= reached[index]
            step = steps[
                np.clip(np.searchsorted(t[steps], instants[inside], side="right") - 1, 0, None)
            ]
            x = ((instants[inside] - t[step]) / h[step])[:, None]
            value = np.zeros((len(step), start.shape[1]))
            for k in range(7):
                value = (value + coefficients[6 - k, step]) * (x if k % 2 == 0 else 1.0 - x)
            samples[index, inside] = old[step] + value
    samples[:, 0][times[:, 0] == 0.0] = start[times[:, 0] == 0.0]
    return samples
