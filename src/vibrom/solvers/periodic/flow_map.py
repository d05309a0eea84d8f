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

import warnings
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numba import types
from numba.core.errors import NumbaExperimentalFeatureWarning
from scipy.integrate import DOP853

from vibrom.kernels.lanes import WIDTH, fill, get, kernel, put, room
from vibrom.solvers.periodic.maps import Return, Swing
from vibrom.solvers.reduced.field import KERNEL, Field

NUDGE = 1e-5  # of the range, of the frequency and of the amplitude
TOLERANCE = 1e-9  # of the range, error of a step
SMALL = 1e-4  # of it: half as many steps would do
FEWEST, MOST = 16, 4096  # steps to a period
KEPT, SHOWN = 128, 512  # samples of a period that are evaluated, and those that are shown
STAGES = DOP853.n_stages
_A, _B, _C = (np.ascontiguousarray(part[..., :STAGES]) for part in (DOP853.A, DOP853.B, DOP853.C))
_E3, _E5 = (np.ascontiguousarray(part[:STAGES]) for part in (DOP853.E3, DOP853.E5))
_LIMIT = 100.0  # of the range: beyond it a motion is lost

_f1, _f2, _f3 = types.float64[::1], types.float64[:, ::1], types.float64[:, :, ::1]
_MAP = (types.FunctionType(KERNEL), _f1, types.int64[::1])


@dataclass
class _Steps:
    """How many a period takes; the one thing that a map remembers."""

    number: int = 2 * FEWEST


@dataclass(frozen=True)
class FlowMap:
    """Motion of a reduced model over a period."""

    field: Field | None  # compiled; None: from the two functions below
    drift: Callable[[np.ndarray], np.ndarray]  # dz/dt (b, r) of z (b, r)
    force: Callable[[np.ndarray], np.ndarray]  # what a unit of the signal adds to it
    encode: Callable[[np.ndarray], np.ndarray]  # z (b, r) of states (b, 2n)
    decode: Callable[[np.ndarray], np.ndarray]  # states (b, 2n) of z (b, r)
    displacement: Callable[[np.ndarray], np.ndarray]  # (b, k) m at the probes
    reach: np.ndarray  # (r,) Z
    frequency: float  # rad/s, a scale
    steps: _Steps = field(default_factory=_Steps)
    parts: int = 1
    free: bool = True  # the derivative costs no more than the value

    @property
    def size(self) -> int:
        """r."""
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
        r = len(x)
        columns = 1 + (2 * (r + 2) if derivative else 0)
        start = np.tile(x, (columns, 1))
        drive = np.tile([float(frequency), float(amplitude)], (columns, 1))
        nudges = np.append(np.full(r, NUDGE), NUDGE * np.array([frequency, amplitude]))
        for axis in range(r + 2 if derivative else 0):
            target, place = (start, axis) if axis < r else (drive, axis - r)
            target[1 + 2 * axis, place] += nudges[axis]
            target[2 + 2 * axis, place] -= nudges[axis]
        end = self._periods(start, *drive.T)[0]
        if not np.isfinite(end).all():
            return Return(end[0], ok=False)
        if not derivative:
            return Return(end[0], ok=True)
        slopes = ((end[1::2] - end[2::2]) / (2.0 * nudges[:, None])).T
        return Return(end[0], True, False, slopes[:, :r], slopes[:, r], slopes[:, r + 1])

    def swings(self, x: np.ndarray, frequency: np.ndarray, amplitude: np.ndarray) -> list[Swing]:
        """The motions over a period from x (b, r), interpolated by their harmonics."""
        _, path = self._periods(x, frequency, amplitude, KEPT)
        ratio = np.abs(path).max(axis=(1, 2))
        shown = self.displacement((path * self.reach).reshape(-1, self.size))
        shown = shown.reshape(len(x), KEPT, -1).transpose(0, 2, 1)
        finite = np.isfinite(shown).all(axis=(1, 2))
        fine = np.full((*shown.shape[:2], SHOWN), np.nan)
        fine[finite] = np.fft.irfft(np.fft.rfft(shown[finite]), SHOWN) * (SHOWN / KEPT)
        return [Swing(*both) for both in zip(fine, ratio.tolist())]

    def after(self, x: np.ndarray, frequency: float, amplitude: float, periods: int) -> np.ndarray:
        """Where x (r,) is after so many periods."""
        drive, x = (np.array([float(frequency)]), np.array([float(amplitude)])), x[None]
        for _ in range(periods):
            x = self._periods(x, *drive)[0]
        return x[0]

    def _periods(
        self, x: np.ndarray, frequency: np.ndarray, amplitude: np.ndarray, kept: int = 1
    ) -> tuple[np.ndarray, np.ndarray]:
        """(ends (b, r), samples (b, kept, r) from the start on), in units of the range."""
        number = max(self.steps.number, kept)
        run = _numpy_run if self.field is None else _compiled_run
        end, path, error = run(self, x, frequency, amplitude, number, kept)
        while not error < TOLERANCE and number < MOST:
            number *= 2
            end, path, error = run(self, x, frequency, amplitude, number, kept)
        if not np.isfinite(error):
            return np.full_like(end, np.nan), path
        if kept == 1:
            self.steps.number = max(number // 2 if error < SMALL * TOLERANCE else number, FEWEST)
        return end, path


def _compiled_run(
    flow: FlowMap,
    x: np.ndarray,
    frequency: np.ndarray,
    amplitude: np.ndarray,
    number: int,
    kept: int,
) -> tuple[np.ndarray, np.ndarray, float]:
    """(ends, samples, largest error of a step)."""
    runs, r = x.shape
    groups = -(-runs // WIDTH)
    chosen = np.minimum(np.arange(groups * WIDTH), runs - 1).reshape(groups, WIDTH)
    drift, force = flow.field.drift, flow.field.force
    work = np.zeros(WIDTH * max(drift.rows, force.rows))
    z, path, worst = np.empty((groups, r, WIDTH)), np.empty((groups, kept, r, WIDTH)), 0.0
    for group, lanes in enumerate(chosen):
        z[group] = (x[lanes] * flow.reach).T
        error = _flow(
            *(drift.function, drift.numbers, drift.index),
            *(force.function, force.numbers, force.index),
            work,
            np.stack([frequency[lanes], amplitude[lanes]]),
            flow.reach,
            number,
            z[group],
            path[group],
        )
        worst = max(worst, error)
    # (groups, ..., r, WIDTH) -> (runs, ..., r)
    ends = z.transpose(0, 2, 1).reshape(-1, r)[:runs] / flow.reach
    samples = path.transpose(0, 3, 1, 2).reshape(-1, kept, r)[:runs] / flow.reach
    return ends, samples, worst


def _numpy_run(
    flow: FlowMap,
    x: np.ndarray,
    frequency: np.ndarray,
    amplitude: np.ndarray,
    number: int,
    kept: int,
) -> tuple[np.ndarray, np.ndarray, float]:
    """The same from numpy functions."""
    z, h = x * flow.reach, (2.0 * np.pi / frequency / number)[:, None]
    path, worst = np.empty((len(x), kept, x.shape[1])), 0.0
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
            if not np.abs(z / flow.reach).max() < _LIMIT:
                return z, path, np.inf
    return z / flow.reach, path, worst


with warnings.catch_warnings():
    warnings.simplefilter("ignore", NumbaExperimentalFeatureWarning)

    @kernel(
        types.float64(*_MAP, *_MAP, _f1, _f2, _f1, types.int64, _f2, _f3),
        fastmath={"contract"},
    )
    def _flow(
        drift,
        drift_numbers,
        drift_index,
        force,
        force_numbers,
        force_index,
        work,
        drive,
        reach,
        number,
        z,
        path,
    ):
        """Carries z (r, WIDTH) over a period and fills `path` (kept, r, WIDTH); `drive` (2, WIDTH)
        holds frequencies and amplitudes. The largest error of a step, of the range.
        """
        r, kept = len(z), len(path)
        h, signal = room(1, WIDTH), room(1, WIDTH)
        y, push = room(r, WIDTH), room(r, WIDTH)
        slopes = room(STAGES * r, WIDTH)
        worst = 0.0
        for w in range(WIDTH):
            h[0, w] = 2.0 * np.pi / drive[0, w] / number
        length = get(h, 0, WIDTH)
        for step in range(number):
            if step % (number // kept) == 0:
                path[step // (number // kept)] = z
            for s in range(STAGES):
                for i in range(r):
                    total = fill(0.0, WIDTH)
                    for j in range(s):
                        if _A[s, j] != 0.0:
                            total += get(slopes, j * r + i, WIDTH) * _A[s, j]
                    put(y, i, get(z, i, WIDTH) + length * total)
                out = slopes[s * r : (s + 1) * r]
                drift(y, drift_numbers, drift_index, work, out)
                force(y, force_numbers, force_index, work, push)
                wave = np.sin(2.0 * np.pi * (step + _C[s]) / number)
                for w in range(WIDTH):
                    signal[0, w] = drive[1, w] * wave
                now = get(signal, 0, WIDTH)
                for i in range(r):
                    put(out, i, get(out, i, WIDTH) + now * get(push, i, WIDTH))
            for i in range(r):
                total = fill(0.0, WIDTH)
                five, three = fill(0.0, WIDTH), fill(0.0, WIDTH)
                for s in range(STAGES):
                    slope = get(slopes, s * r + i, WIDTH)
                    total += slope * _B[s]
                    five += slope * _E5[s]
                    three += slope * _E3[s]
                put(z, i, get(z, i, WIDTH) + length * total)
                put(y, i, length * five)
                put(push, i, length * three)
                for w in range(WIDTH):
                    one, other = (y[i, w] / reach[i]) ** 2, (push[i, w] / reach[i]) ** 2
                    error = one / np.sqrt(one + 0.01 * other) if one > 0.0 else one
                    if not error <= worst:  # NaN too
                        worst = error
                    if not abs(z[i, w]) < _LIMIT * reach[i]:
                        return np.inf
        return worst
