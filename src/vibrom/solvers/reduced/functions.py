"""A vector field that is made of Python functions, for models without compiled code.

The compiled loop calls back into Python for WIDTH states at once, so that such a model has every
integrator, and the same steps, samples and outcomes as a compiled one.
"""

import ctypes
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np

from vibrom.kernels.callback import call
from vibrom.kernels.lanes import WIDTH
from vibrom.solvers.reduced.field import Kernel, VectorField, field_kernel

Map = Callable[[np.ndarray], np.ndarray]  # of states (WIDTH, r), each row on its own


@field_kernel
def _call_back(y, numbers, index, work, out):
    # numbers: y, then out, as Python sees them; index: the address to call.
    r = len(y)
    for i in range(r):
        for w in range(WIDTH):
            numbers[i * WIDTH + w] = y[i, w]
    call(index[0])
    for i in range(r):
        for w in range(WIDTH):
            out[i, w] = numbers[(r + i) * WIDTH + w]


@contextmanager
def field_of(r: int, drift: Map, force: Map | None = None) -> Iterator[VectorField]:
    """The vector field drift(y) + force(y) a sin(w t) of r coordinates. It lives as long as the
    context, which raises on leaving what the functions raised.
    """
    errors: list[BaseException] = []
    alive = []

    def kernel(function: Map) -> Kernel:
        buffer = np.zeros((2, r, WIDTH))

        def answer() -> None:
            buffer[1] = np.nan
            if not errors:  # else the runs end soon, as NaN is no rate
                try:
                    buffer[1] = np.asarray(function(buffer[0].T)).T
                except BaseException as error:
                    errors.append(error)

        pointer = ctypes.CFUNCTYPE(None)(answer)
        alive.append(pointer)
        address = ctypes.cast(pointer, ctypes.c_void_p).value
        return Kernel(_call_back, buffer.reshape(-1), np.array([address], np.int64), 0, r)

    with np.errstate(all="ignore"):  # a model that blows up is a result, not a warning
        yield VectorField(kernel(drift), None if force is None else kernel(force))
    if errors:
        raise errors[0]
