"""Vector fields with closed forms, and the compiled loop with settings that tests share."""

from dataclasses import replace

import numpy as np

from vibrom.latent.polynomial import exponents
from vibrom.latent.polynomial_kernel import constant_kernel, polynomial_kernel
from vibrom.solvers.reduced.explicit import solve as explicit_loop
from vibrom.solvers.reduced.field import VectorField
from vibrom.solvers.reduced.integrate import Stepper, integrate
from vibrom.solvers.reduced.records import Bounds, Forcing, Tolerance
from vibrom.solvers.reduced.steppers import dop853, gauss

OMEGA, DAMPING = 1.3, 0.05
EXPLICIT, IMPLICIT = dop853.stepper(1.0, 0), gauss.equal_steps(0.05)


def polynomial(*rows, push=None, dimension=2):
    """Rows of {(i, j): coefficient of y1^i y2^j}; `push` acts on the last coordinate."""
    powers = exponents(dimension, 1, 3)
    coefficients = [[row.get(tuple(power), 0.0) for power in powers.tolist()] for row in rows]
    drift = polynomial_kernel(np.ones(dimension), powers, np.array(coefficients))
    force = None if push is None else constant_kernel(push * np.eye(dimension)[-1])
    return VectorField(replace(drift, dimension=dimension), force)


OSCILLATOR = polynomial({(0, 1): 1.0}, {(1, 0): -1.0})
FORCED = polynomial({(0, 1): 1.0}, {(1, 0): -(OMEGA**2), (0, 1): -DAMPING}, push=1.0)
DUFFING = polynomial({(0, 1): 1.0}, {(1, 0): -1.0, (0, 1): -0.1, (3, 0): -1.0}, push=1.0)
SQUARE = polynomial({(2,): 1.0}, dimension=1)  # y' = y^2


def forced_from_rest(t, frequency, amplitude):
    """x'' + c x' + w^2 x = a sin(W t), x = x' = 0 at t = 0: the steady part and the free motion
    that cancels it at the start.
    """
    response = amplitude / (OMEGA**2 - frequency**2 + 1j * DAMPING * frequency)
    damped = np.sqrt(OMEGA**2 - DAMPING**2 / 4)
    at_rest, rate = -response.imag, -frequency * response.real
    free = np.exp(-DAMPING * t / 2) * (
        at_rest * np.cos(damped * t) + (rate + DAMPING * at_rest / 2) / damped * np.sin(damped * t)
    )
    return (response * np.exp(1j * frequency * t)).imag + free


def solve(stepper, field, start, times, rtol=1e-9, atol=1e-12, reach=1e6, limit=1e7, forcing=None):
    """The loop; bounds and tolerance alike for all coordinates."""
    one = np.ones(field.drift.dimension or np.shape(start)[-1])
    signal = None if forcing is None else Forcing(*forcing)
    bounds = Bounds(reach * one, limit * one)
    return integrate(stepper, field, start, times, Tolerance(rtol, atol * one), bounds, signal)


def equal_explicit_steps(tableau, count):
    """An explicit method in `count` equal steps, as far as its tolerance lets it."""

    def plan(end):
        return end / count, np.full(len(end), 10 * count)

    return Stepper(explicit_loop, tableau, plan)
