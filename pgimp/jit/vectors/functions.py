"""Functions of vectors: the functions of Python's `math`, and ``abs``, ``max``, ``min``.

`math.floor` of a vector is a vector, unlike `math.floor` of a number. Each element is independent
of the others: sqrt, floor, abs, max and min agree with scalar results to the bit.
exp, log and pow are in `pgimp.jit.functions`.
"""

import math

from llvmlite import ir
from numba.core import cgutils
from numba.extending import intrinsic, overload

from pgimp.jit.kernel import INLINE_OPTIONS
from pgimp.jit.vectors.kinds import common, floats, is_vector, llvm_type, widened


def _unary(name):
    """An LLVM function of one vector."""

    @intrinsic
    def function(typing_context, a):
        def generate(context, builder, sig, args):
            form, whole = llvm_type(a), f"llvm.{name}.v{a.lanes}f64"
            kind = ir.FunctionType(form, [form])
            return builder.call(cgutils.get_or_insert_function(builder.module, kind, whole), args)

        return a(a), generate

    return function


_floor, _sqrt, _abs = map(_unary, ("floor", "sqrt", "fabs"))


def _extreme(sign):
    """The larger or smaller element of each pair; the second where one is NaN."""

    @intrinsic
    def function(typing_context, a, b):
        def generate(context, builder, sig, args):
            a, b = widened(builder, sig.args, args)
            return builder.select(builder.fcmp_ordered(sign, a, b), a, b)

        return common((a, b))(*floats((a, b))), generate

    return function


_larger, _smaller = _extreme(">"), _extreme("<")


@overload(math.floor, jit_options=INLINE_OPTIONS)
def _floor_of(x):
    return (lambda x: _floor(x)) if is_vector(x) else None


@overload(math.sqrt, jit_options=INLINE_OPTIONS)
def _sqrt_of(x):
    return (lambda x: _sqrt(x)) if is_vector(x) else None


@overload(abs, jit_options=INLINE_OPTIONS)
def _abs_of(x):
    return (lambda x: _abs(x)) if is_vector(x) else None


@overload(max, jit_options=INLINE_OPTIONS)
def _max_of(a, b):
    return (lambda a, b: _larger(a, b)) if is_vector(common((a, b))) else None


@overload(min, jit_options=INLINE_OPTIONS)
def _min_of(a, b):
    return (lambda a, b: _smaller(a, b)) if is_vector(common((a, b))) else None
