"""Newton's steps with a sparse tangent, in Python: for bodies whose band is too wide.

The same equations and the same iteration as in the band, one state at a time. The element kernels
are the compiled ones; only the tangent's storage and its factorisation differ.
"""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from vibrom.solvers.full.batch import Batch
from vibrom.solvers.full.newton import Limits, Operations, iteration, newton_step
from vibrom.solvers.full.scheme import ended, extrapolated, predicted
from vibrom.solvers.full.store import Span, Store, keep
from vibrom.solvers.full.tangent import Tangent


class SparseSteps:
    """One state with a sparse tangent; a `Stepper`."""

    chunk, width = 20, 1

    @staticmethod
    def batch_width(remaining: int) -> int:
        """One, however many are left."""
        return 1

    @staticmethod
    def compile(batch: Batch, width: int) -> None:
        """Compiles what it needs, or reads it from disk."""
        for force in batch.stepped.forces:
            force.kernels(width)

    def __init__(self, batch: Batch, limits: Limits, half: int):
        self.batch, self.limits = batch, limits
        self.state, self.iteration = batch.start(), iteration(self.width)
        self.scheme, self.h, self.by_q, self.by_v = batch.steps
        by_v, by_q = float(self.by_v[0, 0]), float(self.by_q[0, 0])
        self.tangent = Tangent(batch.stepped, 1.0, by_v, by_q)
        self.past = [self.state.a.copy() for _ in range(5)]  # accelerations, newest first
        self.failed, self.iterations = self.iteration.failed, self.iteration.iterations
        self.factorisations = self.iteration.factorisations

    def advance(self, span: Span, store: Store) -> int:
        """See `Stepper.advance`."""
        stored = 0
        for step in range(span.first, span.last + 1):
            if step > span.first and self.failed[0] < 0:
                newton_step(OPERATIONS, self, self.state, self.iteration, self.limits, step, 1)
            stored = keep(step, span, self.state, store, stored)
        return stored

    def predict(self, state, step, width):
        """The first guess of the step's end."""
        self.start = [values.copy() for values in state]
        self.plain = predicted(self.scheme, self.h, *state)
        self._set(state, extrapolated(*self.past))

    def path(self, state):
        """What forces take for the displacement."""
        if not self.scheme.mean:
            return state.q
        return np.concatenate([state.q, 0.5 * self.h * state.v])

    def _set(self, state, acceleration):
        """The step's end with this acceleration."""
        q, v = self.plain
        state.q[:], state.v[:] = q + self.by_q * acceleration, v + self.by_v * acceleration
        state.a[:] = acceleration

    def evaluate(self, state, iteration, step, first, width):
        """The residual, its norm and at first its scale."""
        term, loads = self.batch.term, self.batch.loads
        inertial = term.mass @ state.a
        if term.damping is not None:
            inertial += term.damping @ state.v
        restoring = self.batch.internal(self.batch.stepped, self.path(state), state.v)
        further = loads.signals[step] @ loads.further
        external = (loads.load * loads.signal[step, 0] + loads.dead + further)[:, None]
        self.r = external - inertial - restoring
        with np.errstate(over="ignore"):  # what is too large has not converged
            iteration.norm[:] = np.linalg.norm(self.r)
            if first:
                iteration.scale[:] = sum(map(np.linalg.norm, (inertial, restoring, external)))

    def factorise(self, state, width):
        """The tangent; None where there is none."""
        self.factor = None
        if np.isfinite(state.a).all():
            with suppress(RuntimeError):  # exactly singular
                self.factor = self.tangent.factor(self.path(state), state.v)

    def correct(self, state, width):
        """Adds the correction."""
        change = np.nan if self.factor is None else self.factor.solve(self.r)
        for values, by in ((state.q, self.by_q), (state.v, self.by_v), (state.a, 1.0)):
            values += by * change

    def restart(self, state, w, width):
        """Without acceleration."""
        self._set(state, np.zeros_like(state.a))

    def finish(self, state, width):
        """The step's end."""
        self.past = [state.a.copy(), *self.past[:4]]
        lags = self.scheme.alpha_f, self.scheme.alpha_f, self.scheme.alpha_m
        for values, start, alpha in zip(state, self.start, lags):
            values[:] = ended(alpha, start, values)

    def freeze(self, state, w, width):
        """At rest."""
        for values in (*state, *self.past):
            values[:] = 0.0


OPERATIONS = Operations(
    SparseSteps.predict,
    SparseSteps.evaluate,
    SparseSteps.factorise,
    SparseSteps.correct,
    SparseSteps.restart,
    SparseSteps.finish,
    SparseSteps.freeze,
)
