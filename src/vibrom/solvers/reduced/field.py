"""The vector field of a reduced model in compiled code, for WIDTH runs side by side:

dy/dt = drift(y) + force(y) a sin(w t)
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numba import types

from vibrom.kernels.lanes import WIDTH, get, kernel, put
from vibrom.solvers.reduced.parts import maker, part, record, zeros

_f1, _f2, _i1 = types.float64[::1], types.float64[:, ::1], types.int64[::1]
# out (r, WIDTH) = f(y (r, WIDTH)); numbers and index are the map's own tables, work its scratch of
# `rows` times WIDTH.
KERNEL = types.void(_f2, _f1, _i1, _f1, _f2)
MAP = types.FunctionType(KERNEL)
field_kernel = kernel(KERNEL, fastmath=False)  # compiles `function(y, numbers, index, work, out)`


@dataclass(frozen=True)
class Kernel:
    """A compiled map of the state and its tables."""

    function: Callable  # of the type KERNEL
    numbers: np.ndarray  # (any,) floats
    index: np.ndarray  # (any,) integers
    rows: int  # of scratch, WIDTH numbers each
    dimension: int  # r, of the states that it takes


@dataclass(frozen=True)
class VectorField:
    """What an integrator takes."""

    drift: Kernel
    force: Kernel | None = None  # None: the model is left alone
    kink: np.ndarray | None = None  # (d,) size of each position at which neither side is smooth

    def tables(self) -> "Tables":
        """What the compiled loop takes beside the two functions."""
        force = self.force or self.drift
        return Tables(
            self.drift.numbers,
            self.drift.index,
            force.numbers,
            force.index,
            np.zeros(WIDTH * max(self.drift.rows, force.rows)),
            self.force is not None,
        )


class Tables(NamedTuple):
    """The data of a vector field."""

    drift_numbers: np.ndarray
    drift_index: np.ndarray
    force_numbers: np.ndarray
    force_index: np.ndarray
    scratch: np.ndarray  # (rows WIDTH,), of the larger of the two maps
    driven: bool


class Flow(NamedTuple):
    """A vector field and the signals of the runs in the lanes."""

    drift: Any  # MAP
    force: Any  # MAP; not called unless tables.driven
    tables: Tables
    amplitude: np.ndarray  # (WIDTH,) of the signal, in its unit
    frequency: np.ndarray  # (WIDTH,) [rad/s]
    signal: np.ndarray  # (WIDTH,) scratch: a sin(w t)
    push: np.ndarray  # (r, WIDTH) scratch: force(y)


TABLES = record(Tables, _f1, _i1, _f1, _i1, _f1, types.boolean)


@maker
def flow_of(drift, force, tables, r):
    """The vector field with all lanes empty."""
    lane = zeros(3).reshape(3, WIDTH)
    return Flow(drift, force, tables, lane[0], lane[1], lane[2], zeros(r))


@part
def evaluate(flow, t, y, out):
    """Fills `out` (r, WIDTH) with dy/dt at the times t (WIDTH,) and states y (r, WIDTH)."""
    tables = flow.tables
    flow.drift(y, tables.drift_numbers, tables.drift_index, tables.scratch, out)
    if tables.driven:
        flow.force(y, tables.force_numbers, tables.force_index, tables.scratch, flow.push)
        for w in range(WIDTH):
            flow.signal[w] = flow.amplitude[w] * np.sin(flow.frequency[w] * t[w])
        signal = get(flow.signal, 0, WIDTH)
        for i in range(len(y)):
            put(out, i, get(out, i, WIDTH) + get(flow.push, i, WIDTH) * signal)
