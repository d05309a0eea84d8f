"""Loops that run when a kernel is compiled, and leave straight code: one text for bodies of two and
of three dimensions.

    @unrolled
    def dot(x, y):                       plain Python: any loops, lists and tuples
        return sum_of(a * b for a, b in zip(x, y))

Kernels call such a function with lanes, tuples of lanes, places (whole numbers; those that are
known when the kernel is compiled are plain ones) and arrays of lanes:

    array.get(i, width)                  number i of each of `width` states, as `lanes.get`
    array.put(i, x)                      and back
    array.entry(k, e, states)            as `lanes.entry`

It returns lanes, a tuple of them, or nothing. It may call other such functions as
`other.plain(...)`.
"""

import inspect
from collections.abc import Callable, Iterable
from functools import reduce
from operator import add
from typing import Any

from llvmlite import ir
from numba import types
from numba.core.errors import TypingError
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

from vibrom.kernels.lanes import WIDTH
from vibrom.kernels.vector import FUSED, Lanes, common, spread


def sum_of(terms: Iterable) -> Any:
    """From the first to the last, without a zero before them."""
    return reduce(add, terms)


def unrolled(function: Callable) -> Callable:
    """A function that is run for each kernel that calls it, once to know what it returns and once
    to write its arithmetic into the kernel.
    """

    def write(typing, *kinds):
        made = function(*(_Maker(None, None).value(kind, None) for kind in kinds))
        returned = _kind(made)

        def lower(context, builder, signature, arguments):
            maker = _Maker(context, builder)
            made = function(*map(maker.value, signature.args, arguments))
            if isinstance(made, tuple):
                values = [item.value for item in made]
                return context.make_tuple(builder, signature.return_type, values)
            return context.get_dummy_value() if made is None else made.value

        return returned(*kinds), lower

    known = [inspect.Parameter("typing", inspect.Parameter.POSITIONAL_OR_KEYWORD)]
    known += inspect.signature(function).parameters.values()
    write.__signature__ = inspect.Signature(known)  # type: ignore[attr-defined]
    write.__name__ = write.__qualname__ = function.__name__
    made = intrinsic(prefer_literal=True)(write)
    made.plain = function
    return made


def _kind(made: Any) -> types.Type:
    if made is None:
        return types.void
    if isinstance(made, tuple):
        return types.UniTuple(made[0].lanes, len(made))
    if not isinstance(made, Lane):
        raise TypingError(f"an unrolled function returns lanes, not {type(made).__name__}")
    return made.lanes


class _Maker:
    """What stands for arguments while a function runs; without a builder only their kinds count."""

    def __init__(self, context, builder):
        self.context, self.builder = context, builder

    def value(self, kind: types.Type, value: Any) -> Any:
        """Lanes, tuples of them, places and arrays."""
        if isinstance(kind, types.IntegerLiteral):
            return kind.literal_value
        if isinstance(kind, types.Integer):
            if self.builder:
                value = self.context.cast(self.builder, value, kind, types.intp)
            return Place(self, value)
        if isinstance(kind, Lanes):
            return Lane(self, value, kind)
        if isinstance(kind, types.BaseTuple):
            each = range(len(kind))
            parts = [self.builder.extract_value(value, i) if self.builder else None for i in each]
            return tuple(map(self.value, kind, parts))
        if isinstance(kind, types.Array) and kind.layout == "C" and kind.dtype == types.float64:
            return Array(self, kind, value)
        raise TypingError(f"{kind} is nothing that an unrolled function takes")


class Lane:
    """Lanes while a function runs, with their arithmetic."""

    def __init__(self, maker: _Maker, value: Any, lanes: Lanes):
        self.maker, self.value, self.lanes = maker, value, lanes

    def _with(self, other: Any, instruction: str, swapped: bool = False) -> "Lane":
        if not isinstance(other, Lane):
            other = Lane(self.maker, self.lanes.constant(float(other)), self.lanes)
        lanes, builder = common(self.lanes, other.lanes), self.maker.builder
        if not builder:
            return Lane(self.maker, None, lanes)
        left, right = (other, self) if swapped else (self, other)
        value = getattr(builder, instruction)(left.value, right.value, flags=FUSED)
        return Lane(self.maker, value, lanes)

    def __add__(self, other):
        return self._with(other, "fadd")

    def __radd__(self, other):
        return self._with(other, "fadd", True)

    def __sub__(self, other):
        return self._with(other, "fsub")

    def __rsub__(self, other):
        return self._with(other, "fsub", True)

    def __mul__(self, other):
        return self._with(other, "fmul")

    def __rmul__(self, other):
        return self._with(other, "fmul", True)


class Place:
    """A whole number that is not known when the kernel is compiled: a row of an array."""

    def __init__(self, maker: _Maker, value: Any):
        self.maker, self.value = maker, value

    def _with(self, other: Any, instruction: str) -> "Place":
        builder = self.maker.builder
        if not builder:
            return self
        if not isinstance(other, Place):
            other = Place(self.maker, ir.Constant(self.value.type, other))
        return Place(self.maker, getattr(builder, instruction)(self.value, other.value))

    def __add__(self, other):
        return self._with(other, "add")

    def __mul__(self, other):
        return self._with(other, "mul")

    __radd__, __rmul__ = __add__, __mul__


class Array:
    """An array of lanes."""

    def __init__(self, maker: _Maker, kind: types.Array, value: Any):
        self.maker, self.kind = maker, kind
        if maker.builder:
            self.made = make_array(kind)(maker.context, maker.builder, value)

    def _place(self, row: Any) -> Any:
        if isinstance(row, Place):
            return row.value
        return ir.Constant(self.maker.context.get_value_type(types.intp), row)

    def _pointer(self, first: Any, lanes: Lanes) -> Any:
        builder = self.maker.builder
        pointer = builder.gep(self.made.data, [first])
        return builder.bitcast(pointer, lanes.vector.as_pointer())

    def get(self, row: Any, width: int) -> Lane:
        """Row `row` of (rows, width)."""
        lanes, builder, value = Lanes(width), self.maker.builder, None
        if builder:
            pointer = self._pointer(self._place(row * width), lanes)
            value = builder.load(pointer, align=8)
        return Lane(self.maker, value, lanes)

    def put(self, row: Any, x: Lane) -> None:
        """And back."""
        if builder := self.maker.builder:
            pointer = self._pointer(self._place(row * x.lanes.width), x.lanes)
            builder.store(x.value, pointer, align=8)

    def entry(self, row: Any, column: Any, states: int) -> Lane:
        """An entry of a table that all states share; of one state alone those of WIDTH elements."""
        lanes, builder, value = Lanes(WIDTH if states == 1 else states), self.maker.builder, None
        if builder:
            stride = builder.extract_value(self.made.shape, 1)
            first = builder.mul(self._place(row), stride)
            first = builder.add(first, self._place(column))
            if states == 1:
                value = builder.load(self._pointer(first, lanes), align=8)
            else:
                number = builder.load(builder.gep(self.made.data, [first]), align=8)
                value = spread(self.maker.context, builder, types.float64, number, lanes)
        return Lane(self.maker, value, lanes)
