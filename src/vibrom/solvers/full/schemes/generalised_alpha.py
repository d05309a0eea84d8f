"""The generalised-alpha method:  M a_e + C v_e + K q_e + f(q_e, v_e) = p u_e + p_0,

    alpha_m = (1 - 3 alpha)/2,  alpha_f = (1 - alpha)/2,  gamma = 1/2 + alpha,
    beta = (1 + alpha)^2/4

Of second order for any alpha: numerical damping leaves the modes that the step resolves alone, with
a damping ratio that falls as h^3. These are the parameters of Chung and Hulbert (J. Appl. Mech. 60
(1993) 371) with the spectral radius (1 - alpha)/(1 + alpha); alpha = 0 is the midpoint rule, whose
accelerations at the ends of steps keep an error of the first one for ever, in turns with either
sign.
"""

from vibrom.solvers.full.scheme import Scheme


def scheme(alpha: float) -> Scheme:
    """The parameters for a numerical damping."""
    return Scheme(
        beta=0.25 * (1.0 + alpha) ** 2,
        gamma=0.5 + alpha,
        alpha_m=0.5 * (1.0 - 3.0 * alpha),
        alpha_f=0.5 * (1.0 - alpha),
    )
