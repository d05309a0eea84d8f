"""The compiled time loop of `newmark`: no Python between two records.

Compiled once for each number of states side by side and each number of forces; the kernels arrive
as function pointers, so that adding an effect compiles that effect and nothing else.
"""

import warnings
from functools import cache

import numpy as np
from numba import types
from numba.core.errors import NumbaExperimentalFeatureWarning
from numba.extending import register_jitable

from vibrom.kernels.lanes import fill, get, kernel, put, room, sqrt
from vibrom.term import FORCE, TANGENT

_f1, _f2, _f3 = types.float64[::1], types.float64[:, ::1], types.float64[:, :, ::1]
_i1, _i2 = types.int64[::1], types.int64[:, ::1]
_MULTIPLY = types.FunctionType(types.void(_f2, _i2, _f2, _f2))
_BOTH = types.FunctionType(types.void(_f2, _f2, _i2, _f2, _f2, _f2, _f2))
_matrix = types.Tuple((_f2, _i2))
_pair = types.Tuple((_f2, _f2, _i2))
_COMBINE = types.FunctionType(types.void(_f3, _f2, _f3))
_FACTORISE = types.FunctionType(types.void(_f3))
_SOLVE = types.FunctionType(types.void(_f3, _f2))


@register_jitable
def keep(
    step, first, every, start, probes, q, v, a, stored, store_q, store_v, store_a, store_probe
):
    """Stores what is wanted of this step; how many records there then are. The step that a chunk
    begins with belongs to the chunk before.
    """
    if step == first and first > 0:
        return stored
    for k in range(probes.shape[0]):
        for w in range(q.shape[1]):
            store_probe[step - first, k, w] = q[probes[k], w]
    if step < start or (step - start) % every:
        return stored
    store_q[stored], store_v[stored], store_a[stored] = q, v, a
    return stored + 1


@register_jitable
def predict(q, v, a, past, plain_q, plain_v, hs, gamma, beta, width):
    """The first guess of the next step; `plain_q` and `plain_v` are the step without an
    acceleration at its end.
    """
    for i in range(q.shape[0]):
        here, old, one, two, three = (
            get(v, i, width),
            get(a, i, width),
            get(past[0], i, width),
            get(past[1], i, width),
            get(past[2], i, width),
        )
        # Exact for a cubic, and for the alternation of sign that Newmark leaves in modes far beyond
        # the step: (r - 1)^4 (r + 1) = r^5 - 3 r^4 + 2 r^3 + 2 r^2 - 3 r + 1.
        guess = 3.0 * (old + three) - 2.0 * (one + two) - get(past[3], i, width)
        ahead, faster = (
            get(q, i, width) + hs * (here + hs * (0.5 - beta) * old),
            here + hs * (1.0 - gamma) * old,
        )
        put(q, i, ahead + beta * hs * hs * guess)
        put(v, i, faster + gamma * hs * guess)
        put(plain_q, i, ahead)
        put(plain_v, i, faster)
        put(past[3], i, three)
        put(past[2], i, two)
        put(past[1], i, one)
        put(past[0], i, old)
        put(a, i, guess)


@register_jitable
def add_up(inertial, linear, f, shape, u, dead, scale, width):
    """|M a + C v| + |K q + f| + |p u + p_0|, the scale of a step's residual; `linear` becomes all
    that is linear.
    """
    bodies = springs = loads = fill(0.0, width)
    for i in range(f.shape[0]):
        body, spring, p = get(inertial, i, width), get(linear, i, width), shape[i] * u + dead[i]
        put(linear, i, spring + body)
        spring += get(f, i, width)
        bodies += body * body
        springs += spring * spring
        loads += p * p
    put(scale, 0, sqrt(bodies) + sqrt(springs) + sqrt(loads))


@register_jitable
def subtract(linear, f, shape, u, dead, r, norm, width):
    """The residual r and its norm."""
    squares = fill(0.0, width)
    for i in range(f.shape[0]):
        residual = shape[i] * u + dead[i] - get(linear, i, width) - get(f, i, width)
        put(r, i, residual)
        squares += residual * residual
    put(norm, 0, sqrt(squares))


@register_jitable
def judge(norm, previous, scale, failed, tolerance, patience, first):
    """(all have converged, one would need more than `patience` further iterations, each as good as
    the last).
    """
    done, slow = True, False
    for w in range(len(failed)):
        if failed[w] < 0:
            if not norm[0, w] <= tolerance * scale[0, w]:
                done = False
                if (
                    not first
                    and not norm[0, w] * (norm[0, w] / previous[w]) ** patience
                    <= tolerance * scale[0, w]
                ):
                    slow = True
            previous[w] = norm[0, w]
    return done, slow


@register_jitable
def correct(q, v, a, r, by_q, by_v, width):
    for i in range(q.shape[0]):
        change = get(r, i, width)
        put(a, i, get(a, i, width) + change)
        put(v, i, get(v, i, width) + by_v * change)
        put(q, i, get(q, i, width) + by_q * change)


@cache
def newmark_loop(width: int, forces: int):
    def each(item):
        return types.UniTuple(item, forces)

    signature = types.int64(
        _f3,
        _f1,
        _f1,
        types.int64,
        types.int64,
        types.int64,
        _f2,
        _f1,
        _f1,
        _matrix,
        _matrix,
        _matrix,
        _pair,
        _f3,
        _f2,
        _f3,
        _MULTIPLY,
        _BOTH,
        _COMBINE,
        _FACTORISE,
        _SOLVE,
        each(types.FunctionType(FORCE)),
        each(types.FunctionType(TANGENT)),
        each(_i2),
        each(_f2),
        each(_i2),
        _i1,
        _i1,
        types.int64,
        types.int64,
        _i1,
        _f3,
        _f3,
        _f3,
        _f3,
    )

    def loop(
        state,
        h,
        numbers,
        max_iterations,
        first,
        last,
        signal,
        shape,
        dead,
        mass,
        damping,
        stiffness,
        mass_stiffness,
        parts,
        scales,
        factor,
        multiply_add,
        multiply_add_both,
        combine,
        factorise,
        solve,
        force_kernels,
        tangent_kernels,
        dofs,
        tables,
        slots,
        failed,
        counts,
        every,
        start,
        probes,
        store_q,
        store_v,
        store_a,
        store_probe,
    ):
        """Advance `state` (7, n, width) from step `first` to `last`; returns how many records were
        stored.

        `failed` holds the step at which each state stopped converging (-1: none); `counts`
        iterations, factorisations, whether a factor exists.
        """
        gamma, beta, tolerance, patience, rate = (
            numbers[0],
            numbers[1],
            numbers[2],
            numbers[3],
            numbers[4],
        )
        n = state.shape[1]
        q, v, a, past = state[0], state[1], state[2], state[3:]
        r, f, inertial, linear = room(n, width), room(n, width), room(n, width), room(n, width)
        plain_q, plain_v = room(n, width), room(n, width)
        by_mass, by_stiffness, norm, scale, previous = (
            room(1, width),
            room(1, width),
            room(1, width),
            room(1, width),
            np.empty(width),
        )
        scale_q, scale_v = beta * h * h, gamma * h
        hs = get(h, 0, width)
        by_q, by_v = beta * hs * hs, gamma * hs
        put(by_mass, 0, 1.0 + rate * by_v)
        put(by_stiffness, 0, by_q)
        values = factor.reshape(factor.shape[0] * factor.shape[1], width)
        stored = 0
        for step in range(first, last + 1):
            if step > first:
                u = get(signal, step, width)
                predict(q, v, a, past, plain_q, plain_v, hs, gamma, beta, width)
                for attempt in range(2):
                    for iteration in range(max_iterations + 1):
                        # What is linear is evaluated once a step and then follows the corrections,
                        # which the solve left in r.
                        if iteration == 0:
                            inertial[:], linear[:] = 0.0, 0.0
                            for i in range(n):
                                put(r, i, get(a, i, width) + rate * get(v, i, width))
                            multiply_add(mass[0], mass[1], r, inertial)
                            if damping[0].size > 0:
                                multiply_add(damping[0], damping[1], v, inertial)
                            if stiffness[0].size > 0:
                                multiply_add(stiffness[0], stiffness[1], q, linear)
                        else:
                            multiply_add_both(
                                mass_stiffness[0],
                                mass_stiffness[1],
                                mass_stiffness[2],
                                by_mass,
                                by_stiffness,
                                r,
                                linear,
                            )
                            if damping[0].size > 0:
                                for i in range(n):
                                    put(inertial, i, by_v * get(r, i, width))
                                multiply_add(damping[0], damping[1], inertial, linear)
                        f[:] = 0.0
                        for k in range(forces):
                            force_kernels[k](q, v, dofs[k], tables[k], f)
                        if iteration == 0:
                            add_up(inertial, linear, f, shape, u, dead, scale, width)
                        subtract(linear, f, shape, u, dead, r, norm, width)
                        done, slow = judge(
                            norm, previous, scale, failed, tolerance, patience, iteration == 0
                        )
                        # The guess alone is an explicit step: at least one solve makes it implicit.
                        if (done and iteration > 0) or iteration == max_iterations:
                            break
                        if slow or counts[2] == 0:
                            combine(parts, scales, factor)
                            for k in range(forces):
                                tangent_kernels[k](
                                    q, v, dofs[k], tables[k], slots[k], scale_q, scale_v, values
                                )
                            factorise(factor)
                            counts[1] += 1
                            counts[2] = 1
                        solve(factor, r)
                        counts[0] += 1
                        correct(q, v, a, r, by_q, by_v, width)
                    if done or attempt > 0:
                        break
                    # Far from equilibrium the guess may lie where Newton's iteration does not find
                    # back: once more, without acceleration.
                    for w in range(width):
                        if failed[w] < 0 and not norm[0, w] <= tolerance * scale[0, w]:
                            a[:, w], v[:, w], q[:, w] = 0.0, plain_v[:, w], plain_q[:, w]
                    counts[2] = 0
                for w in range(width):
                    if failed[w] < 0 and not (
                        norm[0, w] <= tolerance * scale[0, w] and np.isfinite(a[0, w])
                    ):
                        failed[w] = step
                        counts[2] = 0
                    if (
                        failed[w] >= 0
                    ):  # at rest from here on: it costs no iterations and cannot overflow
                        state[:, :, w] = 0.0
            stored = keep(
                step,
                first,
                every,
                start,
                probes,
                q,
                v,
                a,
                stored,
                store_q,
                store_v,
                store_a,
                store_probe,
            )
        return stored

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NumbaExperimentalFeatureWarning)
        return kernel(signature, fastmath=False)(loop)
