"""How well a reduced model obeys the equations of motion, before any truth is seen.

    r = M a + C v + K q + f(q_0 + q, v) - f(q_0, 0),    e = |A^-1 r| / max |q|

with q, v and a of the model's own motion through a reduced state: the derivatives of q(z(t)) along
dz/dt = drift(z). A is the stiffness of the deformed body, without what its stresses add, and
omega^2 M, omega the model's frequency: e is the displacement that would balance the residual in a
vibration, relative to the largest one. It is evaluated on the ellipses that small
motions follow, where one reduced oscillator moves: z = amplitude (Z cos t, -Z' sin t), Z and Z' the
model's reach. Any model whose scene has operators can be measured so.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vibrom.models.rom import Rom
from vibrom.solvers.full.material import Material
from vibrom.solvers.full.modes import linearised
from vibrom.term import Term

STEP = 3e-3  # of the model's time scale: of differences in time
PHASES = 8
FINEST = 1.05  # ratio of amplitudes at which the search for the trusted one ends


class Residual:
    """The equations of motion of a term, about its rest state."""

    def __init__(self, term: Term):
        self.term = term
        self.rest, _ = linearised(term)
        self.held = self._forces(self.rest[None], np.zeros((1, term.size)))
        self._material = Material(term)

    def _forces(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Of states (m, n), one after the other."""
        f = np.zeros((*q.shape, 1))
        for one, rate, total in zip(q, v, f):
            state = one[:, None].copy(), rate[:, None].copy()
            for force in self.term.forces:
                force.kernels(1)[0](*state, force.dofs, force.table, total)
        return f[:, :, 0]

    def __call__(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """The residuals r (m, n) [N] of displacements from rest and their derivatives (m, n)."""
        total = (self.term.mass @ a.T).T + self._forces(self.rest + q, v) - self.held
        for part, motion in ((self.term.damping, v), (self.term.stiffness, q)):
            total = total if part is None else total + (part @ motion.T).T
        return total

    def balance(self, q: np.ndarray, r: np.ndarray, omega: float) -> np.ndarray:
        """A^-1 r (m, n) [m]."""
        return self._material.solve(self.rest + q, r, omega**2)


def ellipse(reach: np.ndarray, oscillator: int, amplitude: float) -> np.ndarray:
    """States (PHASES, 2d) on the ellipse of one oscillator."""
    d = len(reach) // 2
    # Not at 0 and 90 degrees, where a symmetric body has neither the even nor the odd part.
    angle = 2 * np.pi * (np.arange(PHASES) + 0.25) / PHASES
    z = np.zeros((PHASES, 2 * d))
    z[:, oscillator] = amplitude * reach[oscillator] * np.cos(angle)
    z[:, d + oscillator] = -amplitude * reach[d + oscillator] * np.sin(angle)
    return z


def motion(rom: Rom, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """q, v and a (m, n) of the model's own motion through z (m, 2d), by differences in time."""
    d = len(rom.reach) // 2
    step = STEP * float(np.min(rom.reach[:d] / rom.reach[d:]))
    forward, backward = [z], [z]
    for _ in range(2):
        forward.append(runge_kutta(rom, forward[-1], step))
        backward.append(runge_kutta(rom, backward[-1], -step))
    two_back, back, here, ahead, two_ahead = (
        rom.displacement(part) for part in (*backward[:0:-1], *forward)
    )
    v = (8.0 * (ahead - back) - (two_ahead - two_back)) / (12.0 * step)
    a = (16.0 * (ahead + back) - (two_ahead + two_back) - 30.0 * here) / (12.0 * step**2)
    return here, v, a


def runge_kutta(rom: Rom, z: np.ndarray, h: float) -> np.ndarray:
    """One step of the classical method, of the undriven model."""
    k1 = rom.drift(z)
    k2 = rom.drift(z + 0.5 * h * k1)
    k3 = rom.drift(z + 0.5 * h * k2)
    k4 = rom.drift(z + h * k3)
    return z + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)


def equation_error(
    residual: Residual, rom: Rom, z: np.ndarray, enough: float = float("inf")
) -> float:
    """e, the largest over the states z (m, 2d) of one ellipse; infinite where a state is. That of
    one state, where it is more than `enough`.
    """
    d = len(rom.reach) // 2
    omega = float(np.max(rom.reach[d:] / rom.reach[:d]))
    with np.errstate(all="ignore"):
        q, v, a = motion(rom, z)
        if not np.isfinite([q, v, a]).all():
            return float("inf")
        r, largest, found = residual(q, v, a), np.linalg.norm(q, axis=1).max(), 0.0
        order = np.argsort(-np.linalg.norm(r, axis=1))
        for some in (order[:1], order[1:]):
            balance = np.linalg.norm(residual.balance(q[some], r[some], omega), axis=1)
            found = float(np.max(balance / largest, initial=found))
            if not found <= enough:
                break
    return found


def trusted(
    error: Callable[[float], float], tolerance: float, largest: float, least: float = 0.0
) -> float:
    """The amplitude, at most `largest`, up to which `error` stays within the tolerance, to five
    percent; zero where that is not beyond `least`. The error is taken to grow with the amplitude.
    """
    if least and error(FINEST * least) > tolerance:
        return 0.0
    low, high, amplitude = least, largest, largest
    for _ in range(60):
        if error(amplitude) <= tolerance:
            low = amplitude
        else:
            high = amplitude
        if low and high <= FINEST * low:
            break
        amplitude = float(np.sqrt(low * high)) if low else 0.5 * high
    return low


def trust_curve(
    residual: Residual, rom: Rom, amplitudes: tuple[float, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """Largest displacement [m] and e of the first oscillator at these multiples of the reach."""
    states = [ellipse(rom.reach, 0, amplitude) for amplitude in amplitudes]
    with np.errstate(all="ignore"):
        largest = [np.abs(rom.displacement(z)).max() for z in states]
    return np.array(largest), np.array([equation_error(residual, rom, z) for z in states])
