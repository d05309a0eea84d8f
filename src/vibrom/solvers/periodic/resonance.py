"""Phase resonance: motions whose displacement along the load lags it by a quarter of a period.

    H(x, Omega, a) - x = 0,    s(x, Omega, a) = 2/T int p'q sin(Omega t) dt = 0

along the amplitude a of the forcing. There the load does nothing but replace what damping takes, so
that a lightly damped body moves as it would without both: on its backbone. Every peak of a response
curve lies near such a motion, those of an isola too.

What damping takes in a period is the work of the load, W = pi a |p'q|_1; the damping ratio is that
of the linear oscillator with the same kinetic energy,

    zeta = W/(2 Omega int v'Mv dt)

which is c/(2 Omega) for C = c M, however large the motion. Sources: Peeters, Kerschen, Golinval, J.
Sound Vib. 330 (2011) 486; Volvert, Kerschen, J. Sound Vib. 511 (2021) 116355.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix
from threadpoolctl import threadpool_limits

from vibrom.solvers.periodic import continuation
from vibrom.solvers.periodic.continuation import Pace, Value
from vibrom.solvers.periodic.equations import from_rest
from vibrom.solvers.periodic.maps import ReturnMap
from vibrom.solvers.periodic.response import Orbit, Span, branch

LOWEST = 0.01  # of the largest forcing: where the backbone begins, nearly linear


@dataclass(frozen=True)
class Resonance:
    """H - x and s in units of x; of X = (x, e), Omega = Omega_0 (1 + e/X_0)."""

    flow: ReturnMap
    frequency: float  # rad/s, Omega_0
    size: float  # X_0, of x at the largest forcing if the body were nearly linear
    unit: float  # N m, of s per unit of x

    def drive(self, point: np.ndarray) -> tuple[np.ndarray, float]:
        """x (m,) and Omega [rad/s] of X (m + 1,)."""
        return point[:-1], self.frequency * (1.0 + float(point[-1]) / self.size)

    def __call__(self, point: np.ndarray, p: float, derivative: bool) -> Value:
        """At the amplitude p."""
        x, frequency = self.drive(point)
        found = self.flow(x, frequency, p, derivative, phase=True)
        if not found.ok:
            return Value(point, ok=False)
        residual = np.append(found.end - x, found.in_phase / self.unit)
        if found.by_start is None:
            return Value(residual, ok=True, rough=found.rough, details=found)
        m, scale = len(x), self.frequency / self.size
        whole = np.empty((m + 1, m + 2))
        whole[:m, :m], whole[:m, m] = found.by_start - np.eye(m), found.by_frequency
        whole[:m, m + 1], whole[m] = found.by_amplitude, found.in_phase_by / self.unit
        whole[:, m] *= scale
        return Value(residual, whole[:, :-1], whole[:, -1], True, found.rough, found)


@dataclass(frozen=True)
class Backbone:
    """Motions at phase resonance, as the forcing grows."""

    problem: Resonance
    orbits: list[Orbit]

    def near(self, amplitude: float) -> list[tuple[np.ndarray, float]]:
        """(x, Omega) where the backbone passes this amplitude of the forcing, by chords."""
        found = []
        for one, other in zip(self.orbits, self.orbits[1:]):
            low, high = one.point, other.point
            if (low.p - amplitude) * (high.p - amplitude) <= 0.0 and low.p != high.p:
                share = (amplitude - low.p) / (high.p - low.p)
                found.append(self.problem.drive(low.x + share * (high.x - low.x)))
        return found


def backbone(
    flow: ReturnMap,
    highest: float,
    points: int,
    turn: float,
    heard: Callable[[int], object] = int,
) -> Backbone:
    """From a small forcing up to the `highest`; `heard` is told of every motion. Raises Lost where
    it cannot be begun.
    """
    lowest = LOWEST * highest
    pace = Pace(0.5 * highest, turn=turn, newton=flow.free, heard=heard)
    x = from_rest(flow, flow.frequency, lowest)
    size = float(np.linalg.norm(x))
    states = flow.states(x, flow.frequency, lowest)
    along = np.abs(states[:, : len(flow.load)] @ flow.load).max()
    problem = Resonance(flow, flow.frequency, size / LOWEST, float(along) / size)
    start = continuation.at(problem, np.append(x, 0.0), lowest, pace)
    span = Span(0.5 * lowest, highest, points, 0.0)
    with threadpool_limits(limits=1, user_api="blas"):  # see `response`
        return Backbone(problem, branch(problem, start, span, pace, flow.parts))


def damping_ratio(
    flow: ReturnMap, mass: csr_matrix, x: np.ndarray, frequency: float, amplitude: float
) -> float:
    """zeta of the motion from x (m,), see above."""
    states = flow.states(x, frequency, amplitude)
    q, v = np.split(states, 2, axis=1)
    wave = np.sin(2.0 * np.pi * np.arange(len(states)) / len(states))
    # int p'v a sin(Omega t) dt and int v'Mv dt, as means over the period
    work = amplitude * float(np.mean((v @ flow.load) * wave))
    return work / (2.0 * frequency * float(np.mean(np.sum(v * (mass @ v.T).T, axis=1))))
