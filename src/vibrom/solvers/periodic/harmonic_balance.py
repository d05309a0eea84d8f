"""Periodic motions of a reduced model by harmonic balance, in turns in frequency and in time.

    z = Z (c_0 + sum_k c_k cos k tau + s_k sin k tau),   tau = Omega t,   k = 1 to the highest
    Omega dz/dtau = drift(z) + force(z) a sin tau,   for each of these harmonics of it

The unknowns x are the coefficients, Z is the training range. What is right of the equation is
evaluated at instants of a period, and its harmonics are sums over them: more instants than four to
a harmonic, so that those of a cubic are exact. Nothing is integrated in time: a second opinion of
motions by shooting (`flow_map`), with another error, which falls with the number of harmonics. How
large it is, a period in time says that begins where such a motion does, and that has its Floquet
multipliers, too.

Source: Krack and Gross, Harmonic Balance for Nonlinear Vibration Problems (2019), chapter 2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vibrom.solvers.periodic.flow_map import KEPT, NUDGE, FlowMap
from vibrom.solvers.periodic.maps import Return, Swing


@dataclass(frozen=True)
class Balanced(Return):
    """What harmonic balance leaves of a motion: `end` is x and the residual."""

    start: np.ndarray | None = None  # (r,) where the motion begins, in units of the range
    period: Callable[[], Return] | None = None  # its map over a period in time

    @cached_property
    def _return(self) -> Return:
        return self.period()

    @property
    def multipliers(self) -> np.ndarray:
        """Of a period in time (r,)."""
        return np.full(len(self.start), np.nan) if not self.ok else self._return.multipliers

    @property
    def open(self) -> float:
        """How far that period ends from where it begins, in units of the range."""
        return float(np.abs(self._return.end - self.start).max()) if self.ok else float("nan")


@dataclass(frozen=True)
class HarmonicBalance:
    """The equations for x of size (2 h + 1) r."""

    flow: FlowMap
    harmonics: int  # h, the highest
    parts: int = 1
    free: bool = True

    @property
    def size(self) -> int:
        """Of x."""
        return (2 * self.harmonics + 1) * self.flow.size

    @property
    def whole(self) -> HarmonicBalance:
        """Itself: a sum of harmonics is a whole period."""
        return self

    def _waves(self, count: int) -> np.ndarray:
        """(count, 2 h + 1): one, the cosines, the sines at so many instants of a period."""
        angle = np.outer(2.0 * np.pi * np.arange(count) / count, np.arange(1, self.harmonics + 1))
        return np.hstack([np.ones((count, 1)), np.cos(angle), np.sin(angle)])

    @cached_property
    def _to_time(self) -> np.ndarray:
        """(instants, 2 h + 1)."""
        return self._waves(4 * self.harmonics + 4)

    @cached_property
    def _to_harmonics(self) -> np.ndarray:
        """(2 h + 1, instants)."""
        waves = self._to_time
        return (waves / np.sum(waves**2, axis=0)).T

    @cached_property
    def _rates(self) -> np.ndarray:
        """(2 h + 1, 2 h + 1) d/dtau: (k cos k tau)  of sin k tau, (-k sin k tau) of cos k tau."""
        h = self.harmonics
        found, one, each = np.zeros((2 * h + 1, 2 * h + 1)), np.arange(1, h + 1), np.arange(h)
        found[1 + each, 1 + h + each], found[1 + h + each, 1 + each] = one, -one
        return found

    def __call__(
        self,
        x: np.ndarray,
        frequency: float,
        amplitude: float,
        derivative: bool = True,
        phase: bool = False,
    ) -> Return:
        """x and the residual, over a scale of the frequency; the phase is not asked for."""
        flow, signal = self.flow, self._to_time[:, 1 + self.harmonics]
        x, scale = x.reshape(-1, flow.size), 1.0 / flow.frequency
        y = self._to_time @ x
        turned = scale * self._rates @ x
        with np.errstate(all="ignore"):
            push = scale * flow.force(y * flow.reach) / flow.reach
            rate = scale * flow.drift(y * flow.reach) / flow.reach
        residual = frequency * turned - self._to_harmonics @ (
            rate + amplitude * signal[:, None] * push
        )
        end, start = (x + residual).ravel(), x[: 1 + self.harmonics].sum(axis=0)
        if not np.isfinite(end).all():
            return Balanced(end, ok=False, start=start)
        if not derivative:
            return Balanced(end, ok=True)
        by_start = np.eye(self.size) + self._slope(y, frequency, amplitude * signal)
        return Balanced(
            end,
            True,
            by_start=by_start,
            by_frequency=turned.ravel(),
            by_amplitude=-(self._to_harmonics @ (signal[:, None] * push)).ravel(),
            start=start,
            period=lambda: flow.whole(start, frequency, amplitude),
        )

    def _slope(self, y: np.ndarray, frequency: float, signal: np.ndarray) -> np.ndarray:
        """Of the residual along x, by central differences of what is right at each instant."""
        flow, r = self.flow, self.flow.size
        nudged = y + NUDGE * np.stack([np.eye(r), -np.eye(r)])[:, :, None]  # (2, r, instants, r)
        z = (nudged * flow.reach).reshape(-1, r)
        right = flow.drift(z) + np.tile(signal, 2 * r)[:, None] * flow.force(z)
        ahead, behind = right.reshape(nudged.shape) / flow.reach / flow.frequency
        local = (ahead - behind) / (2.0 * NUDGE)  # (along, instants, of)
        found = np.einsum(
            "hm,jmi,mk->hikj", self._to_harmonics, local, self._to_time, optimize=True
        )
        turned = frequency / flow.frequency * np.kron(self._rates, np.eye(r))
        return turned - found.reshape(self.size, self.size)

    def swings(self, x: np.ndarray, frequency: np.ndarray, amplitude: np.ndarray) -> list[Swing]:
        """See `maps.Equation`."""
        return self.flow.shown(self._waves(KEPT) @ x.reshape(len(x), -1, self.flow.size), amplitude)

    def of_point(self, x: np.ndarray, frequency: float, amplitude: float) -> np.ndarray:
        """The unknowns of the motion that begins at a point x (r,) of the flow."""
        waves, path = self._waves(KEPT), self.flow.path(x, frequency, amplitude)
        return ((waves / np.sum(waves**2, axis=0)).T @ path).ravel()
