"""Periodic motions of the undamped body, followed in their action.

    M w^2 q'' + K q + f(q_0 + q) - f(q_0) = 0,    q(t) = q(-t) = q(t + 2 pi)
    w / (2 pi) int q' M q' dt = 2 w_0 X

q = B y(t), with as few directions B as the power series of a manifold span: they still describe
the motion where the series themselves have ceased to converge. It is solved for the values at H + 1
instants of half a period, H harmonics in all, and for w, by Newton's method; every X begins where
the five before it point. Harmonics that meet a higher frequency of the body end the family, or are
passed where H leaves them out. Weak damping lets the motions decay through the family,

    X' = 2 Re g X,    Re g = -1/2 int q' C q' dt / int q' M q' dt.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vibrom.solvers.full.static import Body
from vibrom.solvers.manifold.monomials import Monomials
from vibrom.solvers.manifold.parametrisation import Manifold
from vibrom.term import Term

KNOWN = 5  # orbits that the next one is extrapolated from
ITERATIONS, CLOSE = 8, 1e-9  # steps, and the last of them, relative


@dataclass(frozen=True)
class Orbits:
    """A family, by ascending action."""

    action: np.ndarray  # X (m,)
    rate: np.ndarray  # g (m,) complex: z' = g z
    values: np.ndarray  # y (m, 2H + 1, k) at equal angles

    def within(self, action: float) -> Orbits:
        """Those up to this action."""
        near = self.action <= action
        return Orbits(self.action[near], self.rate[near], self.values[near])

    def joined(self, other: Orbits) -> Orbits:
        """This one, then the other."""
        mine, others = ((one.action, one.rate, one.values) for one in (self, other))
        return Orbits(*(np.concatenate(part) for part in zip(mine, others)))


def turning(count: int) -> np.ndarray:
    """(count, count) d/dt of a trigonometric polynomial from its values at `count` equal angles."""
    waves = np.fft.fft(np.eye(count), axis=0)
    return np.fft.ifft(1j * np.fft.fftfreq(count, 1.0 / count)[:, None] * waves, axis=0).real


class Family:
    """The equations of a body in the directions B (n, k)."""

    def __init__(self, term: Term, rest: np.ndarray, basis: np.ndarray, harmonics: int):
        self.body, self.rest, self.basis = Body(term), np.array(rest), basis
        self.held = self.body.internal(self.rest)
        self.mass = basis.T @ (term.mass @ basis)
        empty = np.zeros_like(self.mass)
        self.damping = empty if term.damping is None else basis.T @ (term.damping @ basis)
        count, half = 2 * harmonics + 1, harmonics + 1
        # An even motion from its values in half a period.
        self.whole = np.eye(half)[np.minimum(np.arange(count), (-np.arange(count)) % count)]
        self.first = turning(count) @ self.whole  # q' of all instants
        self.second = (turning(count) @ turning(count))[:half] @ self.whole
        self.weight = self.first.T @ self.first / count  # of the mean of q' q'

    def solved(self, y: np.ndarray, w: float, momentum: float) -> tuple[np.ndarray, float] | None:
        """The motion y (H + 1, k) and its frequency with the action integral `momentum`, from a
        guess; None where the iteration does not converge.
        """
        half, k = y.shape
        scale = np.abs(y).max()
        for _ in range(ITERATIONS):
            swing = self.weight @ y @ self.mass
            r = w * w * self.second @ y @ self.mass
            jacobian = np.zeros((half * k + 1, half * k + 1))
            jacobian[:-1, :-1] = np.kron(w * w * self.second, self.mass)
            for i, state in enumerate(self.rest + y @ self.basis.T):
                r[i] += self.basis.T @ (self.body.internal(state) - self.held)
                here = slice(i * k, (i + 1) * k)
                tangent = self.body.tangent(state) @ self.basis
                jacobian[here, here] += self.basis.T @ tangent
            jacobian[:-1, -1] = (2.0 * w * self.second @ y @ self.mass).ravel()
            jacobian[-1, :-1] = 2.0 * w * swing.ravel()
            jacobian[-1, -1] = np.sum(swing * y)
            step = np.linalg.solve(
                jacobian, np.append(-r.ravel(), momentum - w * np.sum(swing * y))
            )
            y, w = y + step[:-1].reshape(half, k), w + float(step[-1])
            if not np.isfinite(step).all() or np.abs(step[:-1]).max() > scale:
                return None
            if np.abs(step[:-1]).max() < CLOSE * scale:
                return y, w
        return None

    def rate(self, y: np.ndarray, w: float) -> complex:
        """g of a motion (H + 1, k)."""
        swing = self.weight @ y
        real = -0.5 * np.sum(swing @ self.damping * y) / np.sum(swing @ self.mass * y)
        return complex(real, np.sqrt(w * w - real * real))


def follow(family: Family, begun: Orbits, step: float, last: float) -> Orbits:
    """The motions beyond those of `begun`, by steps of the root of X as far as `last`, or as far as
    they can be followed.
    """
    half = len(family.second)
    even = 0.5 * (
        begun.values[:, :half] + begun.values[:, (-np.arange(half)) % begun.values.shape[1]]
    )
    root, shapes, frequency = list(np.sqrt(begun.action)), list(even), list(np.abs(begun.rate))
    momentum = frequency[-1] * np.sum(family.weight @ shapes[-1] @ family.mass * shapes[-1])
    unit = momentum / begun.action[-1]  # 2 w_0
    while root[-1] + step <= last:
        here, known = root[-1] + step, np.array(root[-KNOWN:])
        others = ~np.eye(KNOWN, dtype=bool)
        share = [
            np.prod((here - known[each]) / (own - known[each])) for own, each in zip(known, others)
        ]
        found = family.solved(
            np.tensordot(share, np.array(shapes[-KNOWN:]), 1),
            float(np.dot(share, frequency[-KNOWN:])),
            unit * here**2,
        )
        if found is None:
            break
        root.append(here)
        shapes.append(found[0])
        frequency.append(found[1])
    new = slice(len(begun.action), None)
    rate = [family.rate(y, w) for y, w in zip(shapes[new], frequency[new])]
    values = np.array([family.whole @ y for y in shapes[new]])
    return Orbits(
        np.square(root[new]),
        np.array(rate, complex),
        values.reshape(-1, *begun.values.shape[1:]),
    )


def fitted(manifold: Manifold, basis: np.ndarray, orbits: Orbits, order: int) -> Manifold:
    """The manifold of one pair whose polynomials of this order are the nearest to these motions,
    relative to their size, instead of the series at rest.
    """
    monomials, count = Monomials(order, manifold.masters.mirror), orbits.values.shape[1]
    top = orbits.action[-1]
    x, weight = orbits.action / top, np.sqrt(top / orbits.action)
    harmonic = monomials.powers[:, 0] - monomials.powers[:, 1]
    exponent = 0.5 * monomials.degrees
    waves = np.fft.fft(orbits.values, axis=1) / count
    shape, speed = (np.zeros((len(monomials), basis.shape[1]), complex) for _ in range(2))
    for h in range(min(monomials.order, count // 2) + 1):
        (members,) = np.nonzero(harmonic == h)
        powers = x[:, None] ** exponent[members]
        found = _nearest(powers, waves[:, h], weight)
        along = 1j * h * orbits.rate.imag[:, None] * powers
        along += 2.0 * orbits.rate.real[:, None] * exponent[members] * powers
        for series, values in ((shape, found), (speed, _nearest(powers, along @ found, weight))):
            series[members] = values / top ** exponent[members][:, None]
            series[monomials.conjugate[members]] = series[members].conj()
    dynamics = np.zeros((2, len(monomials)), complex)
    (members,) = np.nonzero(harmonic == 1)
    powers = x[:, None] ** (exponent[members] - 0.5)
    rate = [
        _nearest(powers, part[:, None], 1.0 + 0.0 * x)[:, 0]
        for part in (orbits.rate.real, orbits.rate.imag)
    ]
    dynamics[0, members] = (rate[0] + 1j * rate[1]) / top ** (exponent[members] - 0.5)
    dynamics[1, monomials.conjugate[members]] = dynamics[0, members].conj()
    return replace(
        manifold,
        monomials=monomials,
        displacement=shape @ basis.T,
        velocity=speed @ basis.T,
        dynamics=dynamics,
    )


def _nearest(powers: np.ndarray, values: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Coefficients (l, k) of least weighted squares of powers (m, l) to values (m, k)."""
    return np.linalg.lstsq(powers * weight[:, None], values * weight[:, None], rcond=None)[0]
