"""Newmark's formulas, for numbers in lanes and for arrays alike.

    q_{k+1} = q~ + beta h^2 a_{k+1},      q~ = q_k + h v_k + h^2 (1/2 - beta) a_k
    v_{k+1} = v~ + gamma h a_{k+1},       v~ = v_k + h (1 - gamma) a_k
    gamma = 1/2 + alpha,  beta = (1 + alpha)^2 / 4

Second order and undamped for alpha = 0, numerically damped for alpha > 0. Sources: Newmark 1959;
Bathe, Finite Element Procedures, 9.2.4.
"""

from __future__ import annotations

from typing import NamedTuple

from vibrom.kernels.compiled import part


class Scheme(NamedTuple):
    """The two parameters of the method."""

    beta: float
    gamma: float

    @classmethod
    def of(cls, alpha: float) -> Scheme:
        """The scheme with the numerical damping `alpha`."""
        return cls(beta=0.25 * (1.0 + alpha) ** 2, gamma=0.5 + alpha)


@part
def weights(scheme, h):
    """What an acceleration at the end of a step adds: beta h^2 to q and gamma h to v."""
    return scheme.beta * h * h, scheme.gamma * h


@part
def predicted(scheme, h, q, v, a):
    """q~ and v~: the end of the step without an acceleration there."""
    return q + h * (v + h * (0.5 - scheme.beta) * a), v + h * (1.0 - scheme.gamma) * a


@part
def extrapolated(a, one, two, three, four):
    """A guess of the next acceleration from the last one and those one to four steps before it.

    Exact for a cubic, and for the alternation of sign that Newmark leaves in modes far beyond the
    step: (r - 1)^4 (r + 1) = r^5 - 3 r^4 + 2 r^3 + 2 r^2 - 3 r + 1.
    """
    return 3.0 * (a + three) - 2.0 * (one + two) - four
