"""Derivatives carried along a motion of the Newmark integrator, many columns side by side.

With the tangents C_k = C + df/dv and K_k = K + df/dq at step k, a change of the step before, a
change dh of the step length and a change du of the signal follow the linearised step

    dq~ = dq + h dv + h^2 (1/2 - beta) da + dh [v + 2 h ((1/2 - beta) a + beta a_k)]
    dv~ = dv + h (1 - gamma) da + dh [(1 - gamma) a + gamma a_k]
    (M + gamma h C_k + beta h^2 K_k) dq_k
        = M dq~ + C_k (gamma h dq~ - beta h^2 dv~) + beta h^2 p du_k
    da_k = (dq_k - dq~)/(beta h^2),    dv_k = dv~ + gamma h da_k

which is exact: it is the derivative of the steps that were taken, numerical damping included. The
matrix on the left is factorised once a step, WIDE steps side by side, and serves all columns;
columns are carried WIDE at a time, on as many threads as OMP_NUM_THREADS allows.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numba import types

from vibrom.kernels import banded
from vibrom.kernels.lanes import fill, get, kernel, put, room
from vibrom.term import Term

WIDE = 16  # columns, or steps, in flight: two registers hide each other's waiting

_f1, _f2, _f3 = types.float64[::1], types.float64[:, ::1], types.float64[:, :, ::1]
_i2 = types.int64[:, ::1]


@dataclass(frozen=True)
class Steps:
    """The linearised steps of one motion."""

    step: float  # s
    gamma: float
    beta: float
    factors: np.ndarray  # (steps, n, b + 1) L D L' of the matrix on the left, in band form
    mass: tuple[np.ndarray, np.ndarray]  # values and columns (n, k), kg
    damping: tuple[np.ndarray, np.ndarray]  # of C where it is no multiple of M; empty otherwise
    rate: float  # 1/s, c of C = c M
    drag: np.ndarray  # (steps, n, b + 1) band of df/dv, kg/s; empty where no force has one
    by_step: np.ndarray  # (steps, 2, n) what multiplies dh in dq~ [m/s] and dv~ [m/s^2]
    push: np.ndarray  # (steps, n) m kg, beta h^2 p du_k per unit of the signal's amplitude


def linearised(
    term: Term,
    alpha: float,
    step: float,
    signal: np.ndarray,
    displacement: np.ndarray,
    velocity: np.ndarray,
    acceleration: np.ndarray,
) -> Steps:
    """The steps between recorded states (steps + 1, n); `signal` (steps + 1,) of unit amplitude."""
    gamma, beta = 0.5 + alpha, 0.25 * (1.0 + alpha) ** 2
    half = half_bandwidth(term)
    factors, drag = _factors(term, half, gamma * step, beta * step**2, displacement, velocity)
    before, after = acceleration[:-1], acceleration[1:]
    faster = (1.0 - gamma) * before + gamma * after
    ahead = velocity[:-1] + 2.0 * step * ((0.5 - beta) * before + beta * after)
    load = np.zeros(term.size) if term.load is None else term.load
    rate = mass_rate(term)
    return Steps(
        step=step,
        gamma=gamma,
        beta=beta,
        factors=factors,
        mass=tuple(banded.product(term.mass, WIDE)),
        damping=tuple(banded.product(None if rate else term.damping, WIDE)),
        rate=rate,
        drag=drag,
        by_step=np.ascontiguousarray(np.stack([ahead, faster], axis=1)),
        push=beta * step**2 * signal[1:, None] * load,
    )


def half_bandwidth(term: Term) -> int:
    """Of all that is in the tangent."""
    parts = (term.mass, term.damping, term.stiffness)
    half = max(banded.half_bandwidth(part) for part in parts if part is not None)
    for force in term.forces:
        low = np.where(force.dofs < 0, term.size, force.dofs).min(axis=1)
        half = max(half, int((force.dofs.max(axis=1) - low).max()))
    return half


def mass_rate(term: Term) -> float:
    """C [1/s] where C = c M, otherwise zero."""
    if term.damping is None:
        return 0.0
    rate = float(term.damping[0, 0] / term.mass[0, 0])
    rest = abs(term.damping - rate * term.mass).max()
    return rate if rest <= 1e-13 * abs(term.damping).max() else 0.0


def _factors(
    term: Term, half: int, by_v: float, by_q: float, displacement: np.ndarray, velocity: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Factors (steps, n, b + 1) of M + by_v C_k + by_q K_k, and the bands of df/dv."""
    steps, n = len(displacement) - 1, term.size
    _, _, combine, factorise, _ = banded.kernels(WIDE)
    linear = [(term.mass, 1.0), (term.damping, by_v), (term.stiffness, by_q)]
    linear = [(part, scale) for part, scale in linear if part is not None]
    parts = np.stack([banded.to_band(part, half) for part, _ in linear])
    scales = np.stack([np.full(WIDE, scale) for _, scale in linear])
    slots = [banded.band_slots(force.dofs, half, force.symmetric) for force in term.forces]
    band = room(n * (half + 1), WIDE).reshape(n, half + 1, WIDE)
    values = band.reshape(-1, WIDE)
    factors, drag = np.empty((steps, n, half + 1)), np.zeros((steps, n, half + 1))
    for first in range(0, steps, WIDE):
        chosen = np.minimum(np.arange(first, first + WIDE), steps - 1)
        live = min(WIDE, steps - first)
        q, v = (np.ascontiguousarray(part[chosen + 1].T) for part in (displacement, velocity))

        for by, target in (((0.0, 1.0), drag), ((by_q, by_v), factors)):
            if target is drag:
                band[:] = 0.0
            else:
                combine(parts, scales, band)
            both = [np.full(WIDE, scale) for scale in by]
            for force, slot in zip(term.forces, slots):
                force.kernels(WIDE)[1](q, v, force.dofs, force.table, slot, *both, values)
            if target is factors:
                factorise(band)
            target[first : first + live] = band.transpose(2, 0, 1)[:live]
    return factors, drag if drag.any() else np.zeros((0, 0, 0))


def carried(
    steps: Steps, start: np.ndarray, by_step: np.ndarray, by_signal: np.ndarray
) -> np.ndarray:
    """Changes (2, n, c) of displacement and velocity at the end that follow from changes `start`
    (3, n, c) of displacement, velocity and acceleration, dh (c,) [s] and du (c,).
    """
    count, n = start.shape[2], start.shape[1]
    groups = -(-count // WIDE)
    filled = np.zeros((groups * WIDE, 5, n))
    filled[:count, :3] = start.transpose(2, 0, 1)
    lanes = np.ascontiguousarray(filled[:, :3].reshape(groups, WIDE, 3, n).transpose(0, 2, 3, 1))
    given = np.zeros((2, groups * WIDE))
    given[:, :count] = by_step, by_signal
    given = np.ascontiguousarray(given.reshape(2, groups, WIDE).transpose(1, 0, 2))
    h = steps.step
    numbers = np.array([h, steps.gamma, steps.beta, steps.rate])

    def one(group: int) -> None:
        _carry(
            lanes[group],
            numbers,
            steps.factors,
            *steps.mass,
            *steps.damping,
            steps.drag,
            steps.by_step,
            steps.push,
            given[group],
        )

    with ThreadPoolExecutor(threads()) as pool:
        list(pool.map(one, range(groups)))
    ends = lanes[:, :2].transpose(1, 2, 0, 3).reshape(2, n, groups * WIDE)
    return ends[:, :, :count]


def threads() -> int:
    """What OMP_NUM_THREADS says, as for other numerical libraries; without it all cores."""
    return int(os.environ.get("OMP_NUM_THREADS", 0)) or os.cpu_count() or 1


@kernel(
    types.void(_f3, _f1, _f3, _f2, _i2, _f2, _i2, _f3, _f3, _f2, _f2), fastmath=False, nogil=True
)
def _carry(state, numbers, factors, mass, columns, damping, others, drag, by_step, push, given):
    """`state` (3, n, WIDE) from the first step to the last; `given` (2, WIDE): dh and du."""
    h, gamma, beta, rate = numbers[0], numbers[1], numbers[2], numbers[3]
    steps, n, depth = factors.shape
    entries = mass.shape[1]
    q, v, a = state[0], state[1], state[2]
    x, y, dragged = room(n, WIDE), room(n, WIDE), room(n, WIDE)
    by_q, by_v, inverse = beta * h * h, gamma * h, 1.0 / (beta * h * h)
    dh, du = get(given, 0, WIDE), get(given, 1, WIDE)
    changed = np.any(given != 0.0)
    damped = damping.size > 0 or drag.size > 0
    for step in range(steps):
        for i in range(n):
            here, old = get(v, i, WIDE), get(a, i, WIDE)
            ahead = get(q, i, WIDE) + h * (here + h * (0.5 - beta) * old)
            faster = here + h * (1.0 - gamma) * old
            if changed:
                ahead += dh * by_step[step, 0, i]
                faster += dh * by_step[step, 1, i]
            lag = by_v * ahead - by_q * faster
            put(q, i, ahead)
            put(v, i, faster)
            put(x, i, ahead + rate * lag)
            if damped:
                put(dragged, i, lag)
        factor = factors[step].reshape(n * depth)
        for i in range(n):
            total = fill(0.0, WIDE)
            for k in range(entries):
                total += mass[i, k] * get(x, columns[i, k], WIDE)
            if changed:
                total += du * push[step, i]
            if damped:
                for k in range(damping.shape[1]):
                    total += damping[i, k] * get(dragged, others[i, k], WIDE)
                if drag.size > 0:
                    for d in range(min(depth, n - i)):
                        total += drag[step, i, d] * get(dragged, i + d, WIDE)
                    for d in range(1, min(depth, i + 1)):
                        total += drag[step, i - d, d] * get(dragged, i - d, WIDE)
            for d in range(min(depth - 1, i), 0, -1):
                total -= factor[(i - d) * depth + d] * get(y, i - d, WIDE)
            put(y, i, total)
        for i in range(n - 1, -1, -1):
            end = get(y, i, WIDE) * factor[i * depth]
            for d in range(min(depth, n - i) - 1, 0, -1):
                end -= factor[i * depth + d] * get(y, i + d, WIDE)
            put(y, i, end)
            change = inverse * (end - get(q, i, WIDE))
            put(q, i, end)
            put(v, i, get(v, i, WIDE) + by_v * change)
            put(a, i, change)
