"""A vector field under loads with signals of any kind, WIDTH runs side by side:

    dy/dt = drift(y) + sum_k force_k(y) u_k(t),    u_k linear between instants t_j

by the classical Runge-Kutta method of order 4, in equal steps from each instant to the next: where
a signal has a corner a step ends, and within steps the field is smooth. The error grows by (w h)^4
/120 of the motion at frequency w with each radian of it.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numba import types

from vibrom.kernels.compiled import Blocks, Numbers, Vector, machine_type, passing_kernels
from vibrom.kernels.lanes import WIDTH, get, kernel, part, put, room
from vibrom.solvers.reduced.field import MAP, Kernel
from vibrom.solvers.reduced.records import DIVERGED, OK, Bounds, Solution

NODES, WEIGHTS = (0.0, 0.5, 0.5, 1.0), (1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0)


class Grid(NamedTuple):
    """The instants, and the signals at them."""

    time: Vector  # (m + 1,) s
    steps: Numbers  # (m,) from each instant to the next
    signal: Blocks  # (m + 1, k, WIDTH)


class Room(NamedTuple):
    """Work space."""

    maps: Vector  # of the largest map
    u: Blocks  # (1, k, WIDTH) the signals at an instant
    at: Blocks  # (1, r, WIDTH) where the field is evaluated
    rate: Blocks  # (1, r, WIDTH) dy/dt there
    push: Blocks  # (1, r, WIDTH) force(y)
    next: Blocks  # (1, r, WIDTH) the end of a step


@part
def _rate(drift, forces, numbers, index, work):
    """dy/dt at `at` under the signals u."""
    at, rate, push = work.at[0], work.rate[0], work.push[0]
    drift(at, numbers[0], index[0], work.maps, rate)
    for k in range(len(forces)):
        forces[k](at, numbers[k + 1], index[k + 1], work.maps, push)
        u = get(work.u[0], k, WIDTH)
        for i in range(len(rate)):
            put(rate, i, get(rate, i, WIDTH) + get(push, i, WIDTH) * u)


@part
def _step(drift, forces, numbers, index, work, y, grid, place):
    """From y to the end of a step, number `step` of those that begin at instant j."""
    at, rate, end = work.at[0], work.rate[0], work.next[0]
    j, step = place
    before, after, count = grid.signal[j], grid.signal[j + 1], grid.steps[j]
    h = (grid.time[j + 1] - grid.time[j]) / count
    for i in range(len(y)):
        put(end, i, get(y, i, WIDTH))
    for s in range(4):
        share = (step + NODES[s]) / count
        for k in range(len(forces)):
            rise = get(after, k, WIDTH) - get(before, k, WIDTH)
            put(work.u[0], k, get(before, k, WIDTH) + rise * share)
        for i in range(len(y)):
            ahead = get(rate, i, WIDTH) * (NODES[s] * h) if s else get(y, i, WIDTH) * 0.0
            put(at, i, get(y, i, WIDTH) + ahead)
        _rate(drift, forces, numbers, index, work)
        for i in range(len(y)):
            put(end, i, get(end, i, WIDTH) + get(rate, i, WIDTH) * (WEIGHTS[s] * h))
    for i in range(len(y)):
        put(y, i, get(end, i, WIDTH))


@cache
def compiled(loads: int):
    """The loop for a number of loads: carries y (r, WIDTH) over the grid and fills `path`."""
    arrays = (types.float64[::1], types.int64[::1])
    tables = (types.UniTuple(array, loads + 1) for array in arrays)
    records = (machine_type(item) for item in (Room, Grid, Blocks))

    def run(drift, forces, numbers, index, work, grid, path):
        y = path[0].copy()
        for j in range(len(grid.steps)):
            for step in range(grid.steps[j]):
                _step(drift, forces, numbers, index, work, y, grid, (j, step))
            for i in range(len(y)):
                put(path[j + 1], i, get(y, i, WIDTH))

    signature = types.void(MAP, types.UniTuple(MAP, loads), *tables, *records)
    return kernel(signature, fastmath={"contract"})(run)


def integrate(
    drift: Kernel,
    forces: list[Kernel],
    start: np.ndarray,
    instants: np.ndarray,
    steps: np.ndarray,
    signal: np.ndarray,
    bounds: Bounds,
) -> Solution:
    """From `start` (b, r) at the first of `instants` (m + 1,) [s] on, in so many `steps` (m,) from
    each to the next, sampled at all of them; `signal` (b, k, m + 1). A run that is beyond its limit
    at an instant has diverged there.
    """
    (runs, r), k, maps = start.shape, len(forces), (drift, *forces)
    work = Room(
        np.zeros(WIDTH * max(one.rows for one in maps)),
        *(room(rows, WIDTH).reshape(1, rows, WIDTH) for rows in (k, r, r, r, r)),
    )
    tables = tuple(one.numbers for one in maps), tuple(one.index for one in maps)
    functions = drift.function, tuple(one.function for one in forces)
    path = np.empty((runs, len(instants), r))
    lanes = room(len(instants) * r, WIDTH).reshape(-1, r, WIDTH)
    with passing_kernels():
        loop = compiled(k)
        for first in range(0, runs, WIDTH):
            some = np.minimum(np.arange(first, first + WIDTH), runs - 1)
            lanes[0] = start[some].T
            pushed = np.ascontiguousarray(signal[some].transpose(2, 1, 0))
            loop(*functions, *tables, work, Grid(instants, steps, pushed), lanes)
            live = min(WIDTH, runs - first)
            path[first : first + live] = lanes[:, :, :live].transpose(2, 0, 1)
    return _judged(path, instants, bounds)


def _judged(path: np.ndarray, time: np.ndarray, bounds: Bounds) -> Solution:
    """What became of the runs, whose samples (b, m + 1, r) are NaN from a failure on."""
    size = np.abs(path)
    with np.errstate(invalid="ignore"):
        blown, outside = ~(size <= bounds.limit).all(axis=2), (size > bounds.reach).any(axis=2)
    lost = np.where(blown.any(axis=1), blown.argmax(axis=1), len(time))
    path = np.where(np.arange(len(time))[:, None] < lost[:, None, None], path, np.nan)
    last = np.minimum(lost, len(time) - 1)
    outside &= np.arange(len(time)) < lost[:, None]
    return Solution(
        path,
        np.where(lost < len(time), DIVERGED, OK),
        time[last],
        path[np.arange(len(path)), np.maximum(lost - 1, 0)],
        np.nan_to_num(np.abs(path), nan=0.0).max(axis=1),
        np.where(outside.any(axis=1), time[outside.argmax(axis=1)], np.nan),
        last,
    )
