"""Compiled code that calls a C function by its address, which may be a Python function that ctypes
wraps.
"""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic


@intrinsic
def call(typing, address):
    """Calls the C function `void f(void)` at this address (an int64)."""

    def lower(context, builder, signature, arguments):
        kind = ir.FunctionType(ir.VoidType(), []).as_pointer()
        builder.call(builder.inttoptr(arguments[0], kind), [])
        return context.get_dummy_value()

    return types.void(address), lower
