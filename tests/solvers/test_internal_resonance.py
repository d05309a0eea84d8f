"""Two degrees of freedom whose frequencies are as one to two, driven at the lower one, against the
first approximation of Nayfeh and Mook, Nonlinear Oscillations (1979), section 6.5:

    x'' + 2 e m x' + x   = 2 e x y + e f sin(Omega t)
    y'' + 2 e m y' + 4 y = e x^2,                        Omega = 1 + e s

With amplitudes A of the first and B of the second harmonic, as e tends to zero,

    D A = A* B + f,   E B = A^2/2,   D = 2 (i m - s),   E = 4 (i m - 2 s)
    |A|^2 |D E - |A|^2/2|^2 = f^2 |E|^2

a cubic equation of |A|^2. The curve has two peaks, that lean away from each other, and folds where
the derivative of its left side along |A|^2 is zero.
"""

import numpy as np
import periodic_systems as systems
from scipy.optimize import brentq

from vibrom.solvers.periodic.continuation import Pace
from vibrom.solvers.periodic.equations import in_frequency
from vibrom.solvers.periodic.response import Span, response
from vibrom.solvers.periodic.stability import Kind

DAMPING, FORCE = 0.1, 0.6  # m and f


def averaged_folds():
    """(k,) s and |A| of the folds, in the order of s."""
    found = []
    for sign in (-1.0, 1.0):  # of the root of the derivative, a quadratic equation of |A|^2

        def square(s, sign=sign):
            both = 8.0 * (1j * DAMPING - s) * (1j * DAMPING - 2.0 * s)
            root = np.sqrt(np.maximum(4.0 * both.real**2 - 3.0 * np.abs(both) ** 2, 0.0))
            return both, 2.0 * (2.0 * both.real + sign * root) / 3.0

        def off(s, square=square):
            both, a = square(s)
            return (
                a * np.abs(both - 0.5 * a) ** 2
                - np.abs(4.0 * FORCE * (1j * DAMPING - 2.0 * s)) ** 2
            )

        for grid in (np.linspace(-3.0, -0.2, 2000), np.linspace(0.2, 3.0, 2000)):
            both, a = square(grid)
            real = 4.0 * both.real**2 > 3.0 * np.abs(both) ** 2
            values = np.where(real & (a > 0.0), off(grid), np.nan)
            for k in np.flatnonzero(values[1:] * values[:-1] < 0.0):
                s = brentq(off, grid[k], grid[k + 1])
                found.append((s, np.sqrt(square(s)[1])))
    return np.array(sorted(found)).T


def test_folds_of_an_internal_resonance_tend_to_those_of_the_first_approximation():
    """What it neglects of a detuning e s is of order e^2, and of an amplitude e."""
    detuning, amplitude = averaged_folds()
    assert len(detuning) == 4
    errors = []
    for small in (0.02, 0.01, 0.005):
        flow = systems.one_to_two(small, small * DAMPING).return_map()
        lowest, highest = 1.0 - 3.0 * small, 1.0 + 3.0 * small
        span, pace = Span(lowest, highest, 300, 0.0), Pace(0.5 * small, newton=True)
        found = response(in_frequency(flow, small * FORCE), span, pace)
        folds = sorted(
            (item.orbit.p, 2.0 * np.abs(np.fft.rfft(item.swing.displacement[0])[1]) / 512)
            for item in found
            if item.orbit.kind == Kind.FOLD
        )
        p, a = np.array(folds).T
        errors.append([np.abs((p - 1.0) / small - detuning).max(), np.abs(a / amplitude - 1).max()])
    errors = np.array(errors)
    assert errors[-1].max() < 0.05
    np.testing.assert_allclose(errors[:-1] / errors[1:], 2.0, atol=0.3)
