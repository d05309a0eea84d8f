"""The Runge-Kutta steps of `flow_map`, of order 8, for many points side by side: in compiled code,
or from numpy functions.

    k_s = f(z + h sum_j a_sj k_j, t + c_s h),    z <- z + h sum_s b_s k_s

The error of a step is estimated from the embedded formulas of order 5 and 3, as in DOP853.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numba import types

from vibrom.kernels.callback import address_of, kernel_at
from vibrom.kernels.compiled import Blocks, Numbers, Rows, Vector, machine_type, passing_kernels
from vibrom.kernels.lanes import WIDTH, fill, get, kernel, part, put, room
from vibrom.solvers.reduced import order_8
from vibrom.solvers.reduced.field import KERNEL, MAP, VectorField

Function = Callable[[np.ndarray], np.ndarray]  # (b, r) of z (b, r)
# Ends (b, r), samples (b, kept, r) and the largest error of a step, in units of the range, of
# points (b, r + 2), x, frequency and amplitude, in these steps, of whose beginnings so many are
# kept. They go over a period, or one of its equal `parts`. Where points are neighbours of one
# motion, it is lost with the first that leaves the range: an infinite error.
Run = Callable[[np.ndarray, "Grid", int, bool], tuple[np.ndarray, np.ndarray, float]]

STAGES = order_8.STAGES
_A, _B = np.ascontiguousarray(order_8.A[:STAGES, :STAGES]), order_8.A[STAGES, :STAGES].copy()
_C, _E3, _E5 = (part[:STAGES].copy() for part in (order_8.C, order_8.E3, order_8.E5))
_LIMIT = 4.0  # of the range: a motion that ends a step beyond it is lost


class Grid(NamedTuple):
    """Steps over a period, or over one of its parts."""

    at: Vector  # (n + 1,) where they begin, from zero to one
    lengths: Vector  # (n,)
    waves: Rows  # (n, STAGES) the signal at their stages


@lru_cache(maxsize=64)
def even(number: int, parts: int) -> Grid:
    """All of one length."""
    return uneven(np.arange(number + 1) / number, parts)


def uneven(at: np.ndarray, parts: int) -> Grid:
    """That begin at (n + 1,)."""
    lengths = np.diff(at)
    angle = 2.0 * np.pi / parts * (at[:-1, None] + lengths[:, None] * _C)
    return Grid(at, lengths, np.sin(angle))


def compiled(field: VectorField, reach: np.ndarray, parts: int = 1) -> Run:
    """Of a compiled field; what does not change from one run to the next is made once."""
    r, maps = len(reach), (field.drift, field.force)
    addresses = [address_of(each.function, KERNEL) for each in maps]
    work = np.empty(WIDTH * max(each.rows for each in maps))
    bounds = [np.stack([reach, limit * reach]) for limit in (np.nan, _LIMIT)]
    tables = Tables(*(table for each in maps for table in (each.numbers, each.index)), work)

    def run(
        points: np.ndarray, grid: Grid, kept: int, near: bool
    ) -> tuple[np.ndarray, np.ndarray, float]:
        runs = len(points)
        groups = -(-runs // WIDTH)
        filled = np.empty((groups * WIDTH, r + 2))
        filled[:runs], filled[runs:] = points, points[-1]
        filled[:, :r] *= reach
        filled[:, r] *= parts  # as one of them takes so much less time
        lanes = np.ascontiguousarray(filled.reshape(groups, WIDTH, r + 2).transpose(0, 2, 1))
        path = np.empty((groups * kept, r, WIDTH))
        worst = _flow(*addresses, tables, bounds[int(near)], grid, lanes, path)
        # (groups, ..., r, WIDTH) -> (runs, ..., r)
        ends = lanes[:, :r].transpose(0, 2, 1).reshape(-1, r)[:runs] / reach
        if kept == 1:
            return ends, points[:, None, :r], worst
        samples = path.reshape(groups, kept, r, WIDTH).transpose(0, 3, 1, 2)
        return ends, samples.reshape(-1, kept, r)[:runs] / reach, worst

    return run


def plain(drift: Function, force: Function, reach: np.ndarray, parts: int = 1) -> Run:
    """Of numpy functions."""

    def run(
        points: np.ndarray, grid: Grid, kept: int, near: bool
    ) -> tuple[np.ndarray, np.ndarray, float]:
        r, number = len(reach), len(grid.lengths)
        frequency, amplitude = points[:, r], points[:, r + 1]
        z, whole = points[:, :r] * reach, (2.0 * np.pi / frequency / parts)[:, None]
        path, worst = np.empty((len(z), kept, r)), 0.0
        slopes = np.empty((STAGES, *z.shape))
        for step in range(number):
            if step % (number // kept) == 0:
                path[:, step // (number // kept)] = z / reach
            h = whole * grid.lengths[step]
            for s in range(STAGES):
                y = z + h * np.tensordot(_A[s, :s], slopes[:s], 1)
                signal = amplitude * grid.waves[step, s]
                slopes[s] = drift(y) + force(y) * signal[:, None]
            z = z + h * np.tensordot(_B, slopes, 1)
            five, three = ((h * np.tensordot(e, slopes, 1) / reach) ** 2 for e in (_E5, _E3))
            error = np.where(five == 0.0, 0.0, five / np.sqrt(five + 0.01 * three))
            worst = max(worst, float(np.nan_to_num(error, nan=np.inf).max()))
            if near and not np.abs(z / reach).max() < _LIMIT:
                return z, path, np.inf
        return z / reach, path, worst

    # A model that blows up is a result, not a warning.
    return np.errstate(all="ignore")(run)


class Tables(NamedTuple):
    """What the two compiled maps take beside the state."""

    drift_numbers: Vector
    drift_index: Numbers
    force_numbers: Vector
    force_index: Numbers
    work: Vector  # scratch of the larger one


@part
def _weighted(slopes, weights, i, r, count):
    """sum_s weights_s k_s of coordinate i over the first stages."""
    total = fill(0.0, WIDTH)
    for s in range(count):
        if weights[s] != 0.0:
            total += get(slopes, s * r + i, WIDTH) * weights[s]
    return total


@part
def _worst(five, three, reach, worst):
    """The largest of `worst` and the estimated errors, of the range; NaN is larger than all."""
    for i in range(len(reach)):
        for w in range(WIDTH):
            one, other = (five[i, w] / reach[i]) ** 2, (three[i, w] / reach[i]) ** 2
            error = one / np.sqrt(one + 0.01 * other) if one > 0.0 else one
            if not error <= worst:
                worst = error
    return worst


@part
def _period(drift, force, tables, bounds, grid, lanes, path, scratch):
    """One group; `scratch` ((STAGES + 2) r + 1, WIDTH)."""
    r, kept, number, worst = len(lanes) - 2, len(path), len(grid.lengths), 0.0
    z, drive = lanes[:r], lanes[r:]
    h, y, push = scratch[:1], scratch[1 : 1 + r], scratch[1 + r : 1 + 2 * r]
    slopes = scratch[1 + 2 * r :]
    for w in range(WIDTH):
        h[0, w] = 2.0 * np.pi / drive[0, w]
    for step in range(number):
        length = get(h, 0, WIDTH) * grid.lengths[step]
        if step % (number // kept) == 0:
            shown = path[step // (number // kept)]
            for i in range(r):
                put(shown, i, get(z, i, WIDTH))
        for s in range(STAGES):
            for i in range(r):
                put(y, i, get(z, i, WIDTH) + length * _weighted(slopes, _A[s], i, r, s))
            out = slopes[s * r : (s + 1) * r]
            drift(y, tables.drift_numbers, tables.drift_index, tables.work, out)
            force(y, tables.force_numbers, tables.force_index, tables.work, push)
            signal = get(drive, 1, WIDTH) * grid.waves[step, s]
            for i in range(r):
                put(out, i, get(out, i, WIDTH) + signal * get(push, i, WIDTH))
        for i in range(r):
            put(z, i, get(z, i, WIDTH) + length * _weighted(slopes, _B, i, r, STAGES))
            put(y, i, length * _weighted(slopes, _E5, i, r, STAGES))
            put(push, i, length * _weighted(slopes, _E3, i, r, STAGES))
        worst = _worst(y, push, bounds[0], worst)
        for i in range(r):
            for w in range(WIDTH):
                if abs(z[i, w]) >= bounds[1, i]:
                    return np.inf
    return worst


def _loop(drift_at, force_at, tables, bounds, grid, lanes, path):
    """Carries z of each group of `lanes` (groups, r + 2, WIDTH), below which stand frequency and
    amplitude, over a period, and fills `path` (groups * kept, r, WIDTH); see `Grid`. `bounds`
    (2, r) are the range and where a motion is lost; NaN: nowhere. The largest error of a step, of
    the range.
    """
    drift, force = _map(drift_at), _map(force_at)
    worst, kept = 0.0, len(path) // len(lanes)
    scratch = room((STAGES + 2) * bounds.shape[1] + 1, WIDTH)
    for group in range(len(lanes)):
        samples = path[group * kept : (group + 1) * kept]
        error = _period(drift, force, tables, bounds, grid, lanes[group], samples, scratch)
        worst = error if not error <= worst else worst
    return worst


_map = kernel_at(MAP)
with passing_kernels():
    _kinds = (int, int, Tables, Rows, Grid, Blocks, Blocks)
    _records = (machine_type(item) for item in _kinds)
    _flow = kernel(types.float64(*_records), fastmath={"contract"})(_loop)
