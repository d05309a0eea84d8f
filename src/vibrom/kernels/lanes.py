"""Numbers of several states side by side in one register: what kernels are written with.

    x = get(array, i, width)         number i of each of `width` states: row i of (rows, width)
    put(array, i, x)                 and back
    x = cut(array, k, width)         the `width` numbers from place k on
    paste(array, k, x)               and back
    x = fill(number, width)          the same number in every lane
    x = entry(table, k, e, states)   table[k, e] in every lane, one for each state; of one state
                                     alone the lanes are elements: table[k, e:e + WIDTH]
    x + y,  x - y,  x * y,  x / y    y lanes, or a number that all lanes share
    sqrt(x), floor(x), positive(x, yes, no), power_of_two(x)
    room(rows, width)                an array of lanes
    stack(rows, width)               a small one, whose size is known when the kernel is compiled

Arithmetic written once in lanes runs on `width` states at once (SIMD); plain loops over states are
not vectorised. No operation mixes lanes: what a lane computes does not depend on its neighbours, to
the last bit.
"""

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.extending import intrinsic, register_jitable
from numba.np.arrayobj import make_array, populate_array

from vibrom.kernels.compiled import edition, inlined, kernel, part
from vibrom.kernels.vector import Lanes, common, spread

__all__ = [
    "WIDTH",
    "cut",
    "edition",
    "entry",
    "fill",
    "floor",
    "get",
    "inlined",
    "kernel",
    "part",
    "paste",
    "positive",
    "power_of_two",
    "put",
    "room",
    "sqrt",
    "stack",
]

WIDTH = 8  # doubles in an AVX-512 register
LINE = 64  # bytes of a cache line; a register that lies across two takes twice as long to read


@register_jitable
def room(rows: int, width: int) -> np.ndarray:
    """(rows, width), not filled, from the beginning of a cache line on."""
    numbers = np.empty(rows * width + LINE // 8)
    first = -numbers.ctypes.data % LINE // 8
    return numbers[first : first + rows * width].reshape(rows, width)


def _known(number) -> int:
    if not isinstance(number, types.IntegerLiteral):
        raise TypingError("lanes and rows on the stack must be counted when a kernel is compiled")
    return number.literal_value


@intrinsic(prefer_literal=True)
def stack(typing, rows, width):
    """(rows, width) on the stack, not filled: as nothing else can refer to it, the compiler keeps
    its rows in registers. For some tens of rows, and no longer than the kernel runs.
    """
    shape, kind = (_known(rows), _known(width)), types.Array(types.float64, 2, "C")

    def lower(context, builder, signature, arguments):
        number, size = ir.DoubleType(), context.get_value_type(types.intp)
        with builder.goto_entry_block():
            numbers = builder.alloca(ir.ArrayType(number, shape[0] * shape[1]))
            numbers.align = LINE
        array = make_array(kind)(context, builder)
        populate_array(
            array,
            data=builder.bitcast(numbers, number.as_pointer()),
            shape=[ir.Constant(size, extent) for extent in shape],
            strides=[ir.Constant(size, 8 * shape[1]), ir.Constant(size, 8)],
            itemsize=ir.Constant(size, 8),
            meminfo=None,
        )
        return array._getvalue()

    return kind(rows, width), lower


def _checked(array) -> None:
    if not (
        isinstance(array, types.Array) and array.layout == "C" and array.dtype == types.float64
    ):
        raise TypingError(f"lanes lie in contiguous float64 arrays, not in {array}")


def _integer(context, builder, signature, arguments, place: int):
    return context.cast(builder, arguments[place], signature.args[place], types.intp)


def _pointer(context, builder, signature, arguments, first, lanes: Lanes):
    data = make_array(signature.args[0])(context, builder, arguments[0]).data
    return builder.bitcast(builder.gep(data, [first]), lanes.vector.as_pointer())


def _reader(grouped: bool):
    @intrinsic(prefer_literal=True)
    def read(typing, array, place, width):
        _checked(array)
        lanes = Lanes(_known(width))

        def lower(context, builder, signature, arguments):
            first = _integer(context, builder, signature, arguments, 1)
            first = builder.mul(first, ir.Constant(first.type, lanes.width)) if grouped else first
            pointer = _pointer(context, builder, signature, arguments, first, lanes)
            return builder.load(pointer, align=8)

        return lanes(array, place, width), lower

    return read


def _writer(grouped: bool):
    @intrinsic
    def write(typing, array, place, value):
        _checked(array)
        if not isinstance(value, Lanes):
            raise TypingError(f"{value} is no lanes; fill them with it")

        def lower(context, builder, signature, arguments):
            first = _integer(context, builder, signature, arguments, 1)
            first = builder.mul(first, ir.Constant(first.type, value.width)) if grouped else first
            pointer = _pointer(context, builder, signature, arguments, first, value)
            builder.store(arguments[2], pointer, align=8)
            return context.get_dummy_value()

        return types.void(array, place, value), lower

    return write


get, put, cut, paste = _reader(True), _writer(True), _reader(False), _writer(False)


@intrinsic(prefer_literal=True)
def fill(typing, number, width):
    """The same number in every lane."""
    lanes = Lanes(_known(width))

    def lower(context, builder, signature, arguments):
        return spread(context, builder, signature.args[0], arguments[0], lanes)

    return lanes(number, width), lower


@intrinsic(prefer_literal=True)
def entry(typing, table, row, column, states):
    """An entry of a table that all states share; of one state alone, those of WIDTH elements."""
    _checked(table)
    alone = _known(states) == 1
    lanes = Lanes(WIDTH if alone else _known(states))

    def lower(context, builder, signature, arguments):
        row, column = (_integer(context, builder, signature, arguments, place) for place in (1, 2))
        array = make_array(signature.args[0])(context, builder, arguments[0])
        first = builder.add(builder.mul(row, builder.extract_value(array.shape, 1)), column)
        if alone:
            pointer = _pointer(context, builder, signature, arguments, first, lanes)
            return builder.load(pointer, align=8)
        number = builder.load(builder.gep(array.data, [first]), align=8)
        return spread(context, builder, types.float64, number, lanes)

    return lanes(table, row, column, states), lower


def _function(name: str):
    @intrinsic
    def emit(typing, x):
        def lower(context, builder, signature, arguments):
            function = cgutils.get_or_insert_function(
                builder.module, ir.FunctionType(x.vector, [x.vector]), f"llvm.{name}.v{x.width}f64"
            )
            return builder.call(function, arguments)

        return x(x), lower

    return emit


floor, sqrt = _function("floor"), _function("sqrt")


@intrinsic
def positive(typing, x, yes, no):
    """`yes` where x > 0, else `no`."""
    lanes = common(x, yes, no)

    def lower(context, builder, signature, arguments):
        x, yes, no = (
            spread(context, builder, kind, value, lanes)
            for kind, value in zip(signature.args, arguments)
        )
        return builder.select(builder.fcmp_ordered(">", x, lanes.constant(0.0)), yes, no)

    return lanes(x, yes, no), lower


@intrinsic
def power_of_two(typing, n):
    """2^n of whole numbers n in -1022..1023: the bits of the exponent."""
    integers = ir.VectorType(ir.IntType(64), n.width)

    def lower(context, builder, signature, arguments):
        whole = builder.fptosi(arguments[0], integers)
        biased = builder.add(whole, ir.Constant(integers, [1023] * n.width))
        bits = builder.shl(biased, ir.Constant(integers, [52] * n.width))
        return builder.bitcast(bits, n.vector)

    return n(n), lower
