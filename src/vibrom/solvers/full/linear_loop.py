"""The compiled time loop of `newmark` without state-dependent forces: a step is one product and one
solve.

With q~ and v~, what a step predicts without its own acceleration, and a = (q - q~) / (beta h^2),
the equation of motion at the step's end is

    (M + gamma h C + beta h^2 K) q = beta h^2 (p u + p_0) + M q~ + C (gamma h q~ - beta h^2 v~),

where K appears on the left only. Rounding: the sum on the left is known to eps, as K is, which
moves the first frequency by (omega_n / omega_1)^2 eps, 1e-8 for a beam of 40 x 2 bilinear elements.
Source: Bathe, Finite Element Procedures, 9.2.4.
"""

import warnings
from functools import cache

import numpy as np
from numba import types
from numba.core.errors import NumbaExperimentalFeatureWarning

from vibrom.kernels.lanes import get, kernel, put, room
from vibrom.solvers.full.newmark_loop import keep

_f1, _f2, _f3 = types.float64[::1], types.float64[:, ::1], types.float64[:, :, ::1]
_i1, _i2 = types.int64[::1], types.int64[:, ::1]
_matrix = types.Tuple((_f2, _i2))


@cache
def linear_loop(width: int):
    signature = types.int64(
        _f3,
        _f1,
        _f1,
        types.int64,
        types.int64,
        _f2,
        _f1,
        _f1,
        _matrix,
        _matrix,
        _f3,
        types.FunctionType(types.void(_f2, _i2, _f2, _f2)),
        types.FunctionType(types.void(_f3, _f2)),
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
        first,
        last,
        signal,
        shape,
        dead,
        mass,
        damping,
        factor,
        multiply_add,
        solve,
        failed,
        every,
        start,
        probes,
        store_q,
        store_v,
        store_a,
        store_probe,
    ):
        """Advance `state` (3 or more, n, width) from step `first` to `last`; returns how many
        records were stored. With C = c M `numbers` holds c [1/s] and `damping` nothing.
        """
        gamma, beta, rate = numbers[0], numbers[1], numbers[2]
        n = state.shape[1]
        q, v, a = state[0], state[1], state[2]
        x, damped, r = room(n, width), room(n, width), room(n, width)
        hs = get(h, 0, width)
        by_q, by_v = beta * hs * hs, gamma * hs
        inverse, stored = 1.0 / by_q, 0
        for step in range(first, last + 1):
            if step > first:
                u = by_q * get(signal, step, width)
                for i in range(n):
                    here, old = get(v, i, width), get(a, i, width)
                    ahead, faster = (
                        get(q, i, width) + hs * (here + hs * (0.5 - beta) * old),
                        here + hs * (1.0 - gamma) * old,
                    )
                    drag = by_v * ahead - by_q * faster
                    put(q, i, ahead)
                    put(v, i, faster)
                    put(x, i, ahead + rate * drag)
                    put(r, i, shape[i] * u + dead[i] * by_q)
                    if damping[0].size > 0:
                        put(damped, i, drag)
                multiply_add(mass[0], mass[1], x, r)
                if damping[0].size > 0:
                    multiply_add(damping[0], damping[1], damped, r)
                solve(factor, r)
                for i in range(n):
                    end = get(r, i, width)
                    change = inverse * (end - get(q, i, width))
                    put(q, i, end)
                    put(v, i, get(v, i, width) + by_v * change)
                    put(a, i, change)
                for w in range(width):
                    if failed[w] < 0 and not np.isfinite(q[0, w]):
                        failed[w] = step
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
