"""The manifold of the equations, with dynamics corrected by a recorded motion.

    z' = z [g(x) + sum_k c_k x^k],    x = |z|^2

g is the model's that it starts from, in one complex coordinate. The c_k, few complex numbers, come
from the encoded motion by least squares of the logarithm, whose error does not grow with the
amplitude and needs no derivative:

    ln z(t) - int g(x) dt = c + sum_k c_k int x^k dt.

What differs between the equations and the motion goes there: unmodelled damping of a measured
structure, or of a simulated one the numerical damping and the shift of frequency of its time steps.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.signal import convolve2d

from vibrom.config.kinds import Whole
from vibrom.latent.manifold_rom import ManifoldRom
from vibrom.latent.polynomial import least_squares
from vibrom.models.method import Method
from vibrom.models.samples import Samples
from vibrom.models.training import MethodError, Training

SMALL = 1e-6  # of the range: where the linear part is taken


@dataclass(frozen=True)
class EquationsCorrected(Method):
    """See the module."""

    order: Whole = 1  # highest power of x in the correction

    def fit(self, training: Training) -> ManifoldRom:
        """See Method."""
        start = training.start
        if not (isinstance(start, ManifoldRom) and len(start.reach) == 2):
            raise MethodError(
                "equations_corrected starts from a model of one mode from the equations, and was "
                f"given {type(start).__name__}; set starts_from: equations"
            )
        with training.monitor.phase("dynamics"):
            pole = _pole(start)
            motions = [
                (part.time, Samples((part.columns("state"),)).map(start.encode))
                for part in training.trajectories
            ]
            found = self._correction(start, pole, motions)
            reach = np.max([np.abs(z).max(axis=0) for _, z in motions], axis=0)
            return replace(start, reach=reach, dynamics=_corrected(start, pole, found))

    def _correction(
        self, start: ManifoldRom, pole: complex, motions: list[tuple[np.ndarray, np.ndarray]]
    ) -> np.ndarray:
        """c_k (order + 1,) complex; each motion has a constant of its own."""
        rows, right = [], []
        for place, (time, states) in enumerate(motions):
            z = states @ _to_complex(pole)
            x = np.abs(z) ** 2
            logarithm = np.log(np.abs(z)) + 1j * np.unwrap(np.angle(z))
            rate = start.drift(states) @ _to_complex(pole) / z
            right.append(logarithm - cumulative_trapezoid(rate, time, initial=0.0))
            constant = np.arange(len(motions)) == place
            powers = x[:, None] ** np.arange(self.order + 1)
            integral = cumulative_trapezoid(powers, time, axis=0, initial=0.0)
            rows.append(np.hstack([np.tile(constant, (len(time), 1)), integral]))
        found = least_squares(np.concatenate(rows), np.concatenate(right)[:, None])[0]
        return found[len(motions) :]


def _pole(start: ManifoldRom) -> complex:
    """The eigenvalue with a positive imaginary part of small motions."""
    steps = np.diag(SMALL * start.reach)
    slope = (start.drift(steps) - start.drift(-steps)).T / (2.0 * SMALL * start.reach)
    found = np.linalg.eigvals(slope)
    return complex(found[found.imag.argmax()])


def _to_complex(pole: complex) -> np.ndarray:
    """(2,): z of the real coordinates u = z + conj(z), w = pole z + conj(pole z)."""
    return np.array([-np.conj(pole), 1.0]) / (pole - np.conj(pole))


def _corrected(start: ManifoldRom, pole: complex, found: np.ndarray) -> np.ndarray:
    """Numerators (2, l) of the dynamics with z sum_k c_k x^k over their own denominator."""
    top = int(start.powers.sum(axis=1).max())
    a, b = start.powers.T
    below = np.zeros((top + 1, top + 1))
    below[a, b] = start.below_dynamics
    to = _to_complex(pole) * start.scale
    z = np.array([[0.0, to[1]], [to[0], 0.0]])  # place (i, j): of y_1^i y_2^j
    x = convolve2d(z, z.conj())
    total, power = np.zeros((1, 1), complex), np.ones((1, 1), complex)
    for c in found:
        total = _sum(total, c * power)
        power = convolve2d(power, x)
    added = convolve2d(convolve2d(total, z), below)
    i, j = np.nonzero(added)
    if (i + j).max(initial=0) > top:
        raise MethodError(
            f"the correction makes polynomials of degree {(i + j).max()}, and the model's have "
            f"{top}; lower order, or raise that of the model it starts from"
        )
    inside = added[: top + 1, : top + 1]
    rates = np.pad(inside, [(0, top + 1 - size) for size in inside.shape])[a, b]
    return start.dynamics + 2.0 * np.stack([rates.real, (pole * rates).real])


def _sum(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Of two arrays that begin at the same place."""
    found = np.zeros(np.maximum(one.shape, other.shape), complex)
    for part in (one, other):
        found[: part.shape[0], : part.shape[1]] += part
    return found
