"""Four float64 in one register: a Numba type backed by LLVM's ``<4 x double>``.

LLVM does not vectorise a transfer by itself, because it cannot prove that grid and particles do not
alias. A vertex's record is two such vectors, (m, mv) and (-, f), so that the transfers become
vector multiply-adds. Preceding and following work is done for four particles at once. Operations:
`pack`, `vector`, `lane`, `load`, `store`, arithmetic between vectors and with numbers, comparisons,
which give a mask for `where` and `bits`. Functions are in `pgimp.jit.vectors.functions`. In kernels
products and sums may contract to fused multiply-adds, as for numbers.
"""

import operator

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, models, register_model

DOUBLES = ir.VectorType(ir.DoubleType(), 4)
_BITS = ir.VectorType(ir.IntType(1), 4)
_LANE = ir.IntType(32)


class Vec4Type(types.Type):
    """Numba's type of a vector of four float64."""

    def __init__(self):
        super().__init__(name="Vec4")


class Mask4Type(types.Type):
    """Numba's type of four truth values."""

    def __init__(self):
        super().__init__(name="Mask4")


vec4 = Vec4Type()
mask4 = Mask4Type()


@register_model(Vec4Type)
class _Vec4Model(models.PrimitiveModel):
    def __init__(self, manager, fe_type):
        super().__init__(manager, fe_type, DOUBLES)


@register_model(Mask4Type)
class _Mask4Model(models.PrimitiveModel):
    def __init__(self, manager, fe_type):
        super().__init__(manager, fe_type, _BITS)


def splat(builder, kind, value):
    """The LLVM vector of a value, which is a vector or a number."""
    if kind == vec4:
        return value
    undefined = ir.Constant(DOUBLES, ir.Undefined)
    first = builder.insert_element(undefined, value, ir.Constant(_LANE, 0))
    mask = ir.Constant(ir.VectorType(_LANE, 4), [0, 0, 0, 0])
    return builder.shuffle_vector(first, undefined, mask)


def _address(context, builder, kind, array, index):
    """Address of a float64 in an array, or in a buffer on the stack."""
    if isinstance(kind, types.CPointer):
        return builder.gep(array, [index])
    return builder.gep(context.make_array(kind)(context, builder, array).data, [index])


@intrinsic
def pack(typing_context, a, b, c, d):
    """Vector of four floats."""

    def generate(context, builder, sig, args):
        vector = ir.Constant(DOUBLES, ir.Undefined)
        for number, value in enumerate(args):
            vector = builder.insert_element(vector, value, ir.Constant(_LANE, number))
        return vector

    return vec4(types.float64, types.float64, types.float64, types.float64), generate


@intrinsic
def vector(typing_context, value):
    """Vector of four equal floats; a vector itself."""
    kind = vec4 if value == vec4 else types.float64

    def generate(context, builder, sig, args):
        return splat(builder, sig.args[0], args[0])

    return vec4(kind), generate


@intrinsic(prefer_literal=True)
def lane(typing_context, vector, number):
    """Element `number` of the vector; a literal costs least."""

    def generate(context, builder, sig, args):
        if isinstance(number, types.IntegerLiteral):
            position = ir.Constant(_LANE, number.literal_value)
        else:
            position = builder.trunc(args[1], _LANE)
        return builder.extract_element(args[0], position)

    kind = number if isinstance(number, types.IntegerLiteral) else types.int64
    return types.float64(vec4, kind), generate


@intrinsic
def with_lane(typing_context, vector, number, value):
    """The vector with `value` as its element `number`."""

    def generate(context, builder, sig, args):
        return builder.insert_element(args[0], args[2], builder.trunc(args[1], _LANE))

    return vec4(vec4, types.int64, types.float64), generate


@intrinsic
def load(typing_context, array, index):
    """Read ``array[index:index + 4]``; the address must be a multiple of 32 bytes."""

    def generate(context, builder, sig, args):
        address = _address(context, builder, sig.args[0], *args)
        return builder.load(builder.bitcast(address, DOUBLES.as_pointer()), align=32)

    return vec4(array, types.int64), generate


@intrinsic
def store(typing_context, array, index, vector):
    """Write a vector to ``array[index:index + 4]``; the address must be a multiple of 32 bytes."""

    def generate(context, builder, sig, args):
        address = _address(context, builder, sig.args[0], *args[:2])
        builder.store(args[2], builder.bitcast(address, DOUBLES.as_pointer()), align=32)
        return context.get_dummy_value()

    return types.void(array, types.int64, vec4), generate


@intrinsic(prefer_literal=True)
def stack(typing_context, size):
    """Buffer of `size` (a literal) float64 on the stack, for `load`, `store` and `number`.

    Unlike an array, it cannot alias other storage for the compiler.
    """
    if not isinstance(size, types.IntegerLiteral):
        return None
    vectors = -(-size.literal_value // 4)

    def generate(context, builder, sig, args):
        buffer = cgutils.alloca_once(builder, DOUBLES, vectors)
        buffer.align = 32
        return builder.bitcast(buffer, ir.DoubleType().as_pointer())

    return types.CPointer(types.float64)(size), generate


@intrinsic
def number(typing_context, buffer, index):
    """Read one float64 of a buffer on the stack."""

    def generate(context, builder, sig, args):
        return builder.load(builder.gep(args[0], [args[1]]))

    return types.float64(buffer, types.int64), generate


def _register(operation, result, instruction):
    """Compile an operation between vectors, or a vector and a number, to one instruction."""
    numbers = (types.Float, types.Integer, types.Boolean)

    @infer_global(operation)
    class _Template(AbstractTemplate):
        def generic(self, args, kws):
            if len(args) != 2 or vec4 not in args:
                return None
            if not all(a == vec4 or isinstance(a, numbers) for a in args):
                return None
            return signature(result, *(vec4 if a == vec4 else types.float64 for a in args))

    for left, right in ((vec4, vec4), (vec4, types.float64), (types.float64, vec4)):

        @lower_builtin(operation, left, right)
        def _lower(context, builder, sig, args):
            return instruction(builder, *map(splat, (builder,) * 2, sig.args, args))


_register(operator.add, vec4, ir.IRBuilder.fadd)
_register(operator.sub, vec4, ir.IRBuilder.fsub)
_register(operator.mul, vec4, ir.IRBuilder.fmul)
_register(operator.truediv, vec4, ir.IRBuilder.fdiv)
for _operation, _sign in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
    (operator.eq, "=="),
):
    _register(_operation, mask4, lambda builder, a, b, sign=_sign: builder.fcmp_ordered(sign, a, b))


@infer_global(operator.neg)
class _Negative(AbstractTemplate):
    def generic(self, args, kws):
        return signature(vec4, vec4) if args == (vec4,) else None


@lower_builtin(operator.neg, vec4)
def _negate(context, builder, sig, args):
    return builder.fneg(args[0])


@infer_global(operator.and_)
class _Both(AbstractTemplate):
    def generic(self, args, kws):
        return signature(mask4, mask4, mask4) if args == (mask4, mask4) else None


@lower_builtin(operator.and_, mask4, mask4)
def _and(context, builder, sig, args):
    return builder.and_(*args)


@intrinsic
def where(typing_context, mask, a, b):
    """Vector with the elements of `a` where the mask is true, else of `b`."""
    kinds = [vec4 if value == vec4 else types.float64 for value in (a, b)]

    def generate(context, builder, sig, args):
        a, b = map(splat, (builder,) * 2, sig.args[1:], args[1:])
        return builder.select(args[0], a, b)

    return vec4(mask4, *kinds), generate


@intrinsic
def bits(typing_context, mask):
    """The mask as a number: bit i for element i."""

    def generate(context, builder, sig, args):
        return builder.zext(builder.bitcast(args[0], ir.IntType(4)), ir.IntType(64))

    return types.int64(mask4), generate
