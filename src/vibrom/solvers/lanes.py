"""Eight states side by side in one variable of compiled code.

`Lanes` is a numba type that LLVM knows as <8 x double>: +, -, *, / act lane by lane, also with a scalar, and become one AVX-512 instruction, or two or
four of narrower machines. Inner loops over a constant eight do not: they are unrolled to scalar code before LLVM looks for vectors. No operation mixes
lanes, so what a lane computes does not depend on its neighbours, to the last bit.

A `Kernel` is a map of r reduced coordinates to r rates for the states of all lanes; a `Field` is made of two:  dz/dt = drift(z) + force(z) u(t).
"""

import operator
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global
from numba.core.typing.templates import signature as typed
from numba.extending import intrinsic, models, register_model

WIDTH = 8
_vector, _integers = ir.VectorType(ir.DoubleType(), WIDTH), ir.VectorType(ir.IntType(64), WIDTH)
_fused = ("contract",)  # a b + c in one instruction; nothing else may be reordered

# out (r, 8) = f(z (r, 8)); numbers and index are the kernel's own tables, work its scratch of `rows` times 8.
KERNEL = types.void(types.float64[:, ::1], types.float64[::1], types.int64[::1], types.float64[::1], types.float64[:, ::1])


def kernel(function: Callable) -> Callable:
    """Compiles `function(z, numbers, index, work, out)`, kept on disk. A change in this file needs the `__pycache__` of its kernels removed."""
    return njit([KERNEL], cache=True, error_model="numpy")(function)


@dataclass(frozen=True)
class Kernel:
    """A compiled map, its tables of numbers and of integers, and the rows of scratch that it needs."""

    function: Callable
    numbers: np.ndarray
    index: np.ndarray
    rows: int


@dataclass(frozen=True)
class Field:
    """The right-hand side of a reduced model; without a force the model is left alone."""

    drift: Kernel
    force: Kernel | None = None


class LanesType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Lanes")


Lanes = LanesType()


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager, kind) -> None:
        super().__init__(manager, kind, _vector)


def _spread(context, builder, value, kind):
    """A scalar in every lane; lanes as they are."""
    if isinstance(kind, LanesType):
        return value
    value = context.cast(builder, value, kind, types.float64)
    one = builder.insert_element(ir.Constant(_vector, ir.Undefined), value, ir.Constant(ir.IntType(32), 0))
    return builder.shuffle_vector(one, ir.Constant(_vector, ir.Undefined), ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH))


def _operator(symbol: Callable, instruction: str) -> None:
    def lower(context, builder, signature, arguments):
        left, right = (_spread(context, builder, value, kind) for value, kind in zip(arguments, signature.args))
        return getattr(builder, instruction)(left, right, flags=_fused)

    @infer_global(symbol)
    class Typing(AbstractTemplate):
        def generic(self, arguments, keywords):
            # Numbers are taken as floats, so that a whole number has one way to be spread.
            if Lanes in arguments and all(isinstance(kind, (LanesType, types.Number)) for kind in arguments):
                return typed(Lanes, *(kind if isinstance(kind, LanesType) else types.float64 for kind in arguments))

    for kinds in ((Lanes, Lanes), (Lanes, types.float64), (types.float64, Lanes)):
        lower_builtin(symbol, *kinds)(lower)


# Not by `overload`: its functions would carry one name for all four operators, and a name decides which of two cached pieces of code is meant.
for _symbol, _instruction in ((operator.add, "fadd"), (operator.sub, "fsub"), (operator.mul, "fmul"), (operator.truediv, "fdiv")):
    _operator(_symbol, _instruction)


def _pointer(context, builder, kind, array, row):
    data = builder.bitcast(context.make_array(kind)(context, builder, array).data, _vector.as_pointer())
    return builder.gep(data, [row])


@intrinsic
def load(typing, array, row):
    """Lanes number `row` of a contiguous array of floats."""
    def lower(context, builder, signature, arguments):
        row = context.cast(builder, arguments[1], signature.args[1], types.intp)
        return builder.load(_pointer(context, builder, signature.args[0], arguments[0], row), align=8)

    return Lanes(array, row), lower


@intrinsic
def store(typing, array, row, value):
    """Puts lanes, or a scalar in every lane, at number `row` of a contiguous array of floats."""
    def lower(context, builder, signature, arguments):
        row = context.cast(builder, arguments[1], signature.args[1], types.intp)
        lanes = _spread(context, builder, arguments[2], signature.args[2])
        builder.store(lanes, _pointer(context, builder, signature.args[0], arguments[0], row), align=8)
        return context.get_dummy_value()

    return types.void(array, row, value), lower


@intrinsic
def spread(typing, value):
    """A scalar in every lane."""
    def lower(context, builder, signature, arguments):
        return _spread(context, builder, arguments[0], signature.args[0])

    return Lanes(value), lower


@intrinsic
def positive(typing, a, yes, no):
    """`yes` where a > 0, else `no`."""
    def lower(context, builder, signature, arguments):
        a, yes, no = (_spread(context, builder, value, kind) for value, kind in zip(arguments, signature.args))
        return builder.select(builder.fcmp_ordered(">", a, ir.Constant(_vector, [0.0] * WIDTH)), yes, no)

    return Lanes(a, yes, no), lower


def _function(name: str):
    @intrinsic
    def emit(typing, a):
        def lower(context, builder, signature, arguments):
            function = cgutils.get_or_insert_function(builder.module, ir.FunctionType(_vector, [_vector]), f"llvm.{name}.v{WIDTH}f64")
            return builder.call(function, arguments)

        return Lanes(a), lower

    return emit


floor, sqrt = _function("floor"), _function("sqrt")


@intrinsic
def power_of_two(typing, n):
    """2^n of whole numbers n in -1022..1023: the bits of the exponent."""
    def lower(context, builder, signature, arguments):
        whole = builder.fptosi(arguments[0], _integers)
        bits = builder.shl(builder.add(whole, ir.Constant(_integers, [1023] * WIDTH)), ir.Constant(_integers, [52] * WIDTH))
        return builder.bitcast(bits, _vector)

    return Lanes(n), lower
