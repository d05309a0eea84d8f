"""Implicit Newmark integration of  M a + C v + K q + sum f(q, v) = p u(t) + p_0, many states side
by side.

    q_{k+1} = q_k + h v_k + h^2 [(1/2 - beta) a_k + beta a_{k+1}],    v_{k+1} = v_k + h [(1 - gamma)
    a_k + gamma a_{k+1}]
    gamma = 1/2 + alpha,  beta = (1 + alpha)^2 / 4

Second order and undamped for alpha = 0, numerically damped for alpha > 0 (Newmark 1959; Bathe,
Finite Element Procedures, 9.2.4). Each step solves its residual by Newton iteration on the
acceleration until |r| <= tolerance (|M a + C v| + |K q + f| + |p u + p_0|), the right side taken at
the step's first guess, and keeps the factor of the tangent as long as the residual falls fast
enough. A state that does not converge is frozen, and reported with its time; the others go on.
Without state-dependent forces the operator is factorised once and each step is one solve. Of a
non-symmetric tangent the band keeps the lower triangle: beside the mass of a time step the rest is
small, and what the iteration must reach is the residual.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numba.core.errors import NumbaExperimentalFeatureWarning

from vibrom.kernels import banded, blocks
from vibrom.kernels.lanes import room
from vibrom.solvers.full import sparse
from vibrom.solvers.full.linear_loop import linear_loop
from vibrom.solvers.full.newmark_loop import newmark_loop
from vibrom.term import Term

# How many states are left, and how many of them then go side by side: two registers hide each
# other's waiting; one state alone has its elements in the lanes, and a few states cost less one by
# one than in a batch filled up with copies.
WIDTHS = ((9, 16), (3, 8), (1, 1))


@dataclass(frozen=True)
class Newmark:
    alpha: float = 0.0
    tolerance: float = 1e-6
    max_iterations: int = 25
    # factorise the tangent anew when so many more iterations, each as good as the last, would not
    # do
    patience: float = 3.0
    # Half bandwidth beyond which a sparse factorisation is taken. The square plates of
    # benchmarks/growth.py, which reach 345, are faster in the band than by SuperLU, and take more
    # memory in it the wider it is; PARDISO overtakes earlier.
    widest_band: int = 250 if sparse.PyPardisoSolver else 500

    def run(
        self,
        term: Term,
        displacement: np.ndarray,
        step: np.ndarray,
        steps: int,
        *,
        velocity: np.ndarray | None = None,
        signal: np.ndarray | None = None,
        initial_acceleration: str = "equilibrium",
        record: Record | None = None,
        progress: Callable[[int], None] | None = None,
    ) -> Motion:
        """Integrate `displacement` (n, s) [m] over `steps` steps of `step` (s,) [s]; `signal`
        (steps + 1, s) is u at every instant.
        """
        n, states = displacement.shape
        record = record or Record()
        out = record.allocate(n, states, steps)
        half = max(
            banded.half_bandwidth(part)
            for part in (term.mass, term.damping, term.stiffness)
            if part is not None
        )
        for force in term.forces:
            low = np.where(force.dofs < 0, n, force.dofs).min(axis=1)
            half = max(half, int((force.dofs.max(axis=1) - low).max()))
        integrate = sparse.run if half > self.widest_band else _run_banded
        first = 0
        while first < states:
            width = (
                1
                if integrate is sparse.run
                else next(width for least, width in WIDTHS if states - first >= least)
            )
            chosen = np.minimum(
                np.arange(first, first + width), states - 1
            )  # the last state fills the batch
            q, v = (
                np.ascontiguousarray(array[:, chosen], dtype=float)
                for array in (
                    displacement,
                    np.zeros_like(displacement) if velocity is None else velocity,
                )
            )
            u = (
                np.zeros((steps + 1, width))
                if signal is None
                else np.ascontiguousarray(signal[:, chosen], dtype=float)
            )
            integrate(
                self,
                term,
                half,
                q,
                v,
                np.ascontiguousarray(step[chosen], dtype=float),
                u,
                initial_acceleration,
                record,
                out,
                slice(first, min(first + width, states)),
                progress,
            )
            first += width
        out.failed_at *= step
        return out


@dataclass(frozen=True)
class Record:
    """What to keep: all dofs at every `every`-th step from step `start`, `probes` at every step
    from `probe_start`.
    """

    every: int = 1
    start: int = 0
    probes: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))
    probe_start: int = 0

    def allocate(self, n: int, states: int, steps: int) -> Motion:
        kept = np.arange(self.start, steps + 1, self.every)
        shape = (states, len(kept), n)
        return Motion(
            kept,
            *(np.full(shape, np.nan) for _ in range(3)),
            np.full((states, len(self.probes), max(steps + 1 - self.probe_start, 0)), np.nan),
            np.full(states, np.nan),
        )


@dataclass
class Motion:
    """kept (m,) step numbers; displacement, velocity, acceleration (states, m, n); probes (states,
    k, steps); failed_at (states,) [s], NaN where it converged throughout; seconds of wall time,
    compilation excluded; iterations and factorisations in all.
    """

    kept: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    probes: np.ndarray
    failed_at: np.ndarray
    seconds: float = 0.0
    iterations: int = 0
    factorisations: int = 0

    @property
    def outcomes(self) -> list[str]:
        return ["ok" if np.isnan(at) else "no_convergence" for at in self.failed_at]


def _run_banded(
    settings: Newmark,
    term: Term,
    half: int,
    q,
    v,
    h,
    signal,
    initial: str,
    record: Record,
    out: Motion,
    where: slice,
    progress,
) -> None:
    n, width = q.shape
    multiply_add, multiply_add_both, combine, factorise, solve = banded.kernels(width)
    kernels = [force.kernels(width) for force in term.forces]
    loop = newmark_loop(width, len(kernels)) if kernels else linear_loop(width)
    started = time.perf_counter()
    gamma, beta = 0.5 + settings.alpha, 0.25 * (1.0 + settings.alpha) ** 2
    rate = _mass_rate(term)
    linear = [
        (part, scale)
        for part, scale in (
            (term.mass, np.ones(width)),
            (term.damping, gamma * h),
            (term.stiffness, beta * h**2),
        )
        if part is not None
    ]
    parts, scales = (
        np.stack([banded.to_band(part, half) for part, _ in linear]),
        np.stack([scale for _, scale in linear]),
    )
    factor = room(n * (half + 1), width).reshape(n, half + 1, width)
    load, dead = (
        np.zeros(n) if part is None else np.ascontiguousarray(part)
        for part in (term.load, term.dead_load)
    )
    a = np.zeros_like(q)
    if initial == "equilibrium":
        a = (
            load[:, None] * signal[0]
            + dead[:, None]
            - sum(
                part @ x for part, x in ((term.damping, v), (term.stiffness, q)) if part is not None
            )
        )
        f = np.zeros_like(q)
        for force, (kernel, _) in zip(term.forces, kernels):
            kernel(q, v, force.dofs, force.table, f)
        a -= f
        combine(parts[:1], scales[:1], factor)
        factorise(factor)
        solve(factor, a)
    state = room(7 * n, width).reshape(7, n, width)
    state[:] = (
        q,
        v,
        a,
        a,
        a,
        a,
        a,
    )  # displacement, velocity, acceleration now and at the four steps before
    failed, counts = np.full(width, -1, np.int64), np.zeros(3, np.int64)
    mass, damping = (
        banded.product_form([] if part is None else [part], width)
        for part in (term.mass, None if rate else term.damping)
    )
    if kernels:
        stiffness = banded.product_form([] if term.stiffness is None else [term.stiffness], width)
        both = banded.product_form(
            [term.mass, 0.0 * term.mass if term.stiffness is None else term.stiffness], width
        )
        numbers = np.array([gamma, beta, settings.tolerance, settings.patience, rate])
        slots = tuple(banded.band_slots(force.dofs, half, force.symmetric) for force in term.forces)
        forces = (
            *(tuple(part) for part in zip(*kernels)),
            tuple(force.dofs for force in term.forces),
            tuple(force.table for force in term.forces),
            slots,
        )

        def advance(first, last, *kept):
            return loop(
                state,
                h,
                numbers,
                settings.max_iterations,
                first,
                last,
                signal,
                load,
                dead,
                mass,
                damping,
                stiffness,
                both,
                parts,
                scales,
                factor,
                multiply_add,
                multiply_add_both,
                combine,
                factorise,
                solve,
                *forces,
                failed,
                counts,
                *kept,
            )
    else:
        combine(parts, scales, factor)
        if width == 1:
            factor, solve = blocks.factorise(factor[:, :, 0]), blocks.solve
        else:
            factorise(factor)

        def advance(first, last, *kept):
            counts[0] += last - first
            return loop(
                state,
                h,
                np.array([gamma, beta, rate]),
                first,
                last,
                signal,
                load,
                dead,
                mass,
                damping,
                factor,
                multiply_add,
                solve,
                failed,
                *kept,
            )

    live = where.stop - where.start
    steps, chunk = len(signal) - 1, 2000
    stores = [np.zeros((chunk // record.every + 2, n, width)) for _ in range(3)]
    probe_store = np.zeros((chunk + 1, len(record.probes), width))
    for first in range(0, steps, chunk):
        last = min(first + chunk, steps)
        with warnings.catch_warnings():
            warnings.simplefilter(
                "ignore", NumbaExperimentalFeatureWarning
            )  # kernels passed as function pointers
            stored = advance(
                first, last, record.every, record.start, record.probes, *stores, probe_store
            )
        begin = np.searchsorted(out.kept, first if first == 0 else first + 1)
        for target, store in zip((out.displacement, out.velocity, out.acceleration), stores):
            target[where, begin : begin + stored] = store[:stored, :, :live].transpose(2, 0, 1)
        instants = np.arange(first if first == 0 else first + 1, last + 1)
        wanted = instants >= record.probe_start
        out.probes[where, :, instants[wanted] - record.probe_start] = probe_store[
            instants[wanted] - first, :, :live
        ].transpose(2, 1, 0)
        if progress is not None:
            progress((last - first) * live)
    for index in range(live):
        if failed[index] >= 0:
            out.failed_at[where.start + index] = failed[index]
            out.displacement[where.start + index, out.kept >= failed[index]] = np.nan
            out.velocity[where.start + index, out.kept >= failed[index]] = np.nan
            out.acceleration[where.start + index, out.kept >= failed[index]] = np.nan
            out.probes[where.start + index, :, max(failed[index] - record.probe_start, 0) :] = (
                np.nan
            )
    out.seconds += time.perf_counter() - started
    out.iterations += int(counts[0])
    out.factorisations += int(counts[1])


def _mass_rate(term: Term) -> float:
    """C [1/s] where C = c M, which saves a product: M a + C v = M (a + c v). Otherwise zero."""
    if term.damping is None:
        return 0.0
    rate = term.damping[0, 0] / term.mass[0, 0]
    return (
        float(rate)
        if np.allclose(
            (term.damping - rate * term.mass).data, 0.0, atol=1e-13 * abs(term.damping).max()
        )
        else 0.0
    )
