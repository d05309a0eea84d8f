"""Numbers of several states side by side in one register.

    x = get(array, i, width)        number i of the groups of `width` in a contiguous array of
    floats
    put(array, i, x)               and back
    x = cut(array, k, width)         the `width` numbers from place k on;  paste(array, k, x) puts
    them back
    x = fill(number, width)          the same number in every lane
    x = entry(table, k, e, states)   table[k, e] in every lane of so many states; for one state the
    lanes are elements: table[k, e:e + WIDTH]
    x + y,  x - y,  x * y,  x / y    y lanes, or a number that all lanes share
    room(rows, width)                an array for lanes
    sqrt(x), floor(x), positive(x, yes, no), power_of_two(x)

A compiled kernel that is written in lanes does for `width` states what it says for one, in the
instructions of one. Loops over the states do not: a loop over a constant eight is unrolled to
scalar code before LLVM looks for vectors. No operation mixes lanes: what a lane computes does not
depend on its neighbours, to the last bit.
"""

import operator
from hashlib import sha256
from pathlib import Path
from types import FunctionType

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global
from numba.core.typing.templates import signature as typed
from numba.extending import intrinsic, models, register_jitable, register_model

WIDTH = 8  # doubles in an AVX-512 register
FUSED = ("contract",)  # a b + c in one instruction; nothing else may be reordered


def edition(function) -> str:
    """Digest of the other files that are part of a kernel, this one and those of the compiled
    functions that it calls: numba looks at its own file only.
    """
    called = (function.__globals__.get(name) for name in function.__code__.co_names)
    sources = (getattr(value, "py_func", value) for value in called)
    files = {
        __file__,
        *(source.__code__.co_filename for source in sources if isinstance(source, FunctionType)),
    }
    return sha256(b"".join(Path(file).read_bytes() for file in sorted(files))).hexdigest()[:8]


def kernel(*signatures, fastmath: bool | set[str] = True, nogil: bool = False):
    """Compiles a function for these signatures and keeps it on disk, so that a second process does
    not compile again; with `nogil` threads may run it at the same time.

    A function made inside another is named after the numbers that it captured. Without that,
    specialisations that different processes compiled could carry one symbol, and a third process
    that loads both would call the wrong one.
    """

    def compile(function):
        captured = (cell.cell_contents for cell in function.__closure__ or ())
        function.__qualname__ = "_".join(
            [
                function.__qualname__,
                *(str(value) for value in captured if isinstance(value, int)),
                edition(function),
            ]
        )
        return njit(
            list(signatures), cache=True, fastmath=fastmath, nogil=nogil, error_model="numpy"
        )(function)

    return compile


@register_jitable
def room(rows: int, width: int) -> np.ndarray:
    """(rows, width), not filled, from the beginning of a cache line on: a register that lies across
    two lines takes twice as long to load.
    """
    numbers = np.empty(rows * width + WIDTH)
    first = -numbers.ctypes.data % (8 * WIDTH) // 8
    return numbers[first : first + rows * width].reshape(rows, width)


class Lanes(types.Type):
    def __init__(self, width: int):
        super().__init__(name=f"Lanes({width})")
        self.width = width

    @property
    def vector(self) -> ir.VectorType:
        return ir.VectorType(ir.DoubleType(), self.width)

    def constant(self, number: float) -> ir.Constant:
        return ir.Constant(self.vector, [number] * self.width)


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager, lanes: Lanes):
        super().__init__(manager, lanes, lanes.vector)


def _literal(width) -> Lanes:
    if not isinstance(width, types.IntegerLiteral):
        raise TypingError("the number of lanes must be known when the kernel is compiled")
    return Lanes(width.literal_value)


def _checked(array) -> None:
    if not (
        isinstance(array, types.Array) and array.layout == "C" and array.dtype == types.float64
    ):
        raise TypingError(f"lanes lie in contiguous float64 arrays, not in {array}")


def _integer(context, builder, signature, arguments, place: int):
    return context.cast(builder, arguments[place], signature.args[place], types.intp)


def _pointer(context, builder, signature, arguments, first, lanes: Lanes):
    data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
    return builder.bitcast(builder.gep(data, [first]), lanes.vector.as_pointer())


def _spread(context, builder, kind, value, lanes: Lanes):
    """A number in every lane; lanes stay what they are."""
    if isinstance(kind, Lanes):
        return value
    value, undefined = (
        context.cast(builder, value, kind, types.float64),
        ir.Constant(lanes.vector, ir.Undefined),
    )
    single = builder.insert_element(undefined, value, ir.Constant(ir.IntType(32), 0))
    return builder.shuffle_vector(
        single,
        undefined,
        ir.Constant(ir.VectorType(ir.IntType(32), lanes.width), [0] * lanes.width),
    )


def _reader(grouped: bool):
    @intrinsic(prefer_literal=True)
    def read(typing, array, place, width):
        _checked(array)
        lanes = _literal(width)

        def lower(context, builder, signature, arguments):
            first = _integer(context, builder, signature, arguments, 1)
            first = builder.mul(first, ir.Constant(first.type, lanes.width)) if grouped else first
            return builder.load(
                _pointer(context, builder, signature, arguments, first, lanes), align=8
            )

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
            builder.store(
                arguments[2],
                _pointer(context, builder, signature, arguments, first, value),
                align=8,
            )
            return context.get_dummy_value()

        return types.void(array, place, value), lower

    return write


get, put, cut, paste = _reader(True), _writer(True), _reader(False), _writer(False)


@intrinsic(prefer_literal=True)
def fill(typing, number, width):
    lanes = _literal(width)

    def lower(context, builder, signature, arguments):
        return _spread(context, builder, signature.args[0], arguments[0], lanes)

    return lanes(number, width), lower


@intrinsic(prefer_literal=True)
def entry(typing, table, row, column, states):
    _checked(table)
    alone = _literal(states).width == 1
    lanes = Lanes(WIDTH) if alone else _literal(states)

    def lower(context, builder, signature, arguments):
        row, column = (_integer(context, builder, signature, arguments, place) for place in (1, 2))
        length = builder.extract_value(
            context.make_array(signature.args[0])(context, builder, arguments[0]).shape, 1
        )
        first = builder.add(builder.mul(row, length), column)
        if alone:
            return builder.load(
                _pointer(context, builder, signature, arguments, first, lanes), align=8
            )
        value = builder.load(
            _pointer(context, builder, signature, arguments, first, Lanes(1)), align=8
        )
        return _spread(
            context,
            builder,
            types.float64,
            builder.extract_element(value, ir.Constant(ir.IntType(32), 0)),
            lanes,
        )

    return lanes(table, row, column, states), lower


def _between(*kinds) -> Lanes | None:
    """The lanes that an operation gives, or None where it is not one on lanes."""
    widths = {kind.width for kind in kinds if isinstance(kind, Lanes)}
    if len(widths) > 1:
        raise TypingError(f"lanes of widths {sorted(widths)} do not go together")
    return (
        Lanes(widths.pop())
        if widths and all(isinstance(kind, (Lanes, types.Number)) for kind in kinds)
        else None
    )


def _operator(instruction: str, *symbols) -> None:
    def lower(context, builder, signature, arguments):
        left, right = (
            _spread(context, builder, kind, value, signature.return_type)
            for kind, value in zip(signature.args, arguments)
        )
        return getattr(builder, instruction)(left, right, flags=FUSED)

    class Typing(AbstractTemplate):
        def generic(self, arguments, keywords):
            lanes = _between(*arguments)
            # Numbers are taken as floats, so that a whole number has one way to be spread.
            return lanes and typed(
                lanes, *(kind if isinstance(kind, Lanes) else types.float64 for kind in arguments)
            )

    for symbol in symbols:
        infer_global(symbol)(Typing)
        for kinds in ((Lanes, Lanes), (Lanes, types.float64), (types.float64, Lanes)):
            lower_builtin(symbol, *kinds)(lower)


# Not by `overload`: its functions would carry one name for all operators, and a name decides which
# of two pieces of code on disk is meant.
_operator("fadd", operator.add, operator.iadd)
_operator("fsub", operator.sub, operator.isub)
_operator("fmul", operator.mul, operator.imul)
_operator("fdiv", operator.truediv, operator.itruediv)


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
    lanes = _between(x, yes, no)

    def lower(context, builder, signature, arguments):
        x, yes, no = (
            _spread(context, builder, kind, value, lanes)
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
        bits = builder.shl(
            builder.add(whole, ir.Constant(integers, [1023] * n.width)),
            ir.Constant(integers, [52] * n.width),
        )
        return builder.bitcast(bits, n.vector)

    return n(n), lower
