"""Four float64 in one register: a Numba type backed by LLVM's ``<4 x double>``.

LLVM does not vectorise a transfer by itself, because it cannot prove that grid and particles do
not alias. A vertex's record is two such vectors, (m, mv) and (-, f), so that the transfers become
vector multiply-adds. Operations: `pack`, `lane`, `load`, `store`, and ``+ - *`` between vectors
and between a vector and a float. Products and sums may contract to fused multiply-adds.
"""

import operator

from llvmlite import ir
from numba.core import types
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, models, register_model

_VECTOR = ir.VectorType(ir.DoubleType(), 4)
_LANE = ir.IntType(32)


class Vec4Type(types.Type):
    """Numba's type of a vector of four float64."""

    def __init__(self):
        super().__init__(name="Vec4")


vec4 = Vec4Type()


@register_model(Vec4Type)
class _Vec4Model(models.PrimitiveModel):
    def __init__(self, manager, fe_type):
        super().__init__(manager, fe_type, _VECTOR)


def _splat(builder, scalar):
    undefined = ir.Constant(_VECTOR, ir.Undefined)
    first = builder.insert_element(undefined, scalar, ir.Constant(_LANE, 0))
    mask = ir.Constant(ir.VectorType(_LANE, 4), [0, 0, 0, 0])
    return builder.shuffle_vector(first, undefined, mask)


def _address(context, builder, array_type, array, index):
    data = context.make_array(array_type)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), _VECTOR.as_pointer())


@intrinsic
def pack(typing_context, a, b, c, d):
    """Vector of four floats."""

    def generate(context, builder, sig, args):
        vector = ir.Constant(_VECTOR, ir.Undefined)
        for number, value in enumerate(args):
            vector = builder.insert_element(vector, value, ir.Constant(_LANE, number))
        return vector

    return vec4(types.float64, types.float64, types.float64, types.float64), generate


@intrinsic(prefer_literal=True)
def lane(typing_context, vector, number):
    """Element `number` (a literal) of the vector."""
    if not isinstance(number, types.IntegerLiteral):
        return None
    position = ir.Constant(_LANE, number.literal_value)

    def generate(context, builder, sig, args):
        return builder.extract_element(args[0], position)

    return types.float64(vec4, number), generate


@intrinsic
def load(typing_context, array, index):
    """Read ``array[index:index + 4]``; the address must be a multiple of 32 bytes."""

    def generate(context, builder, sig, args):
        return builder.load(_address(context, builder, sig.args[0], *args), align=32)

    return vec4(array, types.int64), generate


@intrinsic
def store(typing_context, array, index, vector):
    """Write a vector to ``array[index:index + 4]``; the address must be a multiple of 32 bytes."""

    def generate(context, builder, sig, args):
        builder.store(args[2], _address(context, builder, sig.args[0], *args[:2]), align=32)
        return context.get_dummy_value()

    return types.void(array, types.int64, vec4), generate


def _register(operation, instruction):
    scalars = (vec4, types.float64)

    @infer_global(operation)
    class _Template(AbstractTemplate):
        def generic(self, args, kws):
            if len(args) == 2 and vec4 in args and all(a in scalars for a in args):
                return signature(vec4, *args)
            return None

    for left, right in ((vec4, vec4), (vec4, types.float64), (types.float64, vec4)):

        @lower_builtin(operation, left, right)
        def _lower(context, builder, sig, args):
            operands = [
                _splat(builder, value) if kind is types.float64 else value
                for kind, value in zip(sig.args, args, strict=True)
            ]
            return getattr(builder, instruction)(*operands, flags=("contract",))


_register(operator.add, "fadd")
_register(operator.sub, "fsub")
_register(operator.mul, "fmul")
