"""Periodic motions of a body by harmonic balance: a second opinion, without any time steps.

    q = q_0 + sum_w X_w w(tau),   w = 1, cos k tau, sin k tau,   tau = Omega t,   k to the highest
    <Omega^2 M q'' + Omega C q' + K q + sum_i f_i(q, Omega q') - p_0 - p a sin tau>_w = 0

' is the derivative along tau, and <.>_w the harmonics of a function: sums over instants of a
period, more than four to a harmonic, so that those of cubic forces are exact. The waves of a
displacement stand side by side, and the derivative of the equations has a band as wide as the
body's times their number: LAPACK factorises it. Newton's iteration starts at a known motion.

Where half a period and a symmetry S make the second half, displacements are taken in pairs that S
keeps (even harmonics) or turns round (odd ones): half of the waves and of the instants are enough.
Near a fold the frequency is no good parameter: there the phase is held, and the frequency found.

Source: Krack and Gross, Harmonic Balance for Nonlinear Vibration Problems (2019), chapter 2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg.lapack import dgbtrf, dgbtrs
from scipy.sparse import csc_matrix, csr_matrix, identity

from vibrom.solvers.full.tangent import Tangent
from vibrom.solvers.periodic.symmetry import Symmetry
from vibrom.term import Term

ROUNDS, CLOSE = 20, 1e-9  # of Newton's iteration; of the last change to the size of the motion
KEEP = 1e-7  # of it: after such a change the next one takes the same matrix
WIDE = 16  # states side by side


class Unbalanced(ArithmeticError):
    """A motion near which no harmonics balance."""


@dataclass(frozen=True)
class Waves:
    """The harmonics that some displacements have."""

    order: np.ndarray  # (h,) k of each wave
    sine: np.ndarray  # (h,) bool

    @classmethod
    def upto(cls, highest: int, parity: int | None) -> Waves:
        """All; of a parity the even (0) or the odd ones (1)."""
        order = np.arange(highest + 1)
        order = order if parity is None else order[order % 2 == parity]
        above = order[order > 0]
        return cls(np.concatenate([order, above]), np.arange(len(order) + len(above)) >= len(order))

    def at(self, angle: np.ndarray, derivative: int = 0) -> np.ndarray:
        """(m, h) their derivatives at angles (m,)."""
        turned = np.outer(angle, self.order) + 0.5 * np.pi * (derivative - self.sine)
        return self.order**derivative * np.cos(turned)


@dataclass(frozen=True)
class Balance:
    """A motion whose harmonics balance."""

    x: np.ndarray  # (m,)
    frequency: float  # rad/s
    changes: tuple[float, ...]  # of the iteration, to the size of the motion


@dataclass(frozen=True)
class BodyBalance:
    """The equations for the harmonics x (m,) of a body's motion, displacement by displacement."""

    term: Term
    rest: np.ndarray  # (n,) m
    symmetry: Symmetry | None
    harmonics: int  # the highest

    @cached_property
    def _pairs(self) -> csc_matrix:
        """Q (n, n), orthogonal:  q = q_0 + Q y."""
        n = self.term.size
        if self.symmetry is None:
            return identity(n, format="csc")
        own, other = np.arange(n), self.symmetry.order
        alone, half = own == other, np.sqrt(0.5)
        beside = half * np.where(own < other, 1.0, -1.0) * self.symmetry.sign
        values = np.concatenate([np.where(alone, 1.0, half), beside[~alone]])
        rows, columns = np.append(own, other[~alone]), np.append(own, own[~alone])
        return csc_matrix((values, (rows, columns)), (n, n))

    @cached_property
    def _kind(self) -> np.ndarray:
        """(n,) which of `_waves` each y has."""
        if self.symmetry is None:
            return np.zeros(self.term.size, int)
        own, other = np.arange(self.term.size), self.symmetry.order
        return np.where(own == other, self.symmetry.sign < 0.0, own > other).astype(int)

    @cached_property
    def _waves(self) -> tuple[Waves, ...]:
        """By kind."""
        parities = (None,) if self.symmetry is None else (0, 1)
        return tuple(Waves.upto(self.harmonics, parity) for parity in parities)

    @cached_property
    def _angle(self) -> np.ndarray:
        """tau at the instants."""
        count = 4 * self.harmonics + 4
        return 2.0 * np.pi / count * np.arange(count // len(self._waves))

    @cached_property
    def _first(self) -> np.ndarray:
        """(n + 1,) where the harmonics of each y begin in x, and m."""
        count = np.array([len(waves.order) for waves in self._waves])
        return np.append(0, np.cumsum(count[self._kind]))

    def _at(self, x: np.ndarray, angle: np.ndarray, derivative: int = 0) -> np.ndarray:
        """(angles, n) y, or its derivative along tau."""
        y = np.empty((len(angle), self.term.size))
        for kind, waves in enumerate(self._waves):
            chosen = np.flatnonzero(self._kind == kind)
            places = self._first[chosen, None] + np.arange(len(waves.order))
            y[:, chosen] = waves.at(angle, derivative) @ x[places].T
        return y

    def path(self, x: np.ndarray, samples: int) -> np.ndarray:
        """Displacements from rest (samples, n) [m] over a whole period."""
        angle = 2.0 * np.pi * np.arange(samples) / samples
        return self._at(x, angle) @ self._pairs.T

    def of_path(self, path: np.ndarray) -> np.ndarray:
        """x (m,) of displacements from rest (samples, n) [m] over a whole period."""
        return self._harmonics(path @ self._pairs, 2.0 * np.pi * np.arange(len(path)) / len(path))

    def _harmonics(self, y: np.ndarray, angle: np.ndarray) -> np.ndarray:
        """(m,) <y>_w of samples (angles, n)."""
        x = np.empty(self._first[-1])
        for kind, waves in enumerate(self._waves):
            chosen = np.flatnonzero(self._kind == kind)
            places = self._first[chosen, None] + np.arange(len(waves.order))
            x[places] = (_to_harmonics(waves.at(angle)) @ y[:, chosen]).T
        return x

    def solve(
        self, path: np.ndarray, frequency: float, amplitude: float, hold: bool = False
    ) -> Balance:
        """The motion near displacements from rest (samples, n) [m] over a period, at this frequency
        [rad/s] or, with its phase held, at a frequency nearby. Raises Unbalanced.
        """
        x, changes, solve = self.of_path(path), [], None
        size, row = np.linalg.norm(x), self._phase(x)
        for _ in range(ROUNDS):
            if solve is None or changes[-1] > KEEP:
                solve = self._factor(x, frequency)
            change = solve(-self.residual(x, frequency, amplitude))
            shift = 0.0
            if hold:
                along = solve(-self._by_frequency(x, frequency))
                shift = -float(row @ (x + change) / (row @ along))
                change = change + shift * along
            x, frequency = x + change, frequency + shift
            changes.append(float(np.linalg.norm(change) / size))
            if not changes[-1] < 1.0:
                break
            if changes[-1] <= CLOSE:
                return Balance(x, frequency, tuple(changes))
        raise Unbalanced(f"changes of {', '.join(f'{change:.2g}' for change in changes)}")

    def change(self, path: np.ndarray, frequency: float, amplitude: float) -> float:
        """What Newton's first step from displacements from rest (samples, n) [m] over a period
        changes, to the motion's size. Raises Unbalanced.
        """
        x = self.of_path(path)
        step = self._factor(x, frequency)(-self.residual(x, frequency, amplitude))
        return float(np.linalg.norm(step) / np.linalg.norm(x))

    def _phase(self, x: np.ndarray) -> np.ndarray:
        """(m,) a row whose product with x is zero: the angle of the first harmonic of p'q."""
        load, row = self.term.load @ self._pairs, np.zeros((2, len(x)))
        for kind, waves in enumerate(self._waves):
            chosen = np.flatnonzero(self._kind == kind)
            for wave in np.flatnonzero(waves.order == 1):
                row[int(waves.sine[wave]), self._first[chosen] + wave] = load[chosen]
        cosine, sine = row @ x
        return (cosine * row[1] - sine * row[0]) / np.hypot(cosine, sine)

    def residual(self, x: np.ndarray, frequency: float, amplitude: float) -> np.ndarray:
        """(m,) [N] of the equations."""
        term, angle = self.term, self._angle
        q, v, a = (
            frequency**times * self._at(x, angle, times) @ self._pairs.T for times in range(3)
        )
        q += self.rest
        force = (term.mass @ a.T).T - amplitude * np.outer(np.sin(angle), term.load)
        for part, state in ((term.damping, v), (term.stiffness, q)):
            force += 0.0 if part is None else (part @ state.T).T
        force += _forces(term, q, v) - (0.0 if term.dead_load is None else term.dead_load)
        return self._harmonics(force @ self._pairs, angle)

    def _by_frequency(self, x: np.ndarray, frequency: float) -> np.ndarray:
        """(m,) of the residual."""
        angle = self._angle
        q, v, a = (self._at(x, angle, times) @ self._pairs.T for times in range(3))
        drag = Tangent(self.term, 0.0, 1.0, 0.0)
        force = 2.0 * frequency * (self.term.mass @ a.T).T
        for place, (here, rate) in enumerate(zip(q + self.rest, v)):
            force[place] += drag.at(here[:, None].copy(), frequency * rate[:, None]) @ rate
        return self._harmonics(force @ self._pairs, angle)

    @cached_property
    def _pattern(self) -> tuple[np.ndarray, np.ndarray, csr_matrix]:
        """Rows (e,) and columns (e,) of the entries of Q'AQ, and G (e, d): its entries are G times
        those of A, a matrix of the body.
        """
        n = self.term.size
        at = Tangent(self.term, 0.0, 0.0, 0.0).at(*np.zeros((2, n, 1)))
        row, column = at.indices, np.repeat(np.arange(n), np.diff(at.indptr))
        pairs = self._pairs.tocsr()
        keys, entries, shares = [], [], []
        for one, other in np.ndindex(2, 2):
            left, right = (
                np.where(pairs.indptr[where] + part < pairs.indptr[where + 1], part, -1)
                for where, part in ((row, one), (column, other))
            )
            chosen = np.flatnonzero((left >= 0) & (right >= 0))
            left, right = pairs.indptr[row[chosen]] + one, pairs.indptr[column[chosen]] + other
            keys.append(pairs.indices[left].astype(np.int64) * n + pairs.indices[right])
            entries.append(chosen)
            shares.append(pairs.data[left] * pairs.data[right])
        known, place = np.unique(np.concatenate(keys), return_inverse=True)
        made = (np.concatenate(shares), (place, np.concatenate(entries)))
        return known // n, known % n, csr_matrix(made, (len(known), at.nnz))

    def _tangents(self, x: np.ndarray, frequency: float) -> list[np.ndarray]:
        """(e, instants) of K + df/dq, Omega (C + df/dv) and Omega^2 M, entry by entry."""
        q, v = (self._at(x, self._angle, times) @ self._pairs.T for times in range(2))
        states = [(a[:, None].copy(), frequency * b[:, None]) for a, b in zip(q + self.rest, v)]
        scales = np.diag([1.0, frequency, frequency**2])
        tangents = (Tangent(self.term, *scale[::-1]) for scale in scales)
        made = self._pattern[2]
        return [made @ np.stack([one.at(*at).data for at in states], 1) for one in tangents]

    def _factor(self, x: np.ndarray, frequency: float) -> Callable[[np.ndarray], np.ndarray]:
        """What solves with the derivative of the residual along x."""
        row, column, value = self._derivative(x, frequency)
        half, size = int(np.abs(row - column).max()), int(self._first[-1])
        band = np.zeros((3 * half + 1, size), order="F")
        band[2 * half + row - column, column] = value
        factor, pivots, info = dgbtrf(band, half, half, overwrite_ab=True)
        if info:
            raise Unbalanced("the equations are singular")
        return lambda right: dgbtrs(factor, half, half, right, pivots)[0]

    def _derivative(
        self, x: np.ndarray, frequency: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rows, columns and values of the residual's, along x."""
        (rows, columns, _), values = self._pattern, self._tangents(x, frequency)
        blocks = []
        for one, left in enumerate(self._waves):
            to_harmonics = _to_harmonics(left.at(self._angle))
            for other, right in enumerate(self._waves):
                chosen = np.flatnonzero((self._kind[rows] == one) & (self._kind[columns] == other))
                total = 0.0
                for times in range(3):
                    waves = right.at(self._angle, times)
                    each = np.einsum("at,tb->abt", to_harmonics, waves)
                    total = total + each.reshape(-1, len(self._angle)) @ values[times][chosen].T
                shape = len(left.order), len(right.order)
                place = np.indices(shape).reshape(2, -1, 1)
                row = self._first[rows[chosen]] + place[0]
                column = self._first[columns[chosen]] + place[1]
                blocks.append((row.ravel(), column.ravel(), np.ravel(total)))
        row, column, value = (np.concatenate(part) for part in zip(*blocks))
        return row, column, value


def _to_harmonics(waves: np.ndarray) -> np.ndarray:
    """(h, m) <.>_w of samples (m,), of waves (m, h) at them."""
    return (waves / np.sum(waves**2, axis=0)).T


def _forces(term: Term, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """(m, n) [N] sum of f_i at states (m, n)."""
    found = np.empty_like(q)
    for first in range(0, len(q), WIDE):
        chosen = np.minimum(np.arange(first, first + WIDE), len(q) - 1)
        here, rate = (np.ascontiguousarray(part[chosen].T) for part in (q, v))
        total = np.zeros_like(here)
        for force in term.forces:
            force.kernels(WIDE)[0](here, rate, force.dofs, force.table, total)
        found[first : first + WIDE] = total.T[: len(q) - first]
    return found
