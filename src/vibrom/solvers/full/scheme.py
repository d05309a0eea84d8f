"""Newmark's formulas, for numbers in lanes and for arrays alike; the equation of motion holds at an
instant e of the step, which a scheme chooses.

    q_1 = q_0 + h v_0 + h^2 [(1/2 - beta) a_0 + beta a_1],   v_1 = v_0 + h [(1 - gamma) a_0 +
    gamma a_1],   a_e = alpha_m a_0 + (1 - alpha_m) a_1,   x_e = alpha_f x_0 + (1 - alpha_f) x_1

for x = q, v and the signal u. What is solved for is a_e: with s = 1 - alpha_f, b = beta/(1 -
alpha_m) and g = gamma/(1 - alpha_m)

    q_e = q~ + s b h^2 a_e,   q~ = q_0 + s h [v_0 + h (1/2 - b) a_0]
    v_e = v~ + s g h a_e,     v~ = v_0 + s h (1 - g) a_0

Newmark's own method has e at the end of the step. Sources: Newmark 1959; Chung and Hulbert, J.
Appl. Mech. 60 (1993) 371.
"""

from __future__ import annotations

from typing import NamedTuple

from vibrom.kernels.compiled import part


class Scheme(NamedTuple):
    """The parameters of a method; see the files of `schemes`."""

    beta: float
    gamma: float
    alpha_m: float = 0.0  # how far before the end of the step the accelerations are taken,
    alpha_f: float = 0.0  # and all else, in steps
    mean: bool = False  # are forces means over the step (`Force.mean`), or those at the instant e?


@part
def within(scheme):
    """Does the equation of motion hold elsewhere than at the end of the step?"""
    return scheme.alpha_m != 0.0 or scheme.alpha_f != 0.0


@part
def weights(scheme, h):
    """What an acceleration at the instant e adds there: s b h^2 to q and s g h to v."""
    share = (1.0 - scheme.alpha_f) / (1.0 - scheme.alpha_m)
    return share * scheme.beta * h * h, share * scheme.gamma * h


@part
def predicted(scheme, h, q, v, a):
    """q~ and v~: the instant e without an acceleration there."""
    ahead = (1.0 - scheme.alpha_f) * h
    b, g = scheme.beta / (1.0 - scheme.alpha_m), scheme.gamma / (1.0 - scheme.alpha_m)
    return q + ahead * (v + h * (0.5 - b) * a), v + ahead * (1.0 - g) * a


@part
def ended(alpha, start, x):
    """x_1 from x_0 and x_e."""
    return (x - alpha * start) * (1.0 / (1.0 - alpha))


@part
def extrapolated(a, one, two, three, four):
    """A guess of the next acceleration from the last one and those one to four steps before it.

    Exact for a cubic, and for the alternation of sign that Newmark leaves in modes far beyond the
    step: (r - 1)^4 (r + 1) = r^5 - 3 r^4 + 2 r^3 + 2 r^2 - 3 r + 1.
    """
    return 3.0 * (a + three) - 2.0 * (one + two) - four
