"""A batch of states that are integrated side by side, ready for any method."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgError, solveh_banded
from scipy.sparse.linalg import splu

from vibrom.kernels import banded
from vibrom.kernels.compiled import Rows, Vector, part
from vibrom.kernels.lanes import room
from vibrom.solvers.full.scheme import Scheme, weights
from vibrom.solvers.full.shapes import shaped
from vibrom.solvers.full.store import State
from vibrom.term import SceneError, Term

# (remaining states, batch width): two registers hide each other's latency. One state alone has
# elements in its lanes; a few states cost less one by one than in a batch filled up with copies.
WIDTHS = ((9, 16), (3, 8), (1, 1))
WIDEST_BAND = 1000  # of a mass; beyond it a sparse factor is cheaper than a banded one


class Steps(NamedTuple):
    """A scheme's formulas for the time step of each state."""

    scheme: Scheme
    h: Rows  # (1, width) s
    by_q: Rows  # (1, width) s^2, what an acceleration adds to q: beta h^2 in Newmark's method
    by_v: Rows  # (1, width) s, and to v: gamma h


class Loads(NamedTuple):
    """p u(t) + p_0, and of one state alone further loads p_k u_k(t)."""

    signal: Rows  # (steps + 1, width), where the equation of motion holds in the step before
    load: Vector  # (n,) N per unit of the signal
    dead_load: Vector  # (n,) N, with the further loads of the step
    dead: Vector  # (n,) N, p_0 itself
    further: Rows  # (k, n) N per unit of each signal; often none
    signals: Rows  # (steps + 1, k), likewise


@part
def push_further(loads, step):
    """Adds the further loads of a step to the dead load."""
    if loads.further.shape[0] > 0:
        for i in range(loads.dead.shape[0]):
            total = loads.dead[i]
            for k in range(loads.further.shape[0]):
                total += loads.further[k, i] * loads.signals[step, k]
            loads.dead_load[i] = total


@dataclass(frozen=True)
class Further:
    """Loads beside that of a term, each with a signal of its own."""

    load: np.ndarray  # (k, n) N per unit of each signal
    signal: np.ndarray  # (k, steps + 1, states)

    def checked(self, n: int, steps: int, states: int) -> Further:
        """As contiguous arrays of these shapes."""
        k, sizes = len(self.load), {"steps + 1": steps + 1, "states": states}
        load = shaped("more.load", self.load, k=k, n=n)
        return Further(load, shaped("more.signal", self.signal, k=k, **sizes))


def batch_width(remaining: int) -> int:
    """How many of the remaining states go side by side in lanes."""
    return next(width for least, width in WIDTHS if remaining >= least)


@dataclass(frozen=True)
class Batch:
    """Where the states of a batch start, and what drives them."""

    term: Term
    scheme: Scheme
    q: np.ndarray  # (n, width) m
    v: np.ndarray  # (n, width) m/s
    h: np.ndarray  # (width,) s
    signal: np.ndarray  # (steps + 1, width)
    at_equilibrium: bool  # does the acceleration start at equilibrium with the forces, or at zero?
    more: Further | None = None  # loads beside the term's

    @property
    def width(self) -> int:
        """States side by side."""
        return self.q.shape[1]

    def part(self, first: int, width: int) -> Batch:
        """`width` of the states, from one of them on; the last state fills up a batch."""
        some = np.minimum(np.arange(first, first + width), self.width - 1)
        return replace(
            self,
            q=np.ascontiguousarray(self.q[:, some]),
            v=np.ascontiguousarray(self.v[:, some]),
            h=self.h[some],
            signal=np.ascontiguousarray(self.signal[:, some]),
            more=self.more and Further(self.more.load, self.more.signal[:, :, some]),
        )

    @cached_property
    def steps(self) -> Steps:
        """The scheme's formulas for its time steps."""
        h = np.array(self.h[None], float)
        return Steps(self.scheme, h, *weights(self.scheme, h))

    @cached_property
    def loads(self) -> Loads:
        """Its loads; a load that is not there is zero."""
        term, none = self.term, np.zeros(self.term.size)
        load, dead = (none if part is None else part for part in (term.load, term.dead_load))
        dead, signals, further = (
            np.array(dead, float),
            self._held(self.signal),
            np.zeros((0, len(none))),
        )
        alone = np.zeros((len(signals), 0))
        if self.more:
            further = np.array(self.more.load, float)
            alone = np.ascontiguousarray(self._held(self.more.signal[:, :, 0].T))
        first = dead + alone[0] @ further
        return Loads(signals, np.array(load, float), first, dead, further, alone)

    def _held(self, signal: np.ndarray) -> np.ndarray:
        """A signal (steps + 1, any) where the equation of motion holds in the step before."""
        held, before = np.array(signal, float), self.scheme.alpha_f
        if before:
            held[1:] = before * held[:-1] + (1.0 - before) * held[1:]
        return held

    def start(self) -> State:
        """Displacements, velocities and accelerations, from the beginning of a cache line on."""
        acceleration = self._acceleration() if self.at_equilibrium else np.zeros_like(self.q)
        state = State(*(room(*self.q.shape) for _ in range(3)))
        for values, start in zip(state, (self.q, self.v, acceleration)):
            values[:] = start
        return state

    @cached_property
    def stepped(self) -> Term:
        """The term as the scheme takes it in a step: with mean forces, or as it is."""
        if not self.scheme.mean:
            return self.term
        return replace(self.term, forces=tuple(one.over_a_step() for one in self.term.forces))

    def internal(self, term: Term, path: np.ndarray, v: np.ndarray) -> np.ndarray:
        """K q + sum f(q, v) (n, width) [N] of contiguous v and path, which is q or, of the mean
        forces of `stepped`, has half the way of the step below it.
        """
        f = np.zeros_like(v)
        if term.stiffness is not None:
            f = np.ascontiguousarray(term.stiffness @ path[: len(v)])
        for force in term.forces:
            force.kernels(self.width)[0](path, v, force.dofs, force.table, f)
        return f

    def _acceleration(self) -> np.ndarray:
        """Solves  M a = p u + p_0 - C v - K q - sum f(q, v)."""
        loads = self.loads
        r = (
            loads.load[:, None] * loads.signal[0]
            + loads.dead_load[:, None]
            - self.internal(self.term, self.q, self.v)
        )
        if self.term.damping is not None:
            r -= self.term.damping @ self.v
        mass, half = self.term.mass, banded.half_bandwidth(self.term.mass)
        try:
            if half > WIDEST_BAND:
                return splu(mass.tocsc()).solve(r)
            return solveh_banded(banded.to_band(mass, half).T, r, lower=True)
        except (LinAlgError, RuntimeError):
            raise SceneError(
                "effects: some node has no mass, so that no acceleration is in equilibrium with "
                "the forces; list inertia, or choose time.initial_acceleration = zero"
            ) from None


def mass_damping(term: Term) -> float:
    """The factor c [1/s] where C = c M, which saves a product: M a + C v = M (a + c v); otherwise
    zero.
    """
    if term.damping is None or not term.mass[0, 0]:
        return 0.0
    rate = term.damping[0, 0] / term.mass[0, 0]
    apart = abs((term.damping - rate * term.mass).data)
    return float(rate) if (apart <= 1e-13 * abs(term.damping).max()).all() else 0.0


def linear_tangent(batch: Batch, half: int, whole: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Bands (k, n, half + 1), or whole ones, of M, C and K, those that are there, and what
    multiplies them in M + gamma h C + beta h^2 K for each state (k, width).
    """
    term, steps = batch.term, batch.steps
    weighted = (
        (term.mass, np.ones_like(steps.h)),
        (term.damping, steps.by_v),
        (term.stiffness, steps.by_q),
    )
    bands = [banded.to_band(part, half, whole) for part, _ in weighted if part is not None]
    return np.stack(bands), np.concatenate([by for part, by in weighted if part is not None])
