"""Dormand and Prince's method of order 8(5,3), explicit, with adaptive steps and an interpolant of
order 7 (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.5). The coefficients
are SciPy's.
"""

from functools import partial
from pathlib import Path
from runpy import run_path

import scipy

from vibrom.solvers.reduced.explicit import Tableau, plan, solve
from vibrom.solvers.reduced.integrate import Stepper

FIRST_STEP = 0.05  # of the time scale: a twentieth of what the method takes later
SHORTEST_STEP = 0.05  # of the time scale: a run whose mean step is shorter crawls, and is stopped


def _tableau() -> Tableau:
    """From the file of its coefficients alone: the package that it lies in takes a fifth of a
    second to import, longer than most models take for a decay.
    """
    found = run_path(str(Path(scipy.__file__).parent / "integrate/_ivp/dop853_coefficients.py"))
    return Tableau(*(found[name] for name in ("A", "C", "E5", "E3", "D")), 8)


TABLEAU = _tableau()


def stepper(time_scale: float, steps: int) -> Stepper:
    """The method for this time scale [s]; its steps follow from the tolerance."""
    return Stepper(
        solve, TABLEAU, partial(plan, FIRST_STEP * time_scale, SHORTEST_STEP * time_scale)
    )
