"""Steps whose tangent is a band, compiled: no Python between two records.

Compiled once for each number of states side by side and each number of forces. The kernels arrive
as pointers, so that adding an effect compiles that effect and nothing else.
"""

from __future__ import annotations

from functools import cache

from numba import types

from vibrom.kernels import banded, banded_whole
from vibrom.kernels.banded import Kernels
from vibrom.kernels.compiled import Places, Rows, kernel, machine_type
from vibrom.kernels.lanes import room
from vibrom.solvers.full.band import (
    Body,
    Forces,
    System,
    Work,
    correct,
    evaluate,
    factorise,
    finish,
    freeze,
    predict,
    restart,
)
from vibrom.solvers.full.batch import Batch, batch_width, linear_tangent, mass_damping
from vibrom.solvers.full.newton import Iteration, Limits, Operations, iteration, newton_step
from vibrom.solvers.full.scheme import Scheme, within
from vibrom.solvers.full.store import Span, State, Store, chunk, keep
from vibrom.term import FORCE, TANGENT, Term


@cache
def compiled(width: int, forces: int, tangents: int):
    """The time loop for `width` states side by side and numbers of forces and of their parts of the
    tangent.
    """
    rows, places = machine_type(Rows), machine_type(Places)
    of_forces = types.FunctionType(FORCE), places, rows
    of_tangents = types.FunctionType(TANGENT), places, rows, places
    called = types.Tuple(
        [
            types.UniTuple(item, count)
            for items, count in ((of_forces, forces), (of_tangents, tangents))
            for item in items
        ]
    )
    records = (machine_type(record) for record in (State, Iteration, Span, Store))

    @kernel(
        types.int64(
            machine_type(System),
            banded.pointers(),
            called,
            machine_type(Work),
            *records,
        ),
        fastmath=False,
    )
    def loop(system, solver, forces, work, state, iteration, span, store):
        operations = Operations(predict, evaluate, factorise, correct, restart, finish, freeze)
        body, stored = Body(system, Kernels(*solver), Forces(*forces), work), 0
        for step in range(span.first, span.last + 1):
            if step > span.first:
                newton_step(operations, body, state, iteration, system.limits, step, width)
            stored = keep(step, span, state, store, stored)
        return stored

    return loop


def forces_of(term: Term, half: int, width: int, whole: bool) -> tuple:
    """What `Forces` holds, compiled or read from disk."""
    add, tangents = [], []
    for force in term.forces:
        function, tangent = force.kernels(width)
        add.append((function, force.dofs, force.table))
        if whole:
            places = banded_whole.slots(force.dofs, half, force.symmetric)
        else:
            places = [banded.band_slots(force.dofs, half, force.symmetric)]
        tangents += [(tangent, force.dofs, force.table, place) for place in places]
    return *zip(*add), *zip(*tangents)


class BandedSteps:
    """A batch of states with a tangent in a band; a `Stepper`."""

    batch_width = staticmethod(batch_width)

    @staticmethod
    def compile(batch: Batch, width: int) -> None:
        """Compiles what it needs, or reads it from disk."""
        whole = batch.scheme.mean
        (banded_whole if whole else banded).kernels(width)
        forces = forces_of(batch.stepped, batch.term.size, width, whole)
        compiled(width, len(forces[0]), len(forces[3]))

    def __init__(self, batch: Batch, limits: Limits, half: int):
        term, width, n = batch.term, batch.width, batch.term.size
        whole = batch.scheme.mean  # the tangents of mean forces are not symmetric
        kernels = banded_whole.kernels(width) if whole else banded.kernels(width)
        self.solver = tuple(kernels)
        self.forces = forces_of(batch.stepped, half, width, whole)
        self.loop = compiled(width, len(self.forces[0]), len(self.forces[3]))
        rate = mass_damping(term)
        parts, scales = linear_tangent(batch, half, whole)
        depth = parts.shape[2]
        self.system = System(
            batch.steps,
            batch.loads,
            limits,
            banded.product(term.mass, width),
            banded.product(None if rate else term.damping, width),
            banded.product(term.stiffness, width),
            banded.products(term.mass, term.stiffness, width),
            rate,
            1.0 + rate * batch.steps.by_v,
            parts,
            scales,
            room(n * depth, width).reshape(n, depth, width),
        )
        self.state, self.iteration, self.width = batch.start(), iteration(width), width
        self.work = work_of(batch.scheme, self.state)
        self.chunk = chunk(n, width)
        self.failed, self.iterations = self.iteration.failed, self.iteration.iterations
        self.factorisations = self.iteration.factorisations

    def advance(self, span: Span, store: Store) -> int:
        """See `Stepper.advance`."""
        fixed = self.system, self.solver, self.forces, self.work
        return self.loop(*fixed, self.state, self.iteration, span, store)


def work_of(scheme: Scheme, state: State) -> Work:
    """The arrays before the first step."""
    n, width = state.q.shape
    past = room(4 * n, width).reshape(4, n, width)
    past[:] = state.a
    path = room(2 * n, width) if scheme.mean else state.q
    inside = n if within(scheme) else 0
    start, last = State(*(room(inside, width) for _ in range(3))), room(inside, width)
    last[:] = state.a[:inside]
    work = Work(past, start, last, path, *(room(n, width) for _ in range(6)))
    work.f[:] = 0.0
    return work
