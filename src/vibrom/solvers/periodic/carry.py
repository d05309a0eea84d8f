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
columns are carried WIDE at a time, on as many threads as OMP_NUM_THREADS allows, in two passes over
their rows a step: what they read and write takes longer than what they compute. Bodies with a wide
band, and forces whose tangent is not symmetric, are carried by `_carried_sparse`, one step after
the other.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import types
from scipy.sparse.linalg import splu

from vibrom.kernels import banded
from vibrom.kernels.compiled import Blocks, Places, Rows, machine_type
from vibrom.kernels.lanes import get, kernel, part, put, room
from vibrom.solvers.full.batch import mass_damping
from vibrom.solvers.full.newmark import Newmark, half_bandwidth
from vibrom.solvers.full.tangent import Tangent
from vibrom.solvers.threads import mapped
from vibrom.term import Term

WIDE = 16  # columns, or steps, in flight: two registers hide each other's waiting


@dataclass(frozen=True)
class Path:
    """The steps that were taken, as they were recorded."""

    term: Term
    newmark: Newmark
    step: float  # s
    signal: np.ndarray  # (steps + 1,) of unit amplitude
    weight: np.ndarray  # (steps + 1,) of each step in the sum of p'q that is asked for
    displacement: np.ndarray  # (steps + 1, n) m
    velocity: np.ndarray  # (steps + 1, n) m/s
    acceleration: np.ndarray  # (steps + 1, n) m/s^2

    @property
    def gamma(self) -> float:
        """Newmark's."""
        return 0.5 + self.newmark.alpha

    @property
    def beta(self) -> float:
        """Newmark's."""
        return 0.25 * (1.0 + self.newmark.alpha) ** 2

    @property
    def by_step(self) -> np.ndarray:
        """(steps, 2, n) what multiplies dh in dq~ [m/s] and dv~ [m/s^2]."""
        before, after = self.acceleration[:-1], self.acceleration[1:]
        faster = (1.0 - self.gamma) * before + self.gamma * after
        bend = (0.5 - self.beta) * before + self.beta * after
        return np.stack([self.velocity[:-1] + 2.0 * self.step * bend, faster], axis=1)

    @property
    def load(self) -> np.ndarray:
        """p (n,) [N]."""
        return np.zeros(self.term.size) if self.term.load is None else self.term.load

    @property
    def push(self) -> np.ndarray:
        """(steps, n) beta h^2 p du_k per unit of the signal's amplitude [m kg]."""
        return self.beta * self.step**2 * self.signal[1:, None] * self.load

    @property
    def watch(self) -> np.ndarray:
        """(steps, n) of q_k in the sum [N]."""
        return self.weight[1:, None] * self.load


def carried(
    path: Path, start: np.ndarray, by_step: np.ndarray, by_signal: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Changes (2, n, c) of displacement and velocity at the end, and (c,) of the sum of the path's
    weights times p'q, that follow from changes `start` (3, n, c) of displacement, velocity and
    acceleration, dh (c,) [s] and du (c,).
    """
    half, term = half_bandwidth(path.term), path.term
    if path.newmark.is_wide(term, half) or not all(force.symmetric for force in term.forces):
        return _carried_sparse(path, start, by_step, by_signal)
    return _carried_banded(path, half, start, by_step, by_signal)


def _carried_sparse(
    path: Path, start: np.ndarray, by_step: np.ndarray, by_signal: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """By a general sparse factorisation of each step."""
    h, by_v, by_q = path.step, path.gamma * path.step, path.beta * path.step**2
    whole, drag = Tangent(path.term, 1.0, by_v, by_q), Tangent(path.term, 0.0, 1.0, 0.0)
    q, v, a = start
    seen = np.zeros(q.shape[1])
    for k, (faster, push, watch) in enumerate(zip(path.by_step, path.push, path.watch)):
        at = path.displacement[k + 1][:, None], path.velocity[k + 1][:, None]
        q = q + h * v + h**2 * (0.5 - path.beta) * a + np.outer(faster[0], by_step)
        v = v + h * (1.0 - path.gamma) * a + np.outer(faster[1], by_step)
        right = path.term.mass @ q + drag.at(*at) @ (by_v * q - by_q * v)
        end = splu(whole.at(*at)).solve(right + np.outer(push, by_signal))
        a = (end - q) / by_q
        q, v = end, v + by_v * a
        seen += watch @ q
    return np.stack([q, v]), seen


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
    forces = list(zip(term.forces, slots))
    dragging = [each for each in forces if not each[0].conservative]  # a potential has no df/dv
    band = room(n * (half + 1), WIDE).reshape(n, half + 1, WIDE)
    values = band.reshape(-1, WIDE)

    def add(some, q, v, by_displacement: float, by_speed: float) -> None:
        both = np.full(WIDE, by_displacement), np.full(WIDE, by_speed)
        for force, slot in some:
            force.kernels(WIDE)[1](q, v, force.dofs, force.table, slot, *both, values)

    factors = np.empty((steps, n, half + 1))
    drag = np.zeros((steps, n, half + 1) if dragging else (0, 0, 0))
    for first in range(0, steps, WIDE):
        chosen = np.minimum(np.arange(first, first + WIDE), steps - 1)
        live = slice(first, first + WIDE), slice(min(WIDE, steps - first))
        q, v = (np.ascontiguousarray(part[chosen + 1].T) for part in (displacement, velocity))
        if dragging:
            band[:] = 0.0
            add(dragging, q, v, 0.0, 1.0)
            drag[live[0]] = band.transpose(2, 0, 1)[live[1]]
        combine(parts, scales, band)
        add(forces, q, v, by_q, by_v)
        factorise(band)
        factors[live[0]] = band.transpose(2, 0, 1)[live[1]]
    return factors, drag if drag.any() else np.zeros((0, 0, 0))


def _carried_banded(
    path: Path, half: int, start: np.ndarray, by_step: np.ndarray, by_signal: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """By the compiled kernels, all columns side by side."""
    term, h = path.term, path.step
    factors, drag = _factors(
        term, half, path.gamma * h, path.beta * h**2, path.displacement, path.velocity
    )
    rate = mass_damping(term)
    mass = banded.product(term.mass, WIDE)
    damping = banded.product(None if rate else term.damping, WIDE)
    method = Method(h, path.gamma, path.beta, rate)
    sources = np.ascontiguousarray(path.by_step), path.push, path.watch
    tables = Tables(factors, *mass, *damping, drag, *sources)

    count, n = start.shape[2], start.shape[1]
    groups = -(-count // WIDE)
    filled = np.zeros((groups * WIDE, 3, n))
    filled[:count] = start.transpose(2, 0, 1)
    lanes = room(groups * 3 * n, WIDE).reshape(groups, 3, n, WIDE)
    lanes[:] = filled.reshape(groups, WIDE, 3, n).transpose(0, 2, 3, 1)
    given = np.zeros((groups, 3, WIDE))
    for row, values in enumerate((by_step, by_signal)):
        given[:, row] = np.append(values, np.zeros(groups * WIDE - count)).reshape(groups, WIDE)

    def one(group: int) -> None:
        _carry(lanes[group], given[group], tables, method)

    mapped(one, range(groups))
    ends = lanes[:, :2].transpose(1, 2, 0, 3).reshape(2, n, groups * WIDE)[:, :, :count]
    return ends, given[:, 2].reshape(-1)[:count]


class Method(NamedTuple):
    """Newmark's numbers, and the damping that is a multiple of the mass."""

    h: float  # s
    gamma: float
    beta: float
    rate: float  # 1/s, c of C = c M; zero for another C


class Tables(NamedTuple):
    """The linearised steps in compiled form."""

    factors: Blocks  # (steps, n, b + 1) L D L' of the matrices on the left
    mass: Rows  # (n, k) kg, row by row
    columns: Places  # (n, k) where they stand
    damping: Rows  # (n, l) kg/s, of C where it is no multiple of M; empty otherwise
    others: Places  # (n, l) where they stand
    drag: Blocks  # (steps, n, b + 1) kg/s, bands of df/dv; empty where no force has one
    by_step: Blocks  # (steps, 2, n) see Path
    push: Rows  # (steps, n) see Path
    watch: Rows  # (steps, n) see Path


@part
def _ahead(state, right, place, now, given, tables, method):
    """dq~ and dv~ of row i in a step, from dq, dv and da before it, and what multiplies M and C on
    the right side.
    """
    (step, i), (here, faster, old) = place, now
    h, gamma, beta = method.h, method.gamma, method.beta
    dh = get(given, 0, WIDE)
    ahead = here + h * (faster + h * (0.5 - beta) * old) + dh * tables.by_step[step, 0, i]
    later = faster + h * (1.0 - gamma) * old + dh * tables.by_step[step, 1, i]
    lag = gamma * h * ahead - beta * h * h * later
    put(state[0], i, ahead)
    put(state[1], i, later)
    put(right[0], i, ahead + method.rate * lag)
    if tables.damping.size > 0 or tables.drag.size > 0:
        put(right[1], i, lag)


@part
def _substituted(y, right, given, tables, step):
    """The right side, and forward substitution row by row."""
    n, depth = y.shape[0], tables.factors.shape[2]
    factor = tables.factors[step].reshape(n * depth)
    x, dragged, du = right[0], right[1], get(given, 1, WIDE)
    for i in range(n):
        total = du * tables.push[step, i]
        for k in range(tables.mass.shape[1]):
            total += tables.mass[i, k] * get(x, tables.columns[i, k], WIDE)
        for k in range(tables.damping.shape[1]):
            total += tables.damping[i, k] * get(dragged, tables.others[i, k], WIDE)
        if tables.drag.size > 0:
            for d in range(min(depth, n - i)):
                total += tables.drag[step, i, d] * get(dragged, i + d, WIDE)
            for d in range(1, min(depth, i + 1)):
                total += tables.drag[step, i - d, d] * get(dragged, i - d, WIDE)
        for d in range(min(depth - 1, i), 0, -1):
            total -= factor[(i - d) * depth + d] * get(y, i - d, WIDE)
        put(y, i, total)


@part
def _finished(state, right, given, tables, method, step):
    """Back substitution, what is seen of the end of the step, and, while its rows are at hand, the
    beginning of the next one.
    """
    q, v, y = state[0], state[1], state[2]
    (steps, n, depth), seen = tables.factors.shape, get(given, 2, WIDE)
    factor = tables.factors[step].reshape(n * depth)
    by_v, inverse = method.gamma * method.h, 1.0 / (method.beta * method.h * method.h)
    for i in range(n - 1, -1, -1):
        end = get(y, i, WIDE) * factor[i * depth]
        for d in range(min(depth, n - i) - 1, 0, -1):
            end -= factor[i * depth + d] * get(y, i + d, WIDE)
        put(y, i, end)
        seen += tables.watch[step, i] * end
        change = inverse * (end - get(q, i, WIDE))
        faster = get(v, i, WIDE) + by_v * change
        if step + 1 < steps:
            now = (end, faster, change)
            _ahead(state, right, (step + 1, i), now, given, tables, method)
        else:
            put(q, i, end)
            put(v, i, faster)
    put(given, 2, seen)


_SIGNATURE = types.void(*map(machine_type, (Blocks, Rows, Tables, Method)))


@kernel(_SIGNATURE, fastmath={"contract"}, nogil=True)
def _carry(state, given, tables, method):
    """Carries `state` (3, n, WIDE) over all steps; `given` (3, WIDE) holds dh, du and the sum."""
    n = state.shape[1]
    right = room(2 * n, WIDE).reshape(2, n, WIDE)
    for i in range(n):
        now = (get(state[0], i, WIDE), get(state[1], i, WIDE), get(state[2], i, WIDE))
        _ahead(state, right, (0, i), now, given, tables, method)
    for step in range(tables.factors.shape[0]):
        _substituted(state[2], right, given, tables, step)
        _finished(state, right, given, tables, method, step)
