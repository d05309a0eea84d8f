"""The door to the compiled integrators: arguments are checked here, and nowhere below."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from vibrom.solvers.reduced.arguments import (
    ArgumentError,
    checked_signal,
    checked_sizes,
    checked_start,
    checked_times,
)
from vibrom.solvers.reduced.field import VectorField
from vibrom.solvers.reduced.records import Bounds, Forcing, Problem, Solution, Tolerance


@dataclass(frozen=True)
class Stepper:
    """A method of integration, ready for a time scale."""

    solve: Callable  # the loop with the method inside, made by `compiled`
    method: Any  # the record of numbers that the method takes
    # of runs that end at these times (b,) [s]: first step (b,) [s] and most steps (b,)
    plan: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


def integrate(
    stepper: Stepper,
    field: VectorField,
    start: np.ndarray,
    times: np.ndarray,
    tolerance: Tolerance,
    bounds: Bounds,
    forcing: Forcing | None = None,
) -> Solution:
    """Solves dy/dt = field(y, t) from `start` (b, r) at t = 0 to times[:, -1]; `times` (b, m) [s].

    Raises ArgumentError where a shape or a value cannot be meant.
    """
    start = checked_start(start, field.drift.dimension)
    runs, r = start.shape
    times = checked_times(times, runs)
    if field.force is not None and forcing is None:
        raise ArgumentError("a field with a force needs the amplitude and frequency of each run")
    amplitude, frequency = forcing or (np.zeros(runs), np.zeros(runs))
    first_step, most_steps = stepper.plan(times[:, -1])
    problem = Problem(
        start,
        times,
        np.array(first_step, float),
        np.array(most_steps, np.int64),
        Tolerance(float(tolerance.rtol), checked_sizes("atol", tolerance.atol, r)),
        Bounds(
            checked_sizes("reach", bounds.reach, r),
            checked_sizes("limit", bounds.limit, r),
        ),
        Forcing(
            checked_signal("amplitude", amplitude, runs),
            checked_signal("frequency", frequency, runs),
        ),
    )
    solution = Solution(
        np.full((*times.shape, r), np.nan),
        np.zeros(runs, np.int64),
        np.zeros(runs),
        np.empty((runs, r)),
        np.empty((runs, r)),
        np.full(runs, np.nan),
        np.zeros(runs, np.int64),
    )
    drift, force = field.drift.function, (field.force or field.drift).function
    stepper.solve(drift, force, field.tables(), problem, solution, stepper.method)
    return solution
