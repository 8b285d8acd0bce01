"""Functions of vectors: the functions of Python's `math`, and ``abs``, ``max``, ``min``.

`math.floor` of a vector is a vector, unlike `math.floor` of a number. Each element is independent
of the others: sqrt, floor, abs, max and min agree with scalar results to the bit.
exp, log and pow are in `pgimp.jit.functions`.
"""

import math

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic, overload

from pgimp.jit.kernel import INLINE_OPTIONS
from pgimp.jit.vectors.simd import DOUBLES, splat, vec4


def _unary(name):
    """An LLVM function of one vector."""

    @intrinsic
    def function(typing_context, a):
        def generate(context, builder, sig, args):
            kind = ir.FunctionType(DOUBLES, [DOUBLES])
            return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), args)

        return vec4(vec4), generate

    return function


_floor, _sqrt, _abs = map(_unary, ("llvm.floor.v4f64", "llvm.sqrt.v4f64", "llvm.fabs.v4f64"))


def _extreme(sign):
    """The larger or smaller element of each pair; the second where one is NaN."""

    @intrinsic
    def function(typing_context, a, b):
        kinds = [vec4 if value == vec4 else types.float64 for value in (a, b)]

        def generate(context, builder, sig, args):
            a, b = map(splat, (builder,) * 2, sig.args, args)
            return builder.select(builder.fcmp_ordered(sign, a, b), a, b)

        return vec4(*kinds), generate

    return function


_larger, _smaller = _extreme(">"), _extreme("<")


@overload(math.floor, jit_options=INLINE_OPTIONS)
def _floor_of(x):
    return (lambda x: _floor(x)) if x == vec4 else None


@overload(math.sqrt, jit_options=INLINE_OPTIONS)
def _sqrt_of(x):
    return (lambda x: _sqrt(x)) if x == vec4 else None


@overload(abs, jit_options=INLINE_OPTIONS)
def _abs_of(x):
    return (lambda x: _abs(x)) if x == vec4 else None


@overload(max, jit_options=INLINE_OPTIONS)
def _max_of(a, b):
    return (lambda a, b: _larger(a, b)) if vec4 in (a, b) else None


@overload(min, jit_options=INLINE_OPTIONS)
def _min_of(a, b):
    return (lambda a, b: _smaller(a, b)) if vec4 in (a, b) else None
