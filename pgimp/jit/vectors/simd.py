"""Four or eight float64 in one register: Numba types backed by LLVM's ``<4 x double>``.

LLVM does not vectorise a transfer by itself, because it cannot prove that grid and particles do not
alias. A vertex's record is two such vectors, (m, mv) and (-, f), so that the transfers become
vector multiply-adds. Preceding and following work is done for four particles at once. Operations:
`pack`, `vector`, `lane`, `load`, `store`, arithmetic between vectors and with numbers, comparisons,
which give a mask for `where` and `bits`. Functions are in `pgimp.jit.vectors.functions`. In kernels
products and sums may contract to fused multiply-adds, as for numbers.

Long chains of operations, as a material's, wait for results. Of two vectors joined to one of eight
they wait once; processors without such registers take both halves in turn.
"""

import operator

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic

from pgimp.jit.memory import part_of
from pgimp.jit.vectors.kinds import (
    DOUBLES,
    LANE,
    MASKS,
    common,
    floats,
    is_mask,
    is_vector,
    splat,
    vec4,
    vec8,
    widened,
)


def _address(context, builder, kind, array, index):
    """Address of a float64 in an array, or in a buffer on the stack."""
    if isinstance(kind, types.CPointer):
        return builder.gep(array, [index])
    return builder.gep(part_of(context, builder, kind, array, "data"), [index])


@intrinsic
def pack(typing_context, a, b, c, d):
    """Vector of four floats."""

    def generate(context, builder, sig, args):
        vector = ir.Constant(DOUBLES, ir.Undefined)
        for number, value in enumerate(args):
            vector = builder.insert_element(vector, value, ir.Constant(LANE, number))
        return vector

    return vec4(types.float64, types.float64, types.float64, types.float64), generate


@intrinsic
def vector(typing_context, value):
    """Vector of four equal floats; a vector itself."""
    kind = value if is_vector(value) else types.float64

    def generate(context, builder, sig, args):
        return args[0] if is_vector(sig.args[0]) else splat(builder, args[0], 4)

    return (value if is_vector(value) else vec4)(kind), generate


@intrinsic
def vector_as(typing_context, value, like):
    """Vector of equal floats, as long as the vector `like`; a vector itself."""

    def generate(context, builder, sig, args):
        return args[0] if is_vector(sig.args[0]) else splat(builder, args[0], like.lanes)

    return like(*floats((value, like))), generate


@intrinsic
def join(typing_context, low, high):
    """Vector of eight from two of four."""

    def generate(context, builder, sig, args):
        mask = ir.Constant(ir.VectorType(LANE, 8), list(range(8)))
        return builder.shuffle_vector(*args, mask)

    return vec8(vec4, vec4), generate


@intrinsic
def halves(typing_context, both):
    """The two vectors of four of a vector of eight."""

    def generate(context, builder, sig, args):
        undefined, whole = ir.Constant(args[0].type, ir.Undefined), ir.VectorType(LANE, 4)
        parts = [
            builder.shuffle_vector(args[0], undefined, ir.Constant(whole, list(range(i, i + 4))))
            for i in (0, 4)
        ]
        return context.make_tuple(builder, sig.return_type, parts)

    return types.UniTuple(vec4, 2)(vec8), generate


@intrinsic(prefer_literal=True)
def lane(typing_context, vector, number):
    """Element `number` of the vector; a literal costs least."""

    def generate(context, builder, sig, args):
        if isinstance(number, types.IntegerLiteral):
            position = ir.Constant(LANE, number.literal_value)
        else:
            position = builder.trunc(args[1], LANE)
        return builder.extract_element(args[0], position)

    kind = number if isinstance(number, types.IntegerLiteral) else types.int64
    return types.float64(vector, kind), generate


@intrinsic
def with_lane(typing_context, vector, number, value):
    """The vector with `value` as its element `number`."""

    def generate(context, builder, sig, args):
        return builder.insert_element(args[0], args[2], builder.trunc(args[1], LANE))

    return vector(vector, types.int64, types.float64), generate


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
        buffer.align = 64  # a cache line
        return builder.bitcast(buffer, ir.DoubleType().as_pointer())

    return types.CPointer(types.float64)(size), generate


@intrinsic
def number(typing_context, buffer, index):
    """Read one float64 of a buffer on the stack."""

    def generate(context, builder, sig, args):
        return builder.load(builder.gep(args[0], [args[1]]))

    return types.float64(buffer, types.int64), generate


def _register(operation, compares, instruction):
    """Compile an operation between vectors, or a vector and a number, to one instruction."""
    numbers = (types.Float, types.Integer, types.Boolean)

    @infer_global(operation)
    class _Template(AbstractTemplate):
        def generic(self, args, kws):
            kind = common(args)
            if len(args) != 2 or not is_vector(kind):
                return None
            if not all(a == kind or isinstance(a, numbers) for a in args):
                return None
            return signature(MASKS[kind] if compares else kind, *floats(args))

    for kind in (vec4, vec8):
        for left, right in ((kind, kind), (kind, types.float64), (types.float64, kind)):

            @lower_builtin(operation, left, right)
            def _lower(context, builder, sig, args):
                return instruction(builder, *widened(builder, sig.args, args))


_register(operator.add, False, ir.IRBuilder.fadd)
_register(operator.sub, False, ir.IRBuilder.fsub)
_register(operator.mul, False, ir.IRBuilder.fmul)
_register(operator.truediv, False, ir.IRBuilder.fdiv)
for _operation, _sign in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
    (operator.eq, "=="),
):
    _register(_operation, True, lambda builder, a, b, sign=_sign: builder.fcmp_ordered(sign, a, b))


@infer_global(operator.neg)
class _Negative(AbstractTemplate):
    def generic(self, args, kws):
        return signature(args[0], args[0]) if is_vector(args[0]) else None


@infer_global(operator.and_)
class _Both(AbstractTemplate):
    def generic(self, args, kws):
        same = is_mask(args[0]) and args[1] == args[0]
        return signature(args[0], *args) if same else None


for _kind, _mask in MASKS.items():

    @lower_builtin(operator.neg, _kind)
    def _negate(context, builder, sig, args):
        return builder.fneg(args[0])

    @lower_builtin(operator.and_, _mask, _mask)
    def _and(context, builder, sig, args):
        return builder.and_(*args)


@intrinsic
def where(typing_context, mask, a, b):
    """Vector with the elements of `a` where the mask is true, else of `b`."""
    (kind,) = (vector for vector, own in MASKS.items() if own == mask)

    def generate(context, builder, sig, args):
        chosen = [
            value if is_vector(own) else splat(builder, value, kind.lanes)
            for own, value in zip(sig.args[1:], args[1:], strict=True)
        ]
        return builder.select(args[0], *chosen)

    return kind(mask, *floats((a, b))), generate


@intrinsic
def bits(typing_context, mask):
    """The mask as a number: bit i for element i."""

    def generate(context, builder, sig, args):
        whole = builder.bitcast(args[0], ir.IntType(mask.lanes))
        return builder.zext(whole, ir.IntType(64))

    return types.int64(mask), generate
