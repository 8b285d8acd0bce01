"""exp, log, power and cbrt of numbers and of vectors: pgimp's own, with the same bits for both.

A library's results depend on its maker and version, and differ between one number and four. These
are sums, products, divisions and fused multiply-adds alone, which IEEE 754 rounds in one way. They
are not contracted further (`pgimp.jit.kernel.exact`), and never branch. Errors in units in the last
place (ulp), held by `tests/jit/test_functions.py`, are up to 0.99 of exp, 0.64 of log, and 0.5 of
cbrt. For power they are 0.96 for |y ln x| < 10, 1.6 up to 40, 24 up to 700.
"""

import math

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic, overload

import pgimp.jit.vectors.functions  # noqa: F401  so that abs, max and min are known of vectors
from pgimp.jit.choose import choose
from pgimp.jit.kernel import INLINE_OPTIONS, exact
from pgimp.jit.vectors.kinds import common, floats, is_vector, llvm_type, widened

# ln 2 in two parts, the first exact in products with exponents. Then the coefficients of the
# minimax polynomial for (log(1+f) - f)/s, s = f/(2+f) (Sun Microsystems' fdlibm, e_log.c).
_LN2, _LN2_REST = 6.93147180369123816490e-01, 1.90821492927058770002e-10
_C1, _C2, _C3 = 6.666666666666735130e-01, 3.999999999940941908e-01, 2.857142874366239149e-01
_C4, _C5, _C6 = 2.222219843214978396e-01, 1.818357216161805012e-01, 1.531383769920937332e-01
_C7 = 1.479819860511658591e-01
# ln 2 as a float64 and its rounding error, for fused multiply-adds.
_LOG2E, _LN2_NEAR, _LN2_LACK = 1.0 / math.log(2.0), math.log(2.0), 2.3190468138462996e-17
# A number of this size has the integers as its last bits.
_ROUND = 1.5 * 2.0**52
# Beyond these e^x is 0 or infinite.
_LOWEST, _HIGHEST = -746.0, 710.0

# Significand bits of sqrt(1/2), the least significand.
_HALF = 0x3FE6A09E667F3BCD


def _bits(kind):
    """LLVM's type of the bits of a number or a vector, and a function for constants."""
    if not is_vector(kind):
        return ir.IntType(64), lambda value: ir.Constant(ir.IntType(64), value)
    whole = ir.VectorType(ir.IntType(64), kind.lanes)
    return whole, lambda value: ir.Constant(whole, [value] * kind.lanes)


@intrinsic
def fma(typing_context, a, b, c):
    """``a * b + c``, rounded once."""
    kind = common((a, b, c))

    def generate(context, builder, sig, args):
        args, each = widened(builder, sig.args, args), llvm_type(kind)
        name = f"llvm.fma.v{kind.lanes}f64" if is_vector(kind) else "llvm.fma.f64"
        form = ir.FunctionType(each, [each] * 3)
        return builder.call(cgutils.get_or_insert_function(builder.module, form, name), args)

    return kind(*floats((a, b, c))), generate


@intrinsic
def _split(typing_context, a):
    """Exponent e and significand s of positive normal numbers, a = s 2^e, s from sqrt(1/2) on."""
    kind = common((a,))

    def generate(context, builder, sig, args):
        form, constant = _bits(kind)
        whole, shift = builder.bitcast(args[0], form), constant(52)
        exponent = builder.ashr(builder.sub(whole, constant(_HALF)), shift)
        moved = builder.sub(whole, builder.shl(exponent, shift))
        parts = builder.sitofp(exponent, llvm_type(kind)), builder.bitcast(moved, llvm_type(kind))
        return context.make_tuple(builder, sig.return_type, parts)

    return types.UniTuple(kind, 2)(kind), generate


@intrinsic
def _two_to(typing_context, shifted):
    """2^k of ``_ROUND + k``, k an integer between -1022 and 1023."""
    kind = common((shifted,))

    def generate(context, builder, sig, args):
        form, constant = _bits(kind)
        raised = builder.shl(builder.bitcast(args[0], form), constant(52))
        return builder.bitcast(builder.add(raised, constant(1023 << 52)), llvm_type(kind))

    return kind(kind), generate


@exact
def _exp_of_sum(x, rest):
    """e^(x + rest), `rest` small against the last place of 1 or so."""
    held = min(max(x, _LOWEST), _HIGHEST)
    k = fma(held, _LOG2E, _ROUND) - _ROUND
    r = fma(k, -_LN2_NEAR, held) + fma(k, -_LN2_LACK, rest)  # |r| <= ln(2)/2
    # e^r = 1 + r + r^2 q(r), Taylor's to r^13: the next term is 4e-18.
    r2 = r * r
    r4 = r2 * r2
    a = fma(r, 1.0 / 6.0, 0.5)
    b = fma(r, 1.0 / 120.0, 1.0 / 24.0)
    c = fma(r, 1.0 / 5040.0, 1.0 / 720.0)
    d = fma(r, 1.0 / 362880.0, 1.0 / 40320.0)
    e = fma(r, 1.0 / 39916800.0, 1.0 / 3628800.0)
    f = fma(r, 1.0 / 6227020800.0, 1.0 / 479001600.0)
    q = fma(r4, fma(r4, fma(r2, f, e), fma(r2, d, c)), fma(r2, b, a))
    found = 1.0 + fma(r2, q, r)
    half = fma(k, 0.5, _ROUND)  # in two factors: either may be subnormal or infinite alone
    found = found * _two_to(half) * _two_to((k - (half - _ROUND)) + _ROUND)
    return choose(x == x, found, x)


@exact
def exp(x):
    """e^x; 0 and infinity where it is out of range."""
    return _exp_of_sum(x, 0.0)


@exact
def _series(z):
    """The polynomial z (C1 + C2 z + ... + C7 z^6)."""
    w = z * z
    even = z * fma(w, fma(w, fma(w, _C7, _C5), _C3), _C1)
    return fma(w, fma(w, fma(w, _C6, _C4), _C2), even)


@exact
def log(x):
    """Natural logarithm of positive normal numbers, NaN of others."""
    e, m = _split(x)
    f = m - 1.0
    s = f / (2.0 + f)
    z = s * s
    half = 0.5 * f * f
    tail = fma(e, _LN2_REST, s * (half + _series(z)))
    found = fma(e, _LN2, -((half - tail) - f))
    return choose(x > 0.0, found, math.nan)


@exact
def power(x, y):
    """x^y for x >= 0, NaN for x < 0; 0^y is 0 for y > 0, and 0^0 is 1."""
    e, m = _split(x)
    f = m - 1.0
    g = 2.0 + f
    r = 1.0 / g
    s = f * r
    lack = r * (fma(-s, g, f) - s * (f - (g - 2.0)))  # of f/(2 + f)
    series = _series(s * s)
    # ln x = high + low, to 2^-60 of it.
    large, small = e * _LN2, 2.0 * s
    first = large + small
    last = (small - (first - large)) + (fma(s, series, 2.0 * lack) + e * _LN2_REST)
    high = first + last
    low = last - (high - first)
    product = y * high
    found = _exp_of_sum(product, fma(y, high, -product) + y * low)
    at_zero = choose(y > 0.0, 0.0, choose(y == 0.0, 1.0, math.inf))
    return choose(x > 0.0, found, choose(x == 0.0, at_zero, math.nan))


@exact
def cbrt(x):
    """Cube root, of negative numbers too; not of subnormal ones."""
    a = abs(x)
    y = exp(log(a) * (1.0 / 3.0))
    y2 = y * y
    excess = fma(y2, y, -a) + fma(y, y, -y2) * y
    y = y - excess / (3.0 * y2)
    return choose(x == 0.0, x, choose(x < 0.0, -y, y))


@overload(math.exp, jit_options=INLINE_OPTIONS)
def _exp_of(x):
    return (lambda x: exp(x)) if is_vector(x) else None


@overload(math.log, jit_options=INLINE_OPTIONS)
def _log_of(x):
    return (lambda x: log(x)) if is_vector(x) else None


@overload(math.pow, jit_options=INLINE_OPTIONS)
def _pow_of(x, y):
    return (lambda x, y: power(x, y)) if is_vector(common((x, y))) else None
