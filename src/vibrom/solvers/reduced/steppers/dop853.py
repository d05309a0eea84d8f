"""Dormand and Prince's method of order 8(5,3), explicit, with adaptive steps and an interpolant of
order 7 (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.5). The coefficients
are SciPy's.
"""

from functools import partial

import numpy as np
from scipy.integrate import DOP853

from vibrom.solvers.reduced.explicit import Tableau, plan, solve
from vibrom.solvers.reduced.integrate import Stepper

FIRST_STEP = 0.05  # of the time scale: a twentieth of what the method takes later
SHORTEST_STEP = 0.05  # of the time scale: a run whose mean step is shorter crawls, and is stopped


def _tableau() -> Tableau:
    s = DOP853.n_stages
    n = s + 1 + len(DOP853.C_EXTRA)
    weights = np.zeros((n, n))
    weights[:s, :s], weights[s, :s], weights[s + 1 :] = DOP853.A, DOP853.B, DOP853.A_EXTRA
    nodes = np.concatenate([DOP853.C, [1.0], DOP853.C_EXTRA])
    return Tableau(weights, nodes, DOP853.E5.copy(), DOP853.E3.copy(), DOP853.D.copy(), 8)


TABLEAU = _tableau()


def stepper(time_scale: float, steps: int) -> Stepper:
    """The method for this time scale [s]; its steps follow from the tolerance."""
    return Stepper(
        solve, TABLEAU, partial(plan, FIRST_STEP * time_scale, SHORTEST_STEP * time_scale)
    )
