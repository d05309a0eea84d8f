"""The energy-momentum method:  M (v_1 - v_0)/h + C v_m + K q_m + f_m = p u_m + p_0,  with

    q_m = (q_0 + q_1)/2,  v_m = (v_0 + v_1)/2 = (q_1 - q_0)/h,  f_m' (q_1 - q_0) = U(q_1) - U(q_0)

The midpoint rule with forces f_m that do the work of their potential U: whatever the step, an
undamped body keeps its energy to the residual of the iteration, and with the stress of the mean
strain at both ends its angular momentum. Simo and Tarnow, ZAMP 43 (1992) 757. Effects say by
`Force.mean` what their f_m is; those that do not are taken at the middle, which is exact where they
are linear. It has no numerical damping. Accelerations at the ends of steps are those of
`generalised_alpha` with alpha = 0.
"""

from vibrom.solvers.full.scheme import Scheme
from vibrom.term import SceneError

DAMPED = False


def scheme(alpha: float) -> Scheme:
    """The only parameters that there are."""
    if alpha:
        raise SceneError(
            f"time.alpha = {alpha:g} damps, and energy_momentum keeps energy; choose alpha = 0, or "
            "scheme = generalised_alpha"
        )
    return Scheme(beta=0.25, gamma=0.5, alpha_m=0.5, alpha_f=0.5, mean=True)
