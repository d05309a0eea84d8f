"""The work balance of a motion: what its energy changes by, less the work of the load, plus what
damping takes, relative to all energy that was there or went through.

    B(t) = E(t) - E(0) - int p'v u dt + int v'C v dt,    b = max |B| / (max |E| + int v'C v dt)

It holds for the equations of motion; a time integration breaks it by its own errors. Newmark's
numerical damping takes alpha omega h/(2 zeta) of what the damping zeta takes, and methods of second
order leave about (omega h)^2/12. More is a mistake: of the damping, of a force or its energy, of an
iteration that stopped early. Nothing is said of forces without a potential.

The integrals are taken over samples by the trapezoidal rule with its first correction,
int g dt = h (g_0 + g_1)/2 + h^2 (g_0' - g_1')/12 + O(h^4); E is evaluated once a period.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import xarray as xr

from vibrom.artefacts.data import variable
from vibrom.artefacts.outcome import Outcome
from vibrom.models.energy import energy
from vibrom.models.model import Drive
from vibrom.models.recorded import differences
from vibrom.term import Term

PARTS = 20  # of a period, between samples: v'C v has twice the frequency of the motion
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
    term: Term, rest: np.ndarray, period: float, drive: Drive | None, displacement: np.ndarray
) -> float:
    """b of a motion that is only known by its displacement (m, n) [m] from rest, SAMPLES times a
    `period` [s] from the start on; velocities and accelerations are its differences, which have
    none at the first and last three samples.
    """
    step = np.array([period / SAMPLES])
    ledger = Ledger(term, rest, step, SAMPLES, drive, first=3)
    parts = [displacement[3:-3] + rest, *differences(displacement, step[0])]
    steps = np.arange(3, len(displacement) - 3, ledger.apart)
    ledger.see(steps, slice(0, 1), *(part[:: ledger.apart, :, None] for part in parts))
    return float(ledger.balance()[0])


@dataclass
class Ledger:
    """Sees b runs while they are integrated (`Observer`), and balances them afterwards."""

    term: Term
    rest: np.ndarray  # (n,) m
    step: np.ndarray  # (b,) s
    per_period: int  # steps in a period
    drive: Drive | None
    first: int = 0  # step of the first sample
    # Of each batch, by the runs in it: v'C v and p'v u [W] and their rates [W/s] (4, m, states),
    _powers: dict[tuple[int, int], list[np.ndarray]] = field(default_factory=dict)
    # and displacement and velocity (2, m, n, states) [m, m/s] at whole periods.
    _states: dict[tuple[int, int], list[np.ndarray]] = field(default_factory=dict)

    @property
    def apart(self) -> int:
        """Steps between samples, a divisor of those of a period."""
        parts = range(min(PARTS, self.per_period), 0, -1)
        return next(self.per_period // k for k in parts if self.per_period % k == 0)

    def see(
        self, steps: np.ndarray, where: slice, q: np.ndarray, v: np.ndarray, a: np.ndarray
    ) -> None:
        """See `Observer.see`."""
        runs, whole = (where.start, where.stop), (steps - self.first) % self.per_period == 0
        powers = [*self._taken(v, a), *self._given(steps, where, v, a)]
        self._powers.setdefault(runs, []).append(np.stack(powers))
        self._states.setdefault(runs, []).append(np.stack([q[whole], v[whole]]))

    def _taken(self, v: np.ndarray, a: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """v'C v, and what it changes by."""
        if self.term.damping is None:
            none = np.zeros((len(v), v.shape[2]))
            return none, none
        flat = v.transpose(1, 0, 2).reshape(v.shape[1], -1)
        dragged = (self.term.damping @ flat).reshape(v.shape[1], len(v), -1)
        power, change = (np.einsum("mnw,nmw->mw", x, dragged) for x in (v, a))
        return power, 2.0 * change

    def _given(
        self, steps: np.ndarray, where: slice, v: np.ndarray, a: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """p'v u, and what it changes by."""
        if self.drive is None or self.term.load is None:
            none = np.zeros((len(v), v.shape[2]))
            return none, none
        phase = 2.0 * np.pi * steps[:, None] / self.per_period
        u = np.sin(phase) * self.drive.amplitude[where]
        rate = np.cos(phase) * self.drive.amplitude[where] * self.drive.frequency[where]
        speed, change = (np.einsum("n,mnw->mw", self.term.load, x) for x in (v, a))
        return u * speed, rate * speed + u * change

    def balance(self) -> np.ndarray:
        """b (b,); NaN where a force has no potential, or the run has not a whole period."""
        found = np.full(len(self.step), np.nan)
        if not all(force.conservative for force in self.term.forces):
            return found
        for runs, seen in self._powers.items():
            powers, states = (
                np.concatenate(seen, axis=1),
                np.concatenate(self._states[runs], axis=1),
            )
            if states.shape[1] > 1:
                found[slice(*runs)] = self._of(powers, states, self.step[slice(*runs)])
        return found

    def _of(self, powers: np.ndarray, states: np.ndarray, step: np.ndarray) -> np.ndarray:
        """b (states,) of a batch."""
        h, value, rate = self.apart * step, powers[[0, 2]], powers[[1, 3]]
        parts = 0.5 * h * (value[:, 1:] + value[:, :-1])
        parts += h**2 / 12.0 * (rate[:, :-1] - rate[:, 1:])
        sums = np.cumsum(parts, axis=1)
        every = self.per_period // self.apart
        taken, given = np.pad(sums, ((0, 0), (1, 0), (0, 0)))[:, ::every]
        _, count, n, width = states.shape
        q, v = states.transpose(0, 1, 3, 2).reshape(2, -1, n)
        stored = energy(self.term, q - self.rest, v, self.rest).reshape(count, width)
        off = np.abs(stored - stored[0] - given[:count] + taken[:count]).max(axis=0)
        with np.errstate(invalid="ignore"):  # at rest there is no energy
            return off / (np.abs(stored).max(axis=0) + taken[-1])
