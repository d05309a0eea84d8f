"""The flow of a reduced model over a period as a map, with its derivative.

    dz/dt = drift(z) + force(z) a sin(Omega t),    x = z/Z,    x -> H(x, Omega, a): x after a period

Z is the training range. Runge-Kutta steps of order 8 (Dormand and Prince's, as in Hairer, Norsett,
Wanner, Solving Ordinary Differential Equations I, II.5), all of one length, so that the map is
smooth: its derivative is taken by central differences of the map itself, the neighbours side by
side with the point in the lanes of one run, so that one position and its velocity cost no more than
the value. With nudges d and slopes mu, 1e-16/d of the derivative is lost to rounding and d^2 mu^2
to the curvature of the map: the larger the slopes, the smaller the nudges. The one along a, which
only tells where to go, is taken ahead, so that eight lanes are enough. Where the drift is odd and
the force even, motions z(t + T/2) = -z(t) are followed: H is half a period and a change of sign.
The estimate of the error, which falls with the power 8 of the step as that of DOP853, says how many
steps a map takes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from vibrom.solvers.periodic import flow_steps, kinks
from vibrom.solvers.periodic.maps import Return, Swing
from vibrom.solvers.reduced.field import VectorField

NUDGE = 1e-7  # of the range, of the frequency and of the amplitude, where slopes are one or less
TOLERANCE = 1e-6  # of the range, estimated error of a step; what is lost in a period is less
AIM = 0.2  # of it, where the number of steps is chosen anew
FEWER = 0.75  # of the steps: where so few would do, so many are taken next time
LOOSE = 1e-3  # with all the steps there are: a worse motion is lost
FEWEST, MOST = 8, 256  # steps to a map
ODD = 1e-5  # of the largest rate: what rounding leaves of an odd drift and an even force
AROUND = np.geomspace(0.02, 2.0, 8)  # of the range: how far from rest this is asked
TRIED = 8  # points at each distance
KEPT, SHOWN = 128, 512  # samples of a period that are evaluated, and those that are shown
BLOCK = 512  # samples that are decoded at a time, whose numbers stay near the processor
PHASES = 32  # samples of a period that tell its first harmonic


@dataclass
class _Steps:
    """How many a map takes, and how large its derivative is; all that it remembers."""

    number: int = FEWEST
    slope: float = 1.0
    kinks: np.ndarray = field(default_factory=lambda: np.empty(0))  # where it passes them


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
    along: Callable[[np.ndarray], np.ndarray]  # (b,) p'q [N m] of z (b, r)
    beside_along: Callable[[np.ndarray], np.ndarray | None]  # (2, b) likewise, beside the manifold
    load: np.ndarray  # (n,) N
    reach: np.ndarray  # (r,) Z
    frequency: float  # rad/s, a scale
    steps: _Steps = field(default_factory=_Steps)
    parts: int = 1  # 2: half a period, for an odd drift and an even force
    free: bool = True  # the derivative costs no more than the value

    @cached_property
    def whole(self) -> FlowMap:
        """See `Equation`."""
        return replace(self, parts=1, steps=_Steps())

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
        self,
        x: np.ndarray,
        frequency: float,
        amplitude: float,
        derivative: bool = True,
        phase: bool = False,
    ) -> Return:
        """H of x (r,)."""
        r, given = len(x), np.array([*x, frequency, amplitude], dtype=float)
        points = given[None]
        if derivative:
            nudge = NUDGE / max(self.steps.slope, 1.0) ** 0.5
            nudges = nudge * given
            nudges[:r], nudges[r + 1] = nudge, nudges[r + 1] or nudge
            points = given + self._neighbours * nudges
        end, path = self._periods(points, PHASES if phase else 1)
        if not np.isfinite(end).all():
            return Return(end[0], ok=False)
        value = end
        if phase:
            value = np.concatenate([end, self._in_phase(path, points[:, -1])[:, None]], axis=1)
        found = value[0, r] if phase else None
        if not derivative:
            return Return(end[0], ok=True, in_phase=found)
        slopes = value.T @ self._differences / nudges
        by = slopes[:r, :r], slopes[:r, r], slopes[:r, r + 1]
        self.steps.slope = float(np.abs(by[0]).max())
        return Return(end[0], True, False, *by, found, slopes[r] if phase else None)

    def _in_phase(self, path: np.ndarray, amplitude: np.ndarray) -> np.ndarray:
        """(b,) what is in phase with the load in samples (b, k, r) of a period, under amplitudes
        (b,).
        """
        runs, kept, r = path.shape
        z = (path * self.reach).reshape(-1, r)
        waves = _waves(kept)
        shown, added = self.along(z).reshape(runs, kept), self.beside_along(z)
        if added is not None:
            beside = np.einsum("wk,wbk->bk", waves, added.reshape(2, runs, kept))
            shown = shown + amplitude[:, None] * beside
        return 2.0 / kept * shown @ waves[0]

    @cached_property
    def _neighbours(self) -> np.ndarray:
        """(2 r + 4, r + 2) the point itself, then those ahead of it, then those behind."""
        axes = np.eye(self.size + 2)
        return np.concatenate([0.0 * axes[:1], axes, -axes[:-1]])

    @cached_property
    def _differences(self) -> np.ndarray:
        """(2 r + 4, r + 2) what of each of them makes the slopes, central but for the last."""
        ahead, behind = np.eye(self.size + 2), np.eye(self.size + 1, self.size + 2)
        central = np.concatenate([0.0 * ahead[:1], 0.5 * ahead, -0.5 * behind])
        central[0, -1], central[self.size + 2, -1] = -1.0, 1.0
        return central

    def swings(self, x: np.ndarray, frequency: np.ndarray, amplitude: np.ndarray) -> list[Swing]:
        """The motions over a period from x (b, r)."""
        _, path = self._periods(np.column_stack([x, frequency, amplitude]), KEPT)
        return self.shown(path, amplitude)

    def shown(self, path: np.ndarray, amplitude: np.ndarray) -> list[Swing]:
        """The motions of samples (b, KEPT, r) of a period in units of the range, interpolated by
        their harmonics.
        """
        ratio = np.abs(path).max(axis=(1, 2))
        z = (path * self.reach).reshape(-1, self.size)
        blocks = [z[first : first + BLOCK] for first in range(0, len(z), BLOCK)]
        shown = np.concatenate([self.displacement(block) for block in blocks])
        beside = [self.beside(block) for block in blocks]
        if beside[0] is not None:
            waves = _waves(KEPT)[:, None] * amplitude[:, None]
            added = np.concatenate(beside, axis=1)
            shown = shown + np.einsum("wb,wbk->bk", waves.reshape(2, -1), added)
        shown = shown.reshape(len(path), KEPT, -1).transpose(0, 2, 1)
        finite = np.isfinite(shown).all(axis=(1, 2))
        fine = np.full((*shown.shape[:2], SHOWN), np.nan)
        fine[finite] = np.fft.irfft(np.fft.rfft(shown[finite]), SHOWN) * (SHOWN / KEPT)
        return [Swing(*both) for both in zip(fine, ratio.tolist())]

    def path(self, x: np.ndarray, frequency: float, amplitude: float) -> np.ndarray:
        """Samples (KEPT, r) of the period that begins at x (r,), in units of the range."""
        return self._periods(np.array([[*x, frequency, amplitude]]), KEPT)[1][0]

    def states(self, x: np.ndarray, frequency: float, amplitude: float) -> np.ndarray:
        """Displacement and velocity (KEPT, 2n) over a period from x (r,), those of the manifold."""
        return self.decode(self.path(x, frequency, amplitude) * self.reach)

    def after(self, x: np.ndarray, frequency: float, amplitude: float, periods: int) -> np.ndarray:
        """Where x (r,) is after so many periods; NaN where the motion does not last."""
        for _ in range(periods * self.parts):
            if np.isfinite(x).all():
                x = self(x, frequency, amplitude, derivative=False).end
        return x

    def opinion(self, x: np.ndarray, frequency: float, amplitude: float, harmonics: int) -> None:
        """None: `HarmonicBalance` follows whole curves."""

    @cached_property
    def _run(self) -> flow_steps.Run:
        """What carries points over a period."""
        if self.field is None:
            return flow_steps.plain(self.drift, self.force, self.reach, self.parts)
        return flow_steps.compiled(self.field, self.reach, self.parts)

    @cached_property
    def _kink(self) -> np.ndarray | None:
        """(d,) in units of the range; None: the field is smooth."""
        kink = None if self.field is None else self.field.kink
        return None if kink is None else kink / self.reach[: len(kink)]

    def _passed(self, points: np.ndarray, path: np.ndarray, grid: flow_steps.Grid) -> bool:
        """Where the first of points (b, r + 2) passed kinks on its path (n + 1, r), if velocities
        follow the positions in z: is it elsewhere than remembered? Only then it is what is.
        """
        d = len(self._kink)
        whole = 2.0 * np.pi / points[0, self.size] / self.parts
        scale = whole * self.reach[d : 2 * d] / self.reach[:d]
        position, rate = path[:, :d] / self._kink, scale * path[:, d : 2 * d] / self._kink
        found = kinks.passed(position, rate, grid.at)
        moved = kinks.moved(self.steps.kinks, found)
        if moved:
            self.steps.kinks = found
        return moved

    def _run_near(self, points: np.ndarray, number: int) -> tuple[np.ndarray, np.ndarray, float]:
        """Of neighbours of one motion, in so many steps, of which some begin at kinks."""
        if self._kink is None:
            return self._run(points, flow_steps.even(number, self.parts), 1, True)
        for again in (True, False):
            grid = flow_steps.even(number, self.parts)
            if len(self.steps.kinks):
                at = kinks.between(number, self.steps.kinks)
                grid = flow_steps.uneven(at, self.parts)
            end, path, error = self._run(points, grid, len(grid.lengths), True)
            if not error < np.inf:
                break
            moved = self._passed(points, np.concatenate([path[0], end[:1]]), grid)
            if error < TOLERANCE or not (moved and again):
                break
        return end, path, error

    def _periods(self, points: np.ndarray, kept: int = 1) -> tuple[np.ndarray, np.ndarray]:
        """(H (b, r), samples (b, kept, r) of a period from the start on), in units of the range, of
        points (b, r + 2): x, frequency and amplitude.
        """
        each = -(-kept // self.parts)

        def run(number: int) -> tuple[np.ndarray, np.ndarray, float]:
            if kept == 1:
                return self._run_near(points, number)
            return self._run(points, flow_steps.even(number, self.parts), each, False)

        number = -(-self.steps.number // each) * each
        end, path, error = run(number)
        while not error < TOLERANCE and number < MOST:
            number = -(-_enough(number, error) // each) * each
            end, path, error = run(number)
        if self.parts == 2:
            end, path = -end, np.concatenate([path, -path], axis=1)
        if not error < LOOSE:
            return np.full_like(end, np.nan), path
        if kept == 1:
            fewer = _enough(number, error)
            self.steps.number = fewer if fewer < FEWER * number else number
        return end, path


def _enough(number: int, error: float) -> int:
    """Steps of which the worst has AIM of the tolerance, if `number` of them have this error."""
    if not np.isfinite(error):  # the motion is lost, or else it takes many more
        return MOST
    ratio = (error / (AIM * TOLERANCE)) ** (1.0 / 8.0)
    return min(max(4 * math.ceil(number * min(ratio, 2.0) / 4.0), FEWEST), MOST)


def odd(
    drift: Callable[[np.ndarray], np.ndarray],
    force: Callable[[np.ndarray], np.ndarray],
    reach: np.ndarray,
) -> bool:
    """Are drift(-z) = -drift(z) and force(-z) = force(z)? Of each coordinate and at each distance
    from rest by itself: some have larger rates than others, and high powers hide all else far off.
    """
    z = np.random.default_rng(0).uniform(-1.0, 1.0, (len(AROUND), TRIED, len(reach)))
    z = z * AROUND[:, None, None] * reach

    def same(function: Callable[[np.ndarray], np.ndarray], sign: float) -> bool:
        one, other = (function(at.reshape(-1, len(reach))).reshape(z.shape) for at in (z, -z))
        left = np.abs(one - sign * other).max(axis=1)
        return bool((left <= ODD * np.abs(one).max(axis=1)).all())

    return same(drift, -1.0) and same(force, 1.0)


def _waves(count: int) -> np.ndarray:
    """(2, count) sine and cosine over a period."""
    angle = 2.0 * np.pi * np.arange(count) / count
    return np.stack([np.sin(angle), np.cos(angle)])
