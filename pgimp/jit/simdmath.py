"""Functions of vectors: those of Python's `math`, and ``abs``, ``max``, ``min``.

`math.floor` of a vector is a vector, unlike that of a number. Each element is what the function
gives of it alone, whatever the others are: sqrt, floor, abs, max and min as of numbers, to the bit;
log within an ulp of positive normal numbers, NaN of what is not positive.
"""

import math

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic, overload

from pgimp.jit.kernel import INLINE_OPTIONS
from pgimp.jit.simd import DOUBLES, splat, vec4, where

_INTEGERS = ir.VectorType(ir.IntType(64), 4)

# Significand bits of sqrt(1/2): what it exceeds is at least that.
_HALF = 0x3FE6A09E667F3BCD
# ln 2 in two parts, the first exact in products with exponents; and the coefficients of the minimax
# polynomial for (log(1+f) - f)/s, s = f/(2+f) (Sun Microsystems' fdlibm, e_log.c).
_LN2, _LN2_REST = 6.93147180369123816490e-01, 1.90821492927058770002e-10
_C1, _C2, _C3 = 6.666666666666735130e-01, 3.999999999940941908e-01, 2.857142874366239149e-01
_C4, _C5, _C6 = 2.222219843214978396e-01, 1.818357216161805012e-01, 1.531383769920937332e-01
_C7 = 1.479819860511658591e-01


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


@intrinsic
def _split(typing_context, a):
    """Exponent e and significand s of positive normal numbers, a = s 2^e, s from sqrt(1/2) on."""

    def generate(context, builder, sig, args):
        def constant(value):
            return ir.Constant(_INTEGERS, [value] * 4)

        whole = builder.bitcast(args[0], _INTEGERS)
        shift = constant(52)
        exponent = builder.ashr(builder.sub(whole, constant(_HALF)), shift)
        significand = builder.bitcast(builder.sub(whole, builder.shl(exponent, shift)), DOUBLES)
        parts = builder.sitofp(exponent, DOUBLES), significand
        return context.make_tuple(builder, sig.return_type, parts)

    return types.UniTuple(vec4, 2)(vec4), generate


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


@overload(math.log, jit_options=INLINE_OPTIONS)
def _log_of(x):
    if x != vec4:
        return None

    def log(x):
        e, m = _split(x)
        f = m - 1.0
        s = f / (2.0 + f)
        z = s * s
        w = z * z
        odd = w * (_C2 + w * (_C4 + w * _C6))
        even = z * (_C1 + w * (_C3 + w * (_C5 + w * _C7)))
        half = 0.5 * f * f
        found = e * _LN2 - ((half - (s * (half + (even + odd)) + e * _LN2_REST)) - f)
        return where(x > 0.0, found, math.nan)

    return log
