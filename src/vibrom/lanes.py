"""Numbers of several states side by side in one register.

    x = load(array, i, width)        array[i, :width] of a contiguous float64 array (rows, width)
    x = fill(number, width)          the same number in every lane
    x = entry(table, k, e, states)   table[k, e] in every lane of so many states; for one state the lanes are elements: table[k, e:e + WIDTH]
    store(array, i, x)
    x + y,  x - y,  x * y,  x / y,  -x,  sqrt(x)        y lanes, or a number that all lanes share

A compiled kernel that is written in lanes does for `width` states what it says for one, in the instructions of one. Loops over the states leave
this to the compiler's vectoriser, which gives up on kernels of this size.
"""

import operator

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.extending import intrinsic, models, overload, register_model

WIDTH = 8  # doubles in an AVX-512 register
FREE = ("contract", "reassoc", "arcp", "nsz")  # a product and a sum may be one instruction; NaN stays NaN


def kernel(*signatures, fastmath: bool = True):
    """Compiles a function for these signatures and keeps it on disk, so that a second process does not compile again.

    A function made inside another is named after the numbers that it captured. Without that, specialisations that different processes compiled could carry
    one symbol, and a third process that loads both would call the wrong one.
    """

    def compile(function):
        captured = (cell.cell_contents for cell in function.__closure__ or ())
        function.__qualname__ = "_".join([function.__qualname__, *(str(value) for value in captured if isinstance(value, int))])
        return njit(list(signatures), cache=True, fastmath=fastmath, error_model="numpy")(function)

    return compile


class Lanes(types.Type):
    def __init__(self, width: int):
        super().__init__(name=f"Lanes({width})")
        self.width = width


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager, lanes: Lanes):
        super().__init__(manager, lanes, ir.VectorType(ir.DoubleType(), lanes.width))


def _address(context, builder, array_type, array, row, column, lanes: Lanes):
    """Where `lanes` numbers begin, in array[row, column:]."""
    view = context.make_array(array_type)(context, builder, array)
    row_length = builder.extract_value(view.shape, 1)
    first = builder.add(builder.mul(row, row_length), column)
    return builder.bitcast(builder.gep(view.data, [first]), ir.VectorType(ir.DoubleType(), lanes.width).as_pointer())


def _checked(array) -> None:
    if not (isinstance(array, types.Array) and array.ndim == 2 and array.layout == "C" and array.dtype == types.float64):
        raise TypingError(f"lanes are rows of a contiguous float64 array (rows, width), not of {array}")


def _index(context, builder, kind, value):
    return context.cast(builder, value, kind, types.intp)


def _literal(width) -> Lanes:
    if not isinstance(width, types.IntegerLiteral):
        raise TypingError("the number of lanes must be known when the kernel is compiled")
    return Lanes(width.literal_value)


@intrinsic(prefer_literal=True)
def load(typing, array, row, width):
    _checked(array)
    lanes = _literal(width)

    def generate(context, builder, signature, arguments):
        row = _index(context, builder, signature.args[1], arguments[1])
        first = ir.Constant(ir.IntType(64), 0)
        return builder.load(_address(context, builder, signature.args[0], arguments[0], row, first, lanes), align=8)

    return lanes(array, row, width), generate


@intrinsic(prefer_literal=True)
def entry(typing, table, row, column, states):
    _checked(table)
    alone = states.literal_value == 1
    lanes = Lanes(WIDTH) if alone else _literal(states)

    def generate(context, builder, signature, arguments):
        row, column = (_index(context, builder, signature.args[k], arguments[k]) for k in (1, 2))
        one = Lanes(WIDTH if alone else 1)
        value = builder.load(_address(context, builder, signature.args[0], arguments[0], row, column, one), align=8)
        if alone:
            return value
        return _spread(context, builder, types.float64, builder.extract_element(value, ir.Constant(ir.IntType(32), 0)), lanes)

    return lanes(table, row, column, states), generate


@intrinsic
def store(typing, array, row, value):
    _checked(array)

    def generate(context, builder, signature, arguments):
        row = _index(context, builder, signature.args[1], arguments[1])
        first = ir.Constant(ir.IntType(64), 0)
        builder.store(arguments[2], _address(context, builder, signature.args[0], arguments[0], row, first, signature.args[2]), align=8)
        return context.get_dummy_value()

    return types.void(array, row, value), generate


@intrinsic(prefer_literal=True)
def fill(typing, number, width):
    lanes = _literal(width)

    def generate(context, builder, signature, arguments):
        return _spread(context, builder, signature.args[0], arguments[0], lanes)

    return lanes(number, width), generate


def _spread(context, builder, kind, value, lanes: Lanes):
    """The number in every lane; lanes stay what they are."""
    if isinstance(kind, Lanes):
        return value
    vector = ir.VectorType(ir.DoubleType(), lanes.width)
    single = builder.insert_element(ir.Constant(vector, ir.Undefined), context.cast(builder, value, kind, types.float64), ir.Constant(ir.IntType(32), 0))
    return builder.shuffle_vector(single, ir.Constant(vector, ir.Undefined), ir.Constant(ir.VectorType(ir.IntType(32), lanes.width), [0] * lanes.width))


def _between(x, y) -> Lanes | None:
    """The lanes that an operation on x and y gives, or None where it is not one on lanes."""
    widths = {kind.width for kind in (x, y) if isinstance(kind, Lanes)}
    if len(widths) > 1:
        raise TypingError(f"{x} and {y} do not go together")
    both = all(isinstance(kind, (Lanes, types.Number)) for kind in (x, y))
    return Lanes(widths.pop()) if widths and both else None


def _binary(instruction: str, *operations):
    @intrinsic
    def apply(typing, x, y):
        lanes = _between(x, y)

        def generate(context, builder, signature, arguments):
            left, right = (_spread(context, builder, kind, value, lanes) for kind, value in zip(signature.args, arguments))
            return getattr(builder, instruction)(left, right, flags=FREE)

        return lanes(x, y), generate

    def on_lanes(x, y):
        if _between(x, y) is not None:
            return lambda x, y: apply(x, y)

    for operation in operations:
        overload(operation)(on_lanes)


_binary("fadd", operator.add, operator.iadd)
_binary("fsub", operator.sub, operator.isub)
_binary("fmul", operator.mul, operator.imul)
_binary("fdiv", operator.truediv, operator.itruediv)


@overload(operator.neg)
def _negative(x):
    if isinstance(x, Lanes):
        return lambda x: 0.0 - x


@intrinsic
def _sqrt(typing, x):
    def generate(context, builder, signature, arguments):
        vector = arguments[0].type
        root = cgutils.get_or_insert_function(builder.module, ir.FunctionType(vector, [vector]), f"llvm.sqrt.v{x.width}f64")
        return builder.call(root, arguments)

    return x(x), generate


@overload(np.sqrt)
def _root(x):
    if isinstance(x, Lanes):
        return lambda x: _sqrt(x)
