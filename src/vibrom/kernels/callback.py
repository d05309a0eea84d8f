"""Compiled code that calls functions by their addresses: a C function, which may be a Python
function that ctypes wraps, or another kernel.

A kernel may be an argument of another one; each call then asks for its address anew, which takes
0.1 ms, as long as a short kernel runs.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic


@intrinsic
def call(typing, address):
    """Calls the C function `void f(void)` at this address (an int64)."""

    def lower(context, builder, signature, arguments):
        kind = ir.FunctionType(ir.VoidType(), []).as_pointer()
        builder.call(builder.inttoptr(arguments[0], kind), [])
        return context.get_dummy_value()

    return types.void(address), lower


@lru_cache(maxsize=256)
def address_of(kernel: Any, signature: Any) -> int:
    """Of a compiled kernel."""
    compiled = kernel.get_compile_result(signature)
    return int(compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name))


def kernel_at(kind: types.FunctionType) -> Callable:
    """What compiled code makes of an address (an int64): a kernel of this type."""

    @intrinsic
    def found(typing, address):
        def lower(context, builder, signature, arguments):
            kernel = cgutils.create_struct_proxy(kind)(context, builder)
            kernel.jit_addr = builder.inttoptr(arguments[0], kernel.jit_addr.type)
            return kernel._getvalue()

        return kind(types.int64), lower

    return found
