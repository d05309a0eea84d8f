"""What a step does to a body whose tangent is a band: parts of a compiled loop, see `newton`."""

from __future__ import annotations

from typing import NamedTuple

from vibrom.kernels.banded import Kernels, Product, Products
from vibrom.kernels.compiled import Blocks, Places, Rows, part
from vibrom.kernels.lanes import fill, get, put, sqrt
from vibrom.solvers.full.batch import Loads, Steps, push_further
from vibrom.solvers.full.newton import Limits
from vibrom.solvers.full.scheme import extrapolated, predicted, within
from vibrom.solvers.full.store import State, copy, finish_step


class System(NamedTuple):
    """A body, its loads and its tangent, for a batch of states."""

    steps: Steps
    loads: Loads
    limits: Limits
    mass: Product
    damping: Product  # without entries where C = c M
    stiffness: Product
    mass_and_stiffness: Products
    mass_damping: float  # c of C = c M, 1/s
    by_mass: Rows  # (1, width) 1 + c gamma h
    parts: Blocks  # (k, n, half + 1): bands of M, C, K that all states share
    scales: Rows  # (k, width): 1, gamma h, beta h^2
    factor: Blocks  # (n, half + 1, width)


class Forces(NamedTuple):
    """The state-dependent forces: of each its kernels and what they know of its elements."""

    add: tuple  # pointers to kernels that add f
    dofs: tuple[Places, ...]
    tables: tuple[Rows, ...]
    add_tangent: tuple  # pointers to kernels that add its derivative
    tangent_dofs: tuple[Places, ...]
    tangent_tables: tuple[Rows, ...]
    slots: tuple[Places, ...]  # where the derivative's entries go in the band


class Work(NamedTuple):
    """Arrays (n, width) of a step."""

    past: Blocks  # (4, n, width) m/s^2: of step k in row k % 4
    start: State  # of the step, and
    last: Rows  # m/s^2, the last acceleration where the equation held, if that is not the end
    path: Rows  # what forces take for the displacement: q, or of mean forces (2n, width)
    plain_q: Rows  # m, q~
    plain_v: Rows  # m/s, v~
    linear: Rows  # N, M a + C v + K q
    inertial: Rows  # N, M a + C v
    f: Rows  # N, sum of the forces; zero between two evaluations
    r: Rows  # residual [N], then correction [m/s^2]


class Body(NamedTuple):
    """All that the operations of a step take."""

    system: System
    solver: Kernels
    forces: Forces
    work: Work


@part
def predict(body, state, step, width):
    """q, v and a at the first guess; r becomes a + c v, which the mass multiplies."""
    steps, work, past = body.system.steps, body.work, body.work.past
    inside = within(steps.scheme)
    last = work.last if inside else state.a
    if inside:
        copy(state, work.start, width)
    mass_damping, scheme = body.system.mass_damping, body.system.steps.scheme
    h, by_q, by_v = get(steps.h, 0, width), get(steps.by_q, 0, width), get(steps.by_v, 0, width)
    one, two, three = past[(step + 2) % 4], past[(step + 1) % 4], past[step % 4]
    four = past[(step + 3) % 4]  # whose place the last acceleration takes
    for i in range(state.q.shape[0]):
        q, v, a = get(state.q, i, width), get(state.v, i, width), get(state.a, i, width)
        q, v = predicted(scheme, h, q, v, a)
        put(work.plain_q, i, q)
        put(work.plain_v, i, v)
        a = get(last, i, width)
        guess = extrapolated(
            a, get(one, i, width), get(two, i, width), get(three, i, width), get(four, i, width)
        )
        v += by_v * guess
        put(state.q, i, q + by_q * guess)
        put(state.v, i, v)
        put(state.a, i, guess)
        put(four, i, a)
        put(work.r, i, guess + mass_damping * v)


@part
def evaluate(body, state, iteration, step, first, width):
    """The residual in r, and its norm. What is linear is evaluated once a step and then follows the
    corrections, which the solve left in r.
    """
    forces, work, u = body.forces, body.work, get(body.system.loads.signal, step, width)
    if first:
        push_further(body.system.loads, step)
        evaluate_linear(body, state, width)
    else:
        follow_linear(body, width)
    lay_path(body, state, width)
    for k in range(len(forces.add)):
        forces.add[k](work.path, state.v, forces.dofs[k], forces.tables[k], work.f)
    if first:
        put(iteration.scale, 0, add_up(body.system.loads, work, u, width))
    put(iteration.norm, 0, subtract(body.system.loads, work, u, width))


@part
def lay_path(body, state, width):
    """Fills the path of mean forces."""
    path, n = body.work.path, state.q.shape[0]
    if path.shape[0] > n:
        half = 0.5 * get(body.system.steps.h, 0, width)
        for i in range(n):
            put(path, i, get(state.q, i, width))
            put(path, n + i, half * get(state.v, i, width))


@part
def evaluate_linear(body, state, width):
    """M a + C v in `inertial`, K q in `linear`; r holds a + c v."""
    system, multiply_add, work = body.system, body.solver.multiply_add, body.work
    damping, stiffness = system.damping, system.stiffness
    work.inertial[:], work.linear[:] = 0.0, 0.0
    multiply_add(system.mass.values, system.mass.places, work.r, work.inertial)
    if damping.values.size > 0:
        multiply_add(damping.values, damping.places, state.v, work.inertial)
    if stiffness.values.size > 0:
        multiply_add(stiffness.values, stiffness.places, state.q, work.linear)


@part
def follow_linear(body, width):
    """Adds [(1 + c gamma h) M + gamma h C + beta h^2 K] da to `linear`; r holds da."""
    system, work, damping = body.system, body.work, body.system.damping
    both, by_mass, by_stiffness = system.mass_and_stiffness, system.by_mass, system.steps.by_q
    body.solver.multiply_add_both(
        both.first, both.second, both.places, by_mass, by_stiffness, work.r, work.linear
    )
    if damping.values.size > 0:
        by_v = get(system.steps.by_v, 0, width)
        for i in range(work.r.shape[0]):
            put(work.inertial, i, by_v * get(work.r, i, width))
        body.solver.multiply_add(damping.values, damping.places, work.inertial, work.linear)


@part
def add_up(loads, work, u, width):
    """|M a + C v| + |K q + f| + |p u + p_0|; `linear` becomes all that is linear."""
    inertial = restoring = external = fill(0.0, width)
    for i in range(work.f.shape[0]):
        own, linear = get(work.inertial, i, width), get(work.linear, i, width)
        load = loads.load[i] * u + loads.dead_load[i]
        put(work.linear, i, linear + own)
        linear += get(work.f, i, width)
        inertial += own * own
        restoring += linear * linear
        external += load * load
    return sqrt(inertial) + sqrt(restoring) + sqrt(external)


@part
def subtract(loads, work, u, width):
    """|r|; `f` is zero again for the next evaluation."""
    squares = fill(0.0, width)
    for i in range(work.f.shape[0]):
        load = loads.load[i] * u + loads.dead_load[i]
        r = load - get(work.linear, i, width) - get(work.f, i, width)
        put(work.r, i, r)
        put(work.f, i, fill(0.0, width))
        squares += r * r
    return sqrt(squares)


@part
def factorise(body, state, width):
    """The factors of M + gamma h C + beta h^2 (K + df/dq)."""
    steps, forces, factor = body.system.steps, body.forces, body.system.factor
    body.solver.combine(body.system.parts, body.system.scales, factor)
    values = factor.reshape(factor.shape[0] * factor.shape[1], factor.shape[2])
    by_q, by_v, path = steps.by_q[0], steps.by_v[0], body.work.path
    lay_path(body, state, width)
    for k in range(len(forces.add_tangent)):
        dofs, table, slots = forces.tangent_dofs[k], forces.tangent_tables[k], forces.slots[k]
        forces.add_tangent[k](path, state.v, dofs, table, slots, by_q, by_v, values)
    body.solver.factorise(factor)


@part
def correct(body, state, width):
    """Adds the correction, which stays in r."""
    r, steps = body.work.r, body.system.steps
    by_q, by_v = get(steps.by_q, 0, width), get(steps.by_v, 0, width)
    body.solver.solve(body.system.factor, r)
    for i in range(r.shape[0]):
        change = get(r, i, width)
        put(state.a, i, get(state.a, i, width) + change)
        put(state.v, i, get(state.v, i, width) + by_v * change)
        put(state.q, i, get(state.q, i, width) + by_q * change)


@part
def restart(body, state, w, width):
    """State w of the batch without acceleration."""
    for i in range(state.q.shape[0]):
        state.q[i, w], state.v[i, w] = body.work.plain_q[i, w], body.work.plain_v[i, w]
        state.a[i, w] = 0.0


@part
def finish(body, state, width):
    """The step's end."""
    scheme, work = body.system.steps.scheme, body.work
    if within(scheme):
        for i in range(state.a.shape[0]):
            put(work.last, i, get(state.a, i, width))
        finish_step(scheme, work.start, state, width)


@part
def freeze(body, state, w, width):
    """State w of the batch at rest."""
    state.q[:, w], state.v[:, w], state.a[:, w], body.work.past[:, :, w] = 0.0, 0.0, 0.0, 0.0
    body.work.last[:, w] = 0.0
