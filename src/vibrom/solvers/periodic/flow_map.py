"""The flow of a reduced model over a period as a map, with its derivative.

    dz/dt = drift(z) + force(z) a sin(Omega t),    x = z/Z,    x -> H(x, Omega, a): x after a period

Z is the training range. Runge-Kutta steps of order 8 (Dormand and Prince's, as in Hairer, Norsett,
Wanner, Solving Ordinary Differential Equations I, II.5), all of one length, so that the map is
smooth: its derivative is taken by central differences of the map itself, the neighbours side by
side with the point in the lanes of one run, so that one position and its velocity cost no more than
the value (1e-9 of the derivative is lost). A period takes a power of two of steps, more where the
embedded estimate of order 5 asks for it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numba import types
from scipy.integrate import DOP853

from vibrom.kernels.compiled import Blocks, Numbers, Vector, machine_type, passing_kernels
from vibrom.kernels.lanes import WIDTH, fill, get, kernel, part, put, room
from vibrom.solvers.periodic.maps import Return, Swing
from vibrom.solvers.reduced.field import MAP, VectorField

NUDGE = 1e-5  # of the range, of the frequency and of the amplitude
TOLERANCE = 1e-7  # of the range, estimated error of a step; what is lost in a period is less
SMALL = 1e-4  # of it: half as many steps would do
LOOSE = 1e-3  # with all the steps there are: a worse motion is lost
FEWEST, MOST = 16, 256  # steps to a period
KEPT, SHOWN = 128, 512  # samples of a period that are evaluated, and those that are shown
STAGES = DOP853.n_stages
_A, _B, _C = (np.ascontiguousarray(part[..., :STAGES]) for part in (DOP853.A, DOP853.B, DOP853.C))
_E3, _E5 = (np.ascontiguousarray(part[:STAGES]) for part in (DOP853.E3, DOP853.E5))
_LIMIT = 4.0  # of the range: a motion that ends a step beyond it is lost


@dataclass
class _Steps:
    """How many a period takes; the one thing that a map remembers."""

    number: int = FEWEST


@dataclass(frozen=True)
class FlowMap:
    """Motion of a reduced model over a period."""

    field: VectorField | None  # compiled; None: from the two functions below
    drift: Callable[[np.ndarray], np.ndarray]  # dz/dt (b, r) of z (b, r)
    force: Callable[[np.ndarray], np.ndarray]  # what a unit of the signal adds to it
    encode: Callable[[np.ndarray], np.ndarray]  # z (b, r) of states (b, 2n)
    decode: Callable[[np.ndarray], np.ndarray]  # states (b, 2n) of z (b, r)
    displacement: Callable[[np.ndarray], np.ndarray]  # (b, k) m at the probes
    # (2, b, k) m that a unit of the signal, and of it a quarter of a period earlier, adds there
    # beside the manifold; None where nothing is known of it
    beside: Callable[[np.ndarray], np.ndarray | None]
    reach: np.ndarray  # (r,) Z
    frequency: float  # rad/s, a scale
    steps: _Steps = field(default_factory=_Steps)
    parts: int = 1
    free: bool = True  # the derivative costs no more than the value

    @property
    def size(self) -> int:
        """Of x."""
        return len(self.reach)

    def of_state(self, state: np.ndarray) -> np.ndarray:
        """The point x (r,) of a state (2n,)."""
        return self.encode(state[None])[0] / self.reach

    def state(self, x: np.ndarray) -> np.ndarray:
        """The state (2n,) of a point (r,)."""
        return self.decode((x * self.reach)[None])[0]

    def __call__(
        self, x: np.ndarray, frequency: float, amplitude: float, derivative: bool = True
    ) -> Return:
        """Where x (r,) is after a period."""
        point = np.array([*x, frequency, amplitude], dtype=float)
        if not derivative:
            end = self._periods(point[None])[0][0]
            return Return(end, ok=bool(np.isfinite(end).all()))
        r = len(x)
        nudges = NUDGE * np.array([*np.ones(r), frequency, amplitude or 1.0])
        end = self._periods(point + self._neighbours * nudges)[0]
        if not np.isfinite(end).all():
            return Return(end[0], ok=False)
        slopes = ((end[1 : r + 3] - end[r + 3 :]) / (2.0 * nudges[:, None])).T
        return Return(end[0], True, False, slopes[:, :r], slopes[:, r], slopes[:, r + 1])

    @cached_property
    def _neighbours(self) -> np.ndarray:
        """(2 r + 5, r + 2) the point itself, then those ahead of it, then those behind."""
        axes = np.eye(self.size + 2)
        return np.concatenate([0.0 * axes[:1], axes, -axes])

    def swings(self, x: np.ndarray, frequency: np.ndarray, amplitude: np.ndarray) -> list[Swing]:
        """The motions over a period from x (b, r), interpolated by their harmonics."""
        _, path = self._periods(np.column_stack([x, frequency, amplitude]), KEPT)
        ratio = np.abs(path).max(axis=(1, 2))
        z = (path * self.reach).reshape(-1, self.size)
        shown, added = self.displacement(z), self.beside(z)
        if added is not None:
            angle = 2.0 * np.pi * np.arange(KEPT) / KEPT
            waves = np.stack([np.sin(angle), np.cos(angle)])[:, None] * amplitude[:, None]
            shown = shown + np.einsum("wb,wbk->bk", waves.reshape(2, -1), added)
        shown = shown.reshape(len(x), KEPT, -1).transpose(0, 2, 1)
        finite = np.isfinite(shown).all(axis=(1, 2))
        fine = np.full((*shown.shape[:2], SHOWN), np.nan)
        fine[finite] = np.fft.irfft(np.fft.rfft(shown[finite]), SHOWN) * (SHOWN / KEPT)
        return [Swing(*both) for both in zip(fine, ratio.tolist())]

    def after(self, x: np.ndarray, frequency: float, amplitude: float, periods: int) -> np.ndarray:
        """Where x (r,) is after so many periods; NaN where the motion does not last."""
        for _ in range(periods):
            if np.isfinite(x).all():
                x = self(x, frequency, amplitude, derivative=False).end
        return x

    def _periods(self, points: np.ndarray, kept: int = 1) -> tuple[np.ndarray, np.ndarray]:
        """(ends (b, r), samples (b, kept, r) from the start on), in units of the range, of points
        (b, r + 2): x, frequency and amplitude.
        """
        number = max(self.steps.number, kept)
        run = _numpy_run if self.field is None else _compiled_run
        end, path, error = run(self, points, number, kept)
        while not error < TOLERANCE and number < MOST:
            number *= 2
            end, path, error = run(self, points, number, kept)
        if not error < LOOSE:
            return np.full_like(end, np.nan), path
        if kept == 1:
            self.steps.number = max(number // 2 if error < SMALL * TOLERANCE else number, FEWEST)
        return end, path


def _compiled_run(
    flow: FlowMap, points: np.ndarray, number: int, kept: int
) -> tuple[np.ndarray, np.ndarray, float]:
    """(ends, samples, largest error of a step)."""
    runs, r = len(points), flow.size
    groups = -(-runs // WIDTH)
    filled = points[np.minimum(np.arange(groups * WIDTH), runs - 1)]
    filled[:, :r] *= flow.reach
    lanes = np.ascontiguousarray(filled.reshape(groups, WIDTH, r + 2).transpose(0, 2, 1))
    path = np.empty((groups * kept, r, WIDTH))
    drift, force = flow.field.drift, flow.field.force
    work = np.empty(WIDTH * max(drift.rows, force.rows))
    tables = Tables(drift.numbers, drift.index, force.numbers, force.index, work)
    worst = _flow(drift.function, force.function, tables, flow.reach, number, lanes, path)
    # (groups, ..., r, WIDTH) -> (runs, ..., r)
    ends = lanes[:, :r].transpose(0, 2, 1).reshape(-1, r)[:runs] / flow.reach
    samples = path.reshape(groups, kept, r, WIDTH).transpose(0, 3, 1, 2)
    return ends, samples.reshape(-1, kept, r)[:runs] / flow.reach, worst


def _numpy_run(
    flow: FlowMap, points: np.ndarray, number: int, kept: int
) -> tuple[np.ndarray, np.ndarray, float]:
    """The same from numpy functions."""
    r = flow.size
    frequency, amplitude = points[:, r], points[:, r + 1]
    z, h = points[:, :r] * flow.reach, (2.0 * np.pi / frequency / number)[:, None]
    path, worst = np.empty((len(z), kept, r)), 0.0
    slopes = np.empty((STAGES, *z.shape))
    with np.errstate(all="ignore"):  # a model that blows up is a result, not a warning
        for step in range(number):
            if step % (number // kept) == 0:
                path[:, step // (number // kept)] = z / flow.reach
            for s in range(STAGES):
                y = z + h * np.tensordot(_A[s, :s], slopes[:s], 1)
                signal = amplitude * np.sin(2.0 * np.pi * (step + _C[s]) / number)
                slopes[s] = flow.drift(y) + flow.force(y) * signal[:, None]
            z = z + h * np.tensordot(_B, slopes, 1)
            five, three = ((h * np.tensordot(e, slopes, 1) / flow.reach) ** 2 for e in (_E5, _E3))
            error = np.where(five == 0.0, 0.0, five / np.sqrt(five + 0.01 * three))
            worst = max(worst, float(np.nan_to_num(error, nan=np.inf).max()))
            if kept == 1 and not np.abs(z / flow.reach).max() < _LIMIT:
                return z, path, np.inf
    return z / flow.reach, path, worst


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
def _period(drift, force, tables, reach, number, lanes, path, scratch):
    """One group; `scratch` ((STAGES + 2) r + 2, WIDTH)."""
    r, kept, worst = len(reach), len(path), 0.0
    z, drive = lanes[:r], lanes[r:]
    h, signal, y, push = scratch[:1], scratch[1:2], scratch[2 : 2 + r], scratch[2 + r : 2 + 2 * r]
    slopes = scratch[2 + 2 * r :]
    for w in range(WIDTH):
        h[0, w] = 2.0 * np.pi / drive[0, w] / number
    length = get(h, 0, WIDTH)
    for step in range(number):
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
            wave = np.sin(2.0 * np.pi * (step + _C[s]) / number)
            for w in range(WIDTH):
                signal[0, w] = drive[1, w] * wave
            for i in range(r):
                put(out, i, get(out, i, WIDTH) + get(signal, 0, WIDTH) * get(push, i, WIDTH))
        for i in range(r):
            put(z, i, get(z, i, WIDTH) + length * _weighted(slopes, _B, i, r, STAGES))
            put(y, i, length * _weighted(slopes, _E5, i, r, STAGES))
            put(push, i, length * _weighted(slopes, _E3, i, r, STAGES))
        worst = _worst(y, push, reach, worst)
        for i in range(r):
            for w in range(WIDTH):
                if kept == 1 and not abs(z[i, w]) < _LIMIT * reach[i]:
                    return np.inf
    return worst


def _loop(drift, force, tables, reach, number, lanes, path):
    """Carries z of each group of `lanes` (groups, r + 2, WIDTH), below which stand frequency and
    amplitude, over a period, and fills `path` (groups * kept, r, WIDTH). The largest error of a
    step, of the range.
    """
    worst, kept = 0.0, len(path) // len(lanes)
    scratch = room((STAGES + 2) * len(reach) + 2, WIDTH)
    for group in range(len(lanes)):
        samples = path[group * kept : (group + 1) * kept]
        error = _period(drift, force, tables, reach, number, lanes[group], samples, scratch)
        worst = error if not error <= worst else worst
    return worst


with passing_kernels():
    _records = (machine_type(item) for item in (Tables, Vector, int, Blocks, Blocks))
    _flow = kernel(types.float64(MAP, MAP, *_records), fastmath={"contract"})(_loop)
