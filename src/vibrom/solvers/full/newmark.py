"""Implicit integration of  M a + C v + K q + sum f(q, v) = p u(t) + p_0  by Newmark's method and
others of its family (`schemes`), many states side by side.

A step is that of `scheme`, solved as `newton` says, or, without state-dependent forces, by one
factor for all steps (`linear`). The tangent is a band, or a sparse matrix where the band is too
wide (`band`, `sparse`). Non-symmetric tangents are approximated in the band by their lower
triangle: this affects convergence, not the solution.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib import import_module

import numpy as np

from vibrom.kernels import banded
from vibrom.solvers.full import schemes
from vibrom.solvers.full.banded_steps import BandedSteps
from vibrom.solvers.full.batch import Batch, Further
from vibrom.solvers.full.linear import LinearSteps
from vibrom.solvers.full.march import integrate
from vibrom.solvers.full.motion import Motion, Record
from vibrom.solvers.full.newton import Limits
from vibrom.solvers.full.scheme import Scheme
from vibrom.solvers.full.shapes import shaped
from vibrom.solvers.full.sparse import SparseSteps
from vibrom.solvers.full.stepper import Stepper
from vibrom.solvers.full.tangent import PyPardisoSolver
from vibrom.term import SceneError, Term

ACCELERATIONS = ("equilibrium", "zero")

# By the dimension of a body. Sparse factors fill less than the band from some width on, and steps
# are then faster with them (`python -m benchmarks growth`). In space, where a factor serves some
# twenty solves, sixteen states in the band take 0.7 of PARDISO's time at a half width of 365 and
# 1.6 times that at 590, one state 0.8 and 1.25; LAPACK's band takes as long as ours at 590.
WIDEST = {2: 300, 3: 450} if PyPardisoSolver else {2: 500, 3: 600}


@dataclass(frozen=True)
class Newmark:
    """Settings of the integration."""

    alpha: float = 0.0  # numerical damping
    scheme: str = "newmark"  # a file of `schemes`
    tolerance: float = 1e-6  # relative residual at which a step has converged
    max_iterations: int = 25  # of Newton, a step
    # Refactorise if, at the current rate, Newton needs more than this many further iterations.
    patience: float = 3.0
    widest_band: int | None = None  # half bandwidth beyond which steps are sparse; None: WIDEST

    def run(
        self,
        term: Term,
        displacement: np.ndarray,  # (n, states) m
        step: np.ndarray,  # (states,) s
        steps: int,
        *,
        velocity: np.ndarray | None = None,  # (n, states) m/s; None: at rest
        signal: np.ndarray | None = None,  # (steps + 1, states) u at every step; None: zero
        more: Further | None = None,  # loads beside that of the term
        initial_acceleration: str = "equilibrium",  # with the forces at the start, or zero
        record: Record | None = None,  # None: all of every step
        progress: Callable[[int], None] | None = None,  # hears how many state-steps were added
    ) -> Motion:
        """Integrates all states over `steps` steps."""
        record = record or Record()
        start = self._checked(
            term, displacement, velocity, step, steps, signal, initial_acceleration, record
        )
        if more is not None:
            start = replace(start, more=more.checked(term.size, steps, start.width))
        method, half = self._method(term)
        limits = Limits(self.tolerance, self.patience, self.max_iterations)
        return integrate(method, start, limits, half, record, progress)

    def _checked(
        self, term, displacement, velocity, step, steps, signal, initial_acceleration, record
    ) -> Batch:
        """All states as one batch, or an error that names what does not fit."""
        if term.mass is None:
            raise SceneError("effects has no inertia, and without mass nothing moves; list inertia")
        if initial_acceleration not in ACCELERATIONS:
            raise ValueError(
                f"initial_acceleration = {initial_acceleration!r} is unknown; choose from "
                f"{', '.join(ACCELERATIONS)}"
            )
        if steps < 0:
            raise ValueError(f"steps = {steps}; needed are none or more")
        n = term.size
        record.check(n)
        states = np.shape(displacement)[1] if np.ndim(displacement) == 2 else 1
        if velocity is None:
            velocity = np.zeros((n, states))
        if signal is None:
            signal = np.zeros((steps + 1, states))
        return Batch(
            term,
            self.parameters(),
            shaped("displacement", displacement, n=n, states=states),
            shaped("velocity", velocity, n=n, states=states),
            shaped("step", step, states=states),
            shaped("signal", signal, **{"steps + 1": steps + 1, "states": states}),
            initial_acceleration == "equilibrium",
        )

    def parameters(self) -> Scheme:
        """Those of the scheme."""
        module = import_module(f"{schemes.__name__}.{self.scheme}")
        made: Scheme = module.scheme(self.alpha)
        return made

    def _method(self, term: Term) -> tuple[type[Stepper], int]:
        """How the steps of a term are taken, and the half bandwidth of its tangent."""
        half = half_bandwidth(term)
        if self.is_wide(term, half):
            return SparseSteps, half
        return BandedSteps if term.forces else LinearSteps, half

    def is_wide(self, term: Term, half: int) -> bool:
        """Is a band of this half width beyond what is stored as one?"""
        if self.widest_band is not None:
            return half > self.widest_band
        in_space = term.elastic is not None and len(term.elastic) == 6
        return half > WIDEST[3 if in_space else 2]


def half_bandwidth(term: Term) -> int:
    """Of the tangent."""
    parts = (term.mass, term.damping, term.stiffness)
    half = max(banded.half_bandwidth(part) for part in parts if part is not None)
    for force in term.forces:
        lowest = np.where(force.dofs < 0, term.size, force.dofs).min(axis=1)
        half = max(half, int((force.dofs.max(axis=1) - lowest).max()))
    return half
