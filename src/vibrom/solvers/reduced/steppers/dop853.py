"""Dormand and Prince's method of order 8(5,3), explicit, with adaptive steps and an interpolant of
order 7 (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.5). The coefficients
are SciPy's.
"""

from functools import partial

from vibrom.solvers.reduced import order_8
from vibrom.solvers.reduced.explicit import Tableau, plan, solve
from vibrom.solvers.reduced.integrate import Stepper

FIRST_STEP = 0.05  # of the time scale: a twentieth of what the method takes later
SHORTEST_STEP = 0.05  # of the time scale: a run whose mean step is shorter crawls, and is stopped


TABLEAU = Tableau(order_8.A, order_8.C, order_8.E5, order_8.E3, order_8.D, 8)


def stepper(time_scale: float, steps: int) -> Stepper:
    """The method for this time scale [s]; its steps follow from the tolerance."""
    return Stepper(
        solve, TABLEAU, partial(plan, FIRST_STEP * time_scale, SHORTEST_STEP * time_scale)
    )
