"""Lanes as a type of compiled code: several doubles in one LLVM vector, and their arithmetic.

    x + y,  x - y,  x * y,  x / y     for each lane; y lanes, or a number that all lanes share

`lanes` is what kernels are written with; this file teaches numba the type. No operation mixes
lanes: what a lane computes does not depend on its neighbours, to the last bit.
"""

import operator

from llvmlite import ir
from numba import types
from numba.core.errors import TypingError
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global
from numba.core.typing.templates import signature as typed
from numba.extending import models, register_model

FUSED = ("contract",)  # a b + c in one instruction; nothing else may be reordered


class Lanes(types.Type):
    """`width` doubles in one register, or in as many registers as they need."""

    def __init__(self, width: int):
        super().__init__(name=f"Lanes({width})")
        self.width = width

    @property
    def vector(self) -> ir.VectorType:
        """Its LLVM type."""
        return ir.VectorType(ir.DoubleType(), self.width)

    def constant(self, number: float) -> ir.Constant:
        """The same number in every lane."""
        return ir.Constant(self.vector, [number] * self.width)


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager, lanes: Lanes):
        super().__init__(manager, lanes, lanes.vector)


def spread(context, builder, kind, value, lanes: Lanes):
    """A number in every lane; lanes stay what they are."""
    if isinstance(kind, Lanes):
        return value
    value = context.cast(builder, value, kind, types.float64)
    undefined = ir.Constant(lanes.vector, ir.Undefined)
    single = builder.insert_element(undefined, value, ir.Constant(ir.IntType(32), 0))
    first = ir.Constant(ir.VectorType(ir.IntType(32), lanes.width), [0] * lanes.width)
    return builder.shuffle_vector(single, undefined, first)


def common(*kinds) -> Lanes | None:
    """The lanes that an operation gives, or None where it is not one on lanes."""
    widths = {kind.width for kind in kinds if isinstance(kind, Lanes)}
    if len(widths) > 1:
        raise TypingError(f"lanes of widths {sorted(widths)} do not go together")
    if widths and all(isinstance(kind, (Lanes, types.Number)) for kind in kinds):
        return Lanes(widths.pop())
    return None


def _operator(instruction: str, *symbols) -> None:
    def lower(context, builder, signature, arguments):
        left, right = (
            spread(context, builder, kind, value, signature.return_type)
            for kind, value in zip(signature.args, arguments)
        )
        return getattr(builder, instruction)(left, right, flags=FUSED)

    class Typing(AbstractTemplate):
        def generic(self, arguments, keywords):
            lanes = common(*arguments)
            if lanes is None:
                return None
            # Numbers are taken as floats, so that there is one way to spread them.
            kinds = (kind if isinstance(kind, Lanes) else types.float64 for kind in arguments)
            return typed(lanes, *kinds)

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
