"""The right-hand side of a reduced model in compiled code:  dz/dt = drift(z) + force(z) u(t), WIDTH states side by side."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import types

from vibrom.lanes import kernel

# out (r, WIDTH) = f(z (r, WIDTH)); numbers and index are the map's own tables, work its scratch of `rows` times WIDTH.
KERNEL = types.void(types.float64[:, ::1], types.float64[::1], types.int64[::1], types.float64[::1], types.float64[:, ::1])
field_kernel = kernel(KERNEL, fastmath=False)  # compiles `function(z, numbers, index, work, out)`


@dataclass(frozen=True)
class Kernel:
    """A compiled map, its tables of numbers and of integers, and the rows of scratch that it needs."""

    function: Callable
    numbers: np.ndarray
    index: np.ndarray
    rows: int


@dataclass(frozen=True)
class Field:
    """Without a force the model is left alone."""

    drift: Kernel
    force: Kernel | None = None
