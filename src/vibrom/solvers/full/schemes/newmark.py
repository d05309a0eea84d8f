"""Newmark's method:  M a_1 + C v_1 + K q_1 + f(q_1, v_1) = p u_1 + p_0,

    gamma = 1/2 + alpha,  beta = (1 + alpha)^2/4

The trapezoidal rule for alpha = 0, which is of second order. Numerical damping costs an order:
alpha > 0 damps the modes that the step resolves by  zeta = alpha omega h/2. Linear bodies are
stable with any step; one that bends far may gain energy from step to step. Sources: Newmark 1959;
Bathe, Finite Element Procedures, 9.2.4.
"""

from vibrom.solvers.full.scheme import Scheme


def scheme(alpha: float) -> Scheme:
    """The parameters for a numerical damping."""
    return Scheme(beta=0.25 * (1.0 + alpha) ** 2, gamma=0.5 + alpha)
