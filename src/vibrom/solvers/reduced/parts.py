"""What compiled loops are put together from: functions that are compiled into them, and records of
arrays that they pass on.
"""

from typing import Any

from numba import njit, types

from vibrom.kernels.lanes import WIDTH, room

_ARITHMETIC: dict[str, Any] = {"fastmath": {"contract"}, "error_model": "numpy"}
# Only loops call them: what Python and C would need to call them takes a third of compiling.
_INSIDE: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
# A function that makes arrays.
maker = njit(**_ARITHMETIC, **_INSIDE)
# A function that reads and fills arrays of its caller. It counts no references to them: counting
# takes twice the time of all arithmetic of a polynomial model. Numba knows the option, and does not
# document it.
part = njit(**_ARITHMETIC, **_INSIDE, _nrt=False)


def record(of: type, *kinds: types.Type) -> types.Type:
    """The type by which numba knows a named tuple `of` fields of these types."""
    return types.BaseTuple.from_types(kinds, of)


@maker
def zeros(rows):
    """(rows, WIDTH) of zeros that begin at a cache line."""
    numbers = room(rows, WIDTH)
    numbers[:] = 0.0
    return numbers
