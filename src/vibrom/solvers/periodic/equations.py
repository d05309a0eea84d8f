"""The equations of a periodic motion, and a first solution.

    H(x, Omega, a) - x = 0

along the frequency Omega of the forcing or along its amplitude a. The first motion of a curve is
found from rest, by continuation in the amplitude from a forcing under which the model is nearly
linear.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vibrom.solvers.periodic import between, continuation
from vibrom.solvers.periodic.continuation import Lost, Pace, Point, Problem, Value
from vibrom.solvers.periodic.maps import Equation, Return, Swing

SMALL = (0.1, 0.01)  # of the forcing: where the continuation in it begins, nearly linear
# What Newton's corrections from rest may leave in the next ones at the whole forcing: by
# Kantorovich's theorem there is then one motion near rest, and one at every smaller forcing.
STRAIGHT = 0.1
MOST = 200  # points from rest to a start
ASYMMETRIC = 1e-3  # of a motion: half a period changes no more of a symmetric one


@dataclass(frozen=True)
class Along:
    """The motions of a model along the frequency of its forcing or along the amplitude."""

    flow: Equation
    frequency: float | None = None  # rad/s; None: it varies
    amplitude: float | None = None  # None: it varies

    def drive(self, p: float) -> tuple[float, float]:
        """Frequency [rad/s] and amplitude of the forcing at p."""
        return (
            p if self.frequency is None else self.frequency,
            p if self.amplitude is None else self.amplitude,
        )

    def __call__(self, x: np.ndarray, p: float, derivative: bool) -> Value:
        """H(x, p) - x."""
        found = self.flow(x, *self.drive(p), derivative)
        by_p = found.by_frequency if self.frequency is None else found.by_amplitude
        return _value(found, x, by_p)

    def swings(self, x: np.ndarray, p: np.ndarray) -> list[Swing]:
        """What the motions of points x (b, m) at p (b,) look like."""
        drives = np.array([self.drive(float(one)) for one in p])
        return self.flow.swings(x, *drives.T)

    @property
    def whole(self) -> Along:
        """The same over whole periods."""
        return replace(self, flow=self.flow.whole)

    def image(self, x: np.ndarray, p: float) -> np.ndarray | None:
        """Of an asymmetric motion near x and p, which half a period and a change of sign make
        another one, a point of that; None of a symmetric motion.
        """
        if self.flow.parts == 1:
            return None
        once = self.flow(x, *self.drive(p), derivative=False).end
        twice = self.flow(once, *self.drive(p), derivative=False).end
        left = np.linalg.norm(once - x)
        back = np.linalg.norm(twice - x) < 0.1 * left
        return once if back and left > ASYMMETRIC * np.linalg.norm(x) else None

    def ends(self, lowest: float, highest: float) -> list[tuple[float, float]]:
        """Where motions from rest begin a curve, and which way it goes from there. In a forcing
        that grows at one frequency both ends lie on the same curve.
        """
        ends = [(lowest, 1.0), (highest, -1.0)]
        return ends if self.frequency is None else ends[:1]


def in_frequency(flow: Equation, amplitude: float) -> Along:
    """H(x, p, amplitude) - x."""
    return Along(flow, amplitude=amplitude)


def in_amplitude(flow: Equation, frequency: float) -> Along:
    """H(x, frequency, p) - x."""
    return Along(flow, frequency=frequency)


def _value(found: Return, x: np.ndarray, by_p: np.ndarray | None) -> Value:
    by_x = None
    if found.by_start is not None:
        by_x = found.by_start.copy()
        by_x.flat[:: len(x) + 1] -= 1.0
    return Value(found.end - x, by_x, by_p, found.ok, found.rough, found)


def prepare(flow: Equation, frequency: float) -> None:
    """Loads and compiles what a map needs, at rest, so that later only computations take time."""
    flow(np.zeros(flow.size), frequency, 0.0)
    many = 9  # from nine states on, sixteen go side by side
    flow.swings(np.zeros((many, flow.size)), np.full(many, frequency), np.zeros(many))


def from_rest(flow: Equation, frequency: float, amplitude: float) -> np.ndarray:
    """A motion x (m,) at this forcing, followed from rest. Raises Lost."""
    problem = in_amplitude(flow, frequency)
    pace = Pace(0.5 * amplitude, first=0.2, largest=1.0, turn=0.5, newton=flow.free)
    once = _at_once(problem, flow.size, amplitude, pace)
    if once is not None:
        return once
    before = _beginning(problem, flow.size, amplitude, pace)
    for count, ahead in enumerate(continuation.walk(problem, before, pace)):
        if ahead.p >= amplitude:
            return between.onto(problem, before, ahead, amplitude, pace).x
        if count > MOST:
            break
        before = ahead
    raise Lost("the amplitude of the forcing was not reached")


def _at_once(problem: Problem, size: int, amplitude: float, pace: Pace) -> np.ndarray | None:
    """The motion (m,), where Newton's method tells that it is nearly linear."""
    if not pace.newton:
        return None
    try:
        found = continuation.at(problem, np.zeros(size), amplitude, pace)
    except Lost:
        return None
    return found.x if found.bent * np.linalg.norm(found.x) <= STRAIGHT else None


def _beginning(problem: Problem, size: int, amplitude: float, pace: Pace) -> Point:
    """A motion under a part of the forcing that is small enough."""
    for part in SMALL[:-1]:
        try:
            return continuation.at(problem, np.zeros(size), part * amplitude, pace)
        except Lost:
            continue
    return continuation.at(problem, np.zeros(size), SMALL[-1] * amplitude, pace)
