"""The full order's own motion over a period as a map, with its exact derivative.

    x -> H(x, Omega, amplitude):   (q, v) after a period, or S (q, v) after half of one, of
    Newmark's steps from (q, v) and the acceleration of equilibrium;   x = (y(q), N v),  N'N = M

with the coordinates y of `coordinates`, so that |x|^2 is a kinetic energy in size. What repeats is
the motion of the steps themselves, numerical damping included: long time marching with the same
steps ends on it.

A derivative by all of x costs 2n motions beside the first. What is fast is damped away within the
period, so that one along the slow directions P alone, dH/dx P P', still leads to the motion, in
some more corrections; multipliers want the whole.

A guess that still stretches the body too much begins with an acceleration that the steps do not
survive. It starts without one instead, which is rough: right to (Omega h)^2/4, and enough for a
first correction.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import block_diag, cho_solve, cholesky, solve_triangular

from vibrom.solvers.full.newmark import Motion, Newmark, Record
from vibrom.solvers.full.tangent import Tangent
from vibrom.solvers.periodic.balanced_body import BodyBalance, Unbalanced
from vibrom.solvers.periodic.carry import Path, carried
from vibrom.solvers.periodic.coordinates import Coordinates, NoState
from vibrom.solvers.periodic.maps import Opinion, Return, Swing
from vibrom.solvers.periodic.symmetry import Symmetry
from vibrom.term import Term

TOLERANCE = 1e-9  # residual of a step: what a map leaves open, an orbit cannot close


@dataclass(frozen=True)
class NewmarkMap:
    """Motion over a period, or half of one where the body has a symmetry."""

    term: Term
    newmark: Newmark
    steps_per_period: int
    frequency: float  # rad/s, a scale
    probes: np.ndarray  # (k,)
    rest: np.ndarray  # (n,) m
    symmetry: Symmetry | None = None
    free: bool = False  # the derivative costs several times the value
    # P (n, k) of displacements and of velocities, orthonormal, whose changes the derivative knows;
    # None: all
    along: tuple[np.ndarray, np.ndarray] | None = None

    @property
    def parts(self) -> int:
        """Maps to a period."""
        return 1 if self.symmetry is None or self.steps_per_period % 2 else 2

    @property
    def whole(self) -> NewmarkMap:
        """See `Equation`."""
        return replace(self, symmetry=None)

    @property
    def size(self) -> int:
        """Of x."""
        return 2 * self.term.size

    @cached_property
    def _coordinates(self) -> Coordinates:
        return Coordinates(self.term, self.rest, self.frequency)

    @cached_property
    def _root(self) -> np.ndarray:
        """N, an upper triangle."""
        return cholesky(self.term.mass.toarray())

    @cached_property
    def _tangents(self) -> tuple[Tangent, Tangent]:
        """K + df/dq and C + df/dv."""
        return Tangent(self.term, 0.0, 0.0, 1.0), Tangent(self.term, 0.0, 1.0, 0.0)

    @cached_property
    def _signal(self) -> np.ndarray:
        """sin(Omega t) at the steps of one map."""
        steps = self.steps_per_period // self.parts
        return np.sin(2.0 * np.pi * np.arange(steps + 1) / self.steps_per_period)

    def of_state(self, state: np.ndarray) -> np.ndarray:
        """The point x (2n,) of a displacement from rest and a velocity (2n,)."""
        q, v = np.split(state, 2)
        return np.concatenate([self._coordinates.of(self.rest + q), self._root @ v])

    def state(self, x: np.ndarray) -> np.ndarray:
        """Displacement from rest and velocity (2n,) at a point. Raises NoState."""
        y, v = np.split(x, 2)
        q = self._coordinates.to(y) - self.rest
        return np.concatenate([q, solve_triangular(self._root, v)])

    def only(self, shapes: np.ndarray) -> NewmarkMap:
        """This with derivatives by displacements and velocities in these shapes (n, k) alone."""
        displacement, _ = np.linalg.qr(self._coordinates.root @ shapes)
        velocity, _ = np.linalg.qr(self._root @ shapes)
        return replace(self, along=(displacement, velocity))

    @property
    def load(self) -> np.ndarray:
        """p (n,) [N]."""
        return np.zeros(self.term.size) if self.term.load is None else self.term.load

    @cached_property
    def _weight(self) -> np.ndarray:
        """Of each step of one map in 2/T int p'q sin(Omega t) dt over a whole period."""
        return 2.0 * self.parts / self.steps_per_period * self._signal

    def __call__(
        self,
        x: np.ndarray,
        frequency: float,
        amplitude: float,
        derivative: bool = True,
        phase: bool = False,  # costs nothing
    ) -> Return:
        """Where x (2n,) is after a period."""
        drive = np.array([frequency]), np.array([amplitude])
        try:
            state = self.state(x)[:, None]
        except NoState:
            return Return(np.full(self.size, np.nan), ok=False)
        for acceleration in ("equilibrium", "zero"):
            motion = self._motion(state, *drive, Record(), acceleration)
            q, v, a = motion.displacement[0], motion.velocity[0], motion.acceleration[0]
            if np.isfinite(q[-1]).all():
                break
        else:
            return Return(np.full(self.size, np.nan), ok=False)
        end = self._turned(np.concatenate([q[-1] - self.rest, v[-1]]))
        in_phase = float(self._weight @ ((q - self.rest) @ self.load))
        rough = acceleration == "zero"
        found = Return(self.of_state(end), ok=True, rough=rough, in_phase=in_phase)
        if not derivative:
            return found
        step = 2.0 * np.pi / frequency / self.steps_per_period
        taken = Path(self.term, self.newmark, step, self._signal, self._weight, q, v, a)
        start = self._axes(q[0], v[0], found.rough)
        return replace(found, **self._slopes(taken, frequency, start, end))

    def swings(self, x: np.ndarray, frequency: np.ndarray, amplitude: np.ndarray) -> list[Swing]:
        """The motions of points (b, 2n) over a period, at every step."""
        mirrored = self.probes if self.parts == 1 else self.symmetry.order[self.probes]
        watched = np.union1d(self.probes, mirrored)
        record = Record(start=len(self._signal), probes=watched)
        states = np.stack([self.state(one) for one in x], axis=1)
        shown = self._motion(states, frequency, amplitude, record).probes
        shown = shown - self.rest[watched][:, None]
        half = shown[:, np.searchsorted(watched, self.probes), :-1]
        if self.parts == 2:
            other = shown[:, np.searchsorted(watched, mirrored), :-1]
            half = np.concatenate([half, self.symmetry.sign[self.probes, None] * other], axis=2)
        return [Swing(shown, float("nan")) for shown in half]

    def states(self, x: np.ndarray, frequency: float, amplitude: float) -> np.ndarray:
        """The steps (steps, 2n) of a whole period from x (2n,)."""
        drive = np.array([frequency]), np.array([amplitude])
        motion = self._motion(self.state(x)[:, None], *drive, Record())
        half = np.concatenate([motion.displacement[0] - self.rest, motion.velocity[0]], axis=1)[:-1]
        return half if self.parts == 1 else np.concatenate([half, self._turned(half.T).T])

    def after(self, x: np.ndarray, frequency: float, amplitude: float, periods: int) -> np.ndarray:
        """Where x (2n,) is after so many periods; NaN where the motion does not last."""
        if not np.isfinite(x).all():
            return x
        steps = periods * self.steps_per_period
        whole = np.sin(2.0 * np.pi * np.arange(steps + 1) / self.steps_per_period)
        drive, record = (np.array([frequency]), np.array([amplitude])), Record(start=steps)
        # as the steps of any other run are solved: what a map closes to, marching need not
        start, loose = self.state(x)[:, None], self.newmark.tolerance
        motion = self._motion(start, *drive, record, signal=whole, tolerance=loose)
        end = np.concatenate([motion.displacement[0, 0] - self.rest, motion.velocity[0, 0]])
        return self.of_state(end) if np.isfinite(end).all() else np.full(self.size, np.nan)

    def opinion(
        self, x: np.ndarray, frequency: float, amplitude: float, harmonics: int
    ) -> Opinion | None:
        """By harmonic balance, which takes no time steps; None where it finds no motion."""
        mirror = None if self.parts == 1 else self.symmetry
        path = self.states(x, frequency, amplitude)[:, : self.term.size]
        more = harmonics + max(harmonics // 2, 1)
        try:
            body = BodyBalance(self.term, self.rest, mirror, harmonics)
            found = body.solve(path, frequency, amplitude, hold=True)
            shown = body.path(found.x, len(path))
            further = replace(body, harmonics=more).change(shown, found.frequency, amplitude)
        except Unbalanced:
            return None
        return Opinion(shown[:, self.probes].T, found.frequency, harmonics, further)

    def _motion(
        self,
        state: np.ndarray,
        frequency: np.ndarray,
        amplitude: np.ndarray,
        record: Record,
        acceleration: str = "equilibrium",
        signal: np.ndarray | None = None,
        tolerance: float = TOLERANCE,
    ) -> Motion:
        """The steps from states (2n, b) under a signal of unit amplitude, that of one map if none
        is given.
        """
        q, v = np.split(state, 2)
        signal = self._signal if signal is None else signal
        newmark = replace(self.newmark, tolerance=min(self.newmark.tolerance, tolerance))
        return newmark.run(
            self.term,
            self.rest[:, None] + q,
            2.0 * np.pi / frequency / self.steps_per_period,
            len(signal) - 1,
            velocity=v,
            signal=signal[:, None] * amplitude,
            initial_acceleration=acceleration,
            record=record,
        )

    def _turned(self, state: np.ndarray) -> np.ndarray:
        """S of a state (2n, ...) after half a period; after a whole one the state itself."""
        if self.parts == 1:
            return state
        return np.concatenate([self.symmetry(part) for part in np.split(state, 2)])

    def _axes(self, q: np.ndarray, v: np.ndarray, still: bool) -> np.ndarray:
        """Changes (3, n, 2k + 2) of displacement, velocity and acceleration at the start: one for
        each direction of x, none for frequency and amplitude.
        """
        n = self.term.size
        displacement, velocity = self.along or (np.eye(n), np.eye(n))
        k = displacement.shape[1]
        start = np.zeros((3, n, 2 * k + 2))
        start[0, :, :k] = self._coordinates.axes(q, displacement)
        start[1, :, k : 2 * k] = solve_triangular(self._root, velocity)
        if not still:
            at = q[:, None], v[:, None]
            pull = sum(tangent.at(*at) @ change for tangent, change in zip(self._tangents, start))
            start[2] = -cho_solve((self._root, False), pull)
        return start

    def _slopes(
        self, taken: Path, frequency: float, start: np.ndarray, end: np.ndarray
    ) -> dict[str, np.ndarray]:
        """dH/dx, dH/dOmega, dH/damplitude and the derivative of what is in phase."""
        by_step, by_signal = np.zeros((2, start.shape[2]))
        by_step[-2], by_signal[-1] = -taken.step / frequency, 1.0
        changes, seen = carried(taken, start, by_step, by_signal)
        q, v = np.split(self._turned(np.concatenate([*changes])), 2)
        at = self.rest + end[: self.term.size]
        ends = np.concatenate([self._coordinates.slope(at, q), self._root @ v])
        by_start = ends[:, :-2]
        if self.along:
            along = block_diag(*self.along)
            by_start = by_start @ along.T
            seen = np.append(along @ seen[:-2], seen[-2:])
        slopes = by_start, ends[:, -2], ends[:, -1], seen
        return dict(zip(("by_start", "by_frequency", "by_amplitude", "in_phase_by"), slopes))
