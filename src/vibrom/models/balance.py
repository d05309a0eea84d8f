"""The work balance of a motion: what its energy changes by, less the work of the loads, plus what
damping and other forces without a potential take, relative to all energy that was there or went
through.

    B(t) = E(t) - E(0) - sum_k int p_k'v u_k dt + D(t),    dD/dt = v'C v + v'f_d(q, v)
    b = max |B| / (max |E| + int |dD/dt| dt)

It holds for the equations of motion; a time integration breaks it by its own errors. Newmark's
numerical damping takes alpha omega h/(2 zeta) of what the damping zeta takes, and methods of second
order leave about (omega h)^2/12. More is a mistake: of the damping, of a force or its energy, of an
iteration that stopped early.

Of smooth motions the integrals are taken over samples by the trapezoidal rule with its first
correction, int g dt = h (g_0 + g_1)/2 + h^2 (g_0' - g_1')/12 + O(h^4). Loads with signals of their
own may jump, and f_d has corners: there each step counts, by the means of its two ends along the
way between them,

    dq'p_k (u_0 + u_1)/2,    dq'[C (v_0 + v_1) + f_d0 + f_d1]/2,

which is what the trapezoidal rule itself leaves of the energy of a linear body. E is evaluated once
a period.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from vibrom.artefacts.data import variable
from vibrom.artefacts.outcome import Outcome
from vibrom.models.energy import energy, forces
from vibrom.models.model import Drive, Push, Signals
from vibrom.models.recorded import differences
from vibrom.models.samples import BLOCK
from vibrom.term import Force, Term

PARTS = 20  # of a period, between samples: v'C v has twice the frequency of the motion
TOGETHER = 2**17  # numbers that are worked on at once: what a processor has close by
SAMPLES = 60  # of a period, of motions that are known by their displacement


def checked(outcome: np.ndarray, balance: np.ndarray | None, tolerance: float) -> np.ndarray:
    """The outcomes (b,); what ended as asked with a larger b is unbalanced."""
    if balance is None:
        return outcome
    return np.where((outcome == Outcome.OK) & (balance > tolerance), Outcome.UNBALANCED, outcome)


def balance_variable(
    dims: tuple[str, ...] | str, balance: np.ndarray | None
) -> dict[str, xr.Variable]:
    """As answers keep it; nothing where it is not known."""
    if balance is None:
        return {}
    values = balance if dims else balance[0]
    return {"balance": variable(dims, values, "1", "relative error of energy, work and losses")}


def of_motion(
    term: Term,
    rest: np.ndarray,
    period: float,
    drive: Push,
    displacement: Any,
    samples: int = SAMPLES,
) -> float:
    """b of a motion that is only known by its displacement (m, n) [m] from rest, `samples` times a
    `period` [s] from the start on, and may be a variable that is sliced; velocities and
    accelerations are its differences, which have none at the first and last three samples.
    """
    step = np.array([period / samples])
    ledger = Ledger(term, rest, step, samples, drive, first=3)
    count = -(-BLOCK // (8 * len(rest) * ledger.apart)) * ledger.apart
    for first in range(0, len(displacement) - 6, count):
        block = np.asarray(displacement[first : first + count + 6], float)
        parts = [block[3:-3] + rest, *differences(block, step[0])]
        steps = np.arange(first + 3, first + len(block) - 3, ledger.apart)
        ledger.see(steps, slice(0, 1), *(part[:: ledger.apart, :, None] for part in parts))
    return float(ledger.balance()[0])


class Seen(NamedTuple):
    """Samples of a batch of runs."""

    steps: np.ndarray  # (m,) their numbers
    q: np.ndarray  # (m, n, states) m
    v: np.ndarray  # (m, n, states) m/s
    a: np.ndarray  # (m, n, states) m/s^2
    u: np.ndarray  # (m, k, states) signals of the loads

    def after(self, before: Seen | None) -> Seen:
        """With the last sample of those before."""
        if before is None:
            return self
        return Seen(*(np.concatenate([old[-1:], new]) for old, new in zip(before, self)))


@dataclass
class Ledger:
    """Sees b runs while they are integrated (`Observer`), and balances them afterwards."""

    term: Term
    rest: np.ndarray  # (n,) m
    step: np.ndarray  # (b,) s
    per_period: int  # steps in a period
    drive: Push
    first: int = 0  # step of the first sample
    # Of each batch, by the runs in it: what was taken and given from sample to sample [J]
    # (2, m, states),
    _parts: dict[tuple[int, int], list[np.ndarray]] = field(default_factory=dict)
    # displacement and velocity (2, m, n, states) [m, m/s] at whole periods, and the last sample.
    _states: dict[tuple[int, int], list[np.ndarray]] = field(default_factory=dict)
    _last: dict[tuple[int, int], Seen] = field(default_factory=dict)

    @property
    def apart(self) -> int:
        """Steps between samples, a divisor of those of a period."""
        if self._stepwise:
            return 1
        parts = range(min(PARTS, self.per_period), 0, -1)
        return next(self.per_period // k for k in parts if self.per_period % k == 0)

    @cached_property
    def _stepwise(self) -> bool:
        return isinstance(self.drive, Signals) or bool(self._taking)

    @cached_property
    def _taking(self) -> tuple[Force, ...]:
        """f_d."""
        return tuple(force for force in self.term.forces if not force.conservative)

    def see(
        self, steps: np.ndarray, where: slice, q: np.ndarray, v: np.ndarray, a: np.ndarray
    ) -> None:
        """See `Observer.see`."""
        runs, whole = (where.start, where.stop), (steps - self.first) % self.per_period == 0
        self._states.setdefault(runs, []).append(np.stack([q[whole], v[whole]]))
        passed = self._by_steps if self._stepwise else self._by_samples
        u, few = self._signals(steps, where), max(1, TOGETHER // q[0].size)
        for first in range(0, len(steps), few):
            block = (part[first : first + few] for part in (steps, q, v, a, u))
            seen = Seen(*block).after(self._last.get(runs))
            self._last[runs] = Seen(*(part[-1:].copy() for part in seen))
            self._parts.setdefault(runs, []).append(passed(seen, where))

    def _by_samples(self, seen: Seen, where: slice) -> np.ndarray:
        """What is taken and given between them, by the trapezoidal rule with its correction."""
        _, _, v, a, u = seen
        dragged, none = self._dragged(v), np.zeros(v[:, 0].shape)
        taken, rate = _along(v, dragged), 2.0 * _along(a, dragged)
        given, change = none, none
        if isinstance(self.drive, Drive) and self.term.load is not None:
            phase = 2.0 * np.pi * seen.steps[:, None] / self.per_period
            slope = np.cos(phase) * (self.drive.amplitude * self.drive.frequency)[where]
            speed, faster = (np.einsum("n,mnw->mw", self.term.load, x) for x in (v, a))
            given, change = u[:, 0] * speed, slope * speed + u[:, 0] * faster
        h = self.apart * self.step[where]
        value, rates = np.stack([taken, given]), np.stack([rate, change])
        parts = 0.5 * h * (value[:, 1:] + value[:, :-1])
        return parts + h**2 / 12.0 * (rates[:, :-1] - rates[:, 1:])

    def _by_steps(self, seen: Seen, where: slice) -> np.ndarray:
        """What is taken and given in each step."""
        _, q, v, _, u = seen
        way = np.diff(q, axis=0)
        against = self._dragged(v)
        if self._taking:
            flat = (x.transpose(1, 0, 2).reshape(x.shape[1], -1) for x in (q, v))
            found = forces(replace(self.term, forces=self._taking), *flat)
            against = against + found.reshape(v.shape[1], len(v), -1).transpose(1, 0, 2)
        taken = _along(way, 0.5 * (against[1:] + against[:-1]))
        along = np.einsum("kn,mnw->mkw", self._loads, way, optimize=True)
        return np.stack([taken, np.sum(along * 0.5 * (u[1:] + u[:-1]), axis=1)])

    def _dragged(self, v: np.ndarray) -> np.ndarray:
        """C v (m, n, states) [N]."""
        if self.term.damping is None:
            return np.zeros_like(v)
        flat = v.transpose(1, 0, 2).reshape(v.shape[1], -1)
        return (self.term.damping @ flat).reshape(v.shape[1], len(v), -1).transpose(1, 0, 2)

    @cached_property
    def _loads(self) -> np.ndarray:
        """(k, n) [N] per unit of each signal."""
        if isinstance(self.drive, Signals):
            return self.drive.load
        driven = None if self.drive is None else self.term.load
        return np.zeros((0, self.term.size)) if driven is None else driven[None]

    def _signals(self, steps: np.ndarray, where: slice) -> np.ndarray:
        """(m, k, states) of the loads."""
        if isinstance(self.drive, Signals):
            return self.drive.value(self.step[0] * steps)[where].transpose(2, 1, 0)
        if isinstance(self.drive, Drive) and len(self._loads):
            phase = 2.0 * np.pi * steps[:, None, None] / self.per_period
            return np.sin(phase) * self.drive.amplitude[where]
        return np.zeros((len(steps), 0, where.stop - where.start))

    def balance(self) -> np.ndarray:
        """b (b,); NaN where the run has not a whole period."""
        found = np.full(len(self.step), np.nan)
        for runs, seen in self._parts.items():
            parts, states = (np.concatenate(each, axis=1) for each in (seen, self._states[runs]))
            if states.shape[1] > 1:
                found[slice(*runs)] = self._of(parts, states)
        return found

    def _of(self, parts: np.ndarray, states: np.ndarray) -> np.ndarray:
        """b (states,) of a batch."""
        sums = np.cumsum(parts, axis=1)
        every = self.per_period // self.apart
        taken, given = np.pad(sums, ((0, 0), (1, 0), (0, 0)))[:, ::every]
        _, count, n, width = states.shape
        q, v = states.transpose(0, 1, 3, 2).reshape(2, -1, n)
        kept = tuple(force for force in self.term.forces if force.conservative)
        stored = energy(replace(self.term, forces=kept), q - self.rest, v, self.rest)
        stored = stored.reshape(count, width)
        off = np.abs(stored - stored[0] - given[:count] + taken[:count]).max(axis=0)
        through = np.abs(parts[0]).sum(axis=0)
        with np.errstate(invalid="ignore"):  # at rest there is no energy
            return off / (np.abs(stored).max(axis=0) + through)


def _along(way: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Their product (m, states), both (m, n, states)."""
    return np.einsum("mnw,mnw->mw", way, force)
