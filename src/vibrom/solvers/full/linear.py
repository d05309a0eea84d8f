"""Steps without state-dependent forces, compiled: one product and one solve a step.

With q~ and v~ (`scheme`) and, in Newmark's method, a = (q - q~) / (beta h^2), the equation of
motion is

    (M + gamma h C + beta h^2 K) q = beta h^2 (p u + p_0) + M q~ + C (gamma h q~ - beta h^2 v~),

where K appears on the left only; other schemes have other factors than gamma h and beta h^2.
Rounding: the sum on the left is known to eps, as K is, which moves the first frequency by
(omega_n / omega_1)^2 eps, 1e-8 for a beam of 40 x 2 bilinear elements.
Source: Bathe, Finite Element Procedures, 9.2.4.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numba import types

from vibrom.kernels import banded, blocks
from vibrom.kernels.banded import Product
from vibrom.kernels.compiled import Blocks, Numbers, Rows, kernel, machine_type, part
from vibrom.kernels.lanes import get, put, room
from vibrom.solvers.full.batch import (
    Batch,
    Loads,
    Steps,
    batch_width,
    linear_tangent,
    mass_damping,
    push_further,
)
from vibrom.solvers.full.newton import Limits
from vibrom.solvers.full.scheme import predicted, within
from vibrom.solvers.full.store import Span, State, Store, chunk, copy, finish_step, keep


class System(NamedTuple):
    """A body, its loads and the factor of its operator, for a batch of states."""

    steps: Steps
    loads: Loads
    mass: Product
    damping: Product  # without entries where C = c M
    mass_damping: float  # c of C = c M, 1/s
    factor: Blocks
    x: Rows  # (n, width) m, what M multiplies
    drag: Rows  # (n, width) m s, what C multiplies
    r: Rows  # (n, width) kg m, the right side, then q
    start: State  # of the step, where the equation of motion does not hold at its end


@part
def linear_step(system, multiply_add, solve, state, failed, step, width):
    """From the end of step `step` - 1 to the end of step `step`."""
    steps, r, rate = system.steps, system.r, system.mass_damping
    h, by_q, by_v = get(steps.h, 0, width), get(steps.by_q, 0, width), get(steps.by_v, 0, width)
    mass, damping, damped = system.mass, system.damping, system.damping.values.size > 0
    loads, inverse, scheme, start = system.loads, 1.0 / by_q, steps.scheme, system.start
    inside = within(scheme)
    if inside:
        copy(state, start, width)
    push_further(loads, step)
    u = by_q * get(loads.signal, step, width)
    for i in range(r.shape[0]):
        q, v, a = get(state.q, i, width), get(state.v, i, width), get(state.a, i, width)
        q, v = predicted(scheme, h, q, v, a)
        drag = by_v * q - by_q * v
        put(state.q, i, q)
        put(state.v, i, v)
        put(system.x, i, q + rate * drag)
        put(r, i, loads.load[i] * u + loads.dead_load[i] * by_q)
        if damped:
            put(system.drag, i, drag)
    multiply_add(mass.values, mass.places, system.x, r)
    if damped:
        multiply_add(damping.values, damping.places, system.drag, r)
    solve(system.factor, r)
    for i in range(r.shape[0]):
        q = get(r, i, width)
        a = inverse * (q - get(state.q, i, width))
        put(state.q, i, q)
        put(state.v, i, get(state.v, i, width) + by_v * a)
        put(state.a, i, a)
    if inside:
        finish_step(scheme, start, state, width)
    for w in range(width):
        if failed[w] < 0 and not np.isfinite(state.q[0, w]):
            failed[w] = step


@cache
def compiled(width: int):
    """The time loop for `width` states side by side."""
    called = banded.SIGNATURES.multiply_add, banded.SIGNATURES.solve
    pointers = (types.FunctionType(signature) for signature in called)
    records = (machine_type(item) for item in (State, Numbers, Span, Store))

    @kernel(types.int64(machine_type(System), *pointers, *records), fastmath=False)
    def loop(system, multiply_add, solve, state, failed, span, store):
        stored = 0
        for step in range(span.first, span.last + 1):
            if step > span.first:
                linear_step(system, multiply_add, solve, state, failed, step, width)
            stored = keep(step, span, state, store, stored)
        return stored

    return loop


class LinearSteps:
    """A batch of states whose operator is factorised once; a `Stepper`."""

    batch_width = staticmethod(batch_width)

    @staticmethod
    def compile(batch: Batch, width: int) -> None:
        """Compiles what it needs, or reads it from disk."""
        banded.kernels(width)
        compiled(width)

    def __init__(self, batch: Batch, limits: Limits, half: int):
        term, width, n = batch.term, batch.width, batch.term.size
        kernels = banded.kernels(width)
        self.loop, self.multiply_add = compiled(width), kernels.multiply_add
        self.solve = kernels.solve
        factor = room(n * (half + 1), width).reshape(n, half + 1, width)
        kernels.combine(*linear_tangent(batch, half), factor)
        if width == 1:
            factor, self.solve = blocks.factorise(factor[:, :, 0]), blocks.solve
        else:
            kernels.factorise(factor)
        rate = mass_damping(term)
        self.system = System(
            batch.steps,
            batch.loads,
            banded.product(term.mass, width),
            banded.product(None if rate else term.damping, width),
            rate,
            factor,
            *(room(n, width) for _ in range(3)),
            State(*(room(n if within(batch.scheme) else 0, width) for _ in range(3))),
        )
        self.state, self.width, self.chunk = batch.start(), width, chunk(n, width)
        self.failed = np.full(width, -1, np.int64)
        self.iterations, self.factorisations = np.zeros((2, 1), np.int64)

    def advance(self, span: Span, store: Store) -> int:
        """See `Stepper.advance`."""
        self.iterations[0] += span.last - span.first
        kernels = self.multiply_add, self.solve
        return self.loop(self.system, *kernels, self.state, self.failed, span, store)
