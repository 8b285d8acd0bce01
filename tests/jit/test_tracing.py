"""Traced kernels: the same results as the Python that they are written in."""

from itertools import product
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pgimp.jit.kernel import exact, inlined, inner_kernel, kernel
from pgimp.jit.tracing.source import kept, living, source_of
from pgimp.jit.tracing.values import UntraceableError

pytestmark = pytest.mark.slow(8)


class Pair(NamedTuple):
    """A record with a default."""

    x: float
    y: float = 2.0


@inlined
def named_sum(pair, more):
    """Sum of a pair and of what a tuple has."""
    if len(more) == 0:
        return pair.x + pair.y
    return more[0] + named_sum(pair, more[1:])


@inlined
def chosen(a):
    """One of two lambdas on a line."""
    if isinstance(a, int):
        return a + 1
    return a - 0.25


@inner_kernel
def collatz(n):
    """Steps to 1; leaves a loop in its middle."""
    steps = 0
    while True:
        if n == 1:
            return steps
        if n % 2 == 0:
            n //= 2
        else:
            n = 3 * n + 1
        steps += 1


@inner_kernel
def first_above(values, bound):
    """Offset of the first value above a bound; -1 without one."""
    for i in range(len(values)):
        if not values[i] <= bound:
            return i
    return -1


def loops(values, bound):
    """Variables that loops keep, change in type, or leave behind."""
    total, last, count = 0, -1.0, 0
    for i in range(4, 0, -2) if bound > 1.0 else range(len(values)):
        count = 2 * count + i
    for i in range(len(values)):
        if values[i] < 0.0:
            continue
        if values[i] > bound:
            break
        part = values[i]
        for k in range(3, 0, -1):
            part = part * 0.5 + k
            if k == 2 and part > 4.0:
                break
        total = total + part
        last, count = part, count + 1
    else_value = last if count else 0.5
    return total, last, count, else_value


def numbers(a, b, n):
    """Operations on integers and floats, signs and constants included."""
    quotient, rest = a // n, a % n
    shifted = (n << 3) ^ (n >> 1) | (n & 5)
    between = 0.0 < a <= b < 10.0 and not (a == b or n > 3)
    either = n if a > b else b
    return (
        quotient, rest, -n // 3, -n % 3, shifted, between, either, a**3, a**-2, max(a, b, 0.5),
        min((a, b)), abs(-a), int(b), 1.0 / 3.0 + 2**3, ~n, +a,
    )  # fmt: skip


def tuples(a, n):
    """Tuples: packed, unpacked, sliced, joined, chosen by a number of the run, walked through."""
    pair = Pair(a)
    x, *rest = (pair.x, 1.0, *pair)
    total = 0.0
    for each in rest:
        total += each * x
    items = (a, 2.0 * a, 3.0)
    found = items[n]
    for d in range(3):
        if d != n:
            found += items[d]
    changed = (a, 1.0)
    for i in range(n):
        changed = (changed[1] + i, changed[0])
    return named_sum(pair, (total, found)), *items[1:], *changed, len(rest), chosen(n), chosen(a)


def branches(a, n):
    """Values that meet after branches, some with a value in one of them only."""
    kind = 0
    if a > 1.0:
        kind, value = 1, (a, n)
    elif a > 0.5:
        value = (0.25, 7)
    else:
        value = (1, n)
        if n > 2:
            return 9.0, 1.0, 0, collatz(n + 1)
    if kind == 1 or value[1] > 5:
        only = value[0] * 2.0
        kind += only > 3.0
    return value[0], value[1] + 0.0, kind, collatz(n + 1)


@pytest.mark.parametrize("function", [numbers, tuples, branches])
def test_expressions_and_branches_are_those_of_python(function):
    traced = kernel(function)
    for a, b, n in product((0.3, 0.7, 2.5, 4.0), (0.5, 2.5, 7.25), (1, 2)):
        args = (a, b, n) if function is numbers else (a, n)
        plain, found = function_of(function)(*args), traced(*args)
        assert [*map(float, found)] == pytest.approx([*map(float, plain)], rel=1e-14)
    assert any(type(each) is int for each in found)


def function_of(function):
    """The function with plain ones in place of those that only kernels have."""
    own = {"collatz": collatz.py_func}
    return type(function)(function.__code__, {**function.__globals__, **own})


@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(-1.0, 3.0), max_size=7), st.floats(0.0, 3.0))
def test_loops_are_those_of_python(values, bound):
    values = np.array(values)
    assert traced_loops(values, bound) == pytest.approx(loops(values, bound), rel=1e-15)
    assert traced_first(values, bound) == first_above.py_func(values, bound)


traced_loops = kernel(loops)


@kernel
def traced_first(values, bound):
    return first_above(values, bound)


@exact
def product_sum(a, b, c):
    """a b + c, rounded twice."""
    return a * b + c


def test_what_is_exact_is_not_contracted():
    """In a kernel that contracts: (1 + e)^2 - (1 + 2 e) is e^2 if rounded once, else 0."""
    once = kernel(lambda a, b, c: a * b + c)
    twice = kernel(lambda a, b, c: product_sum(a, b, c))
    e = 2.0**-30
    assert twice(1.0 + e, 1.0 + e, -1.0 - 2.0 * e) == 0.0
    assert once(1.0 + e, 1.0 + e, -1.0 - 2.0 * e) in (0.0, e * e)  # without such an instruction 0


def fails(a):
    b = a + 1.0
    return open(b)


def two_types(a):
    if a > 0.0:
        b = (a, a)
    else:
        b = a
    return b


@inlined
def endless(a):
    """A recursion without an end."""
    return endless(a + 1.0)


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (fails, "open of"),
        (two_types, "b may be of two types"),
        (lambda a: endless(a), "recursion without an end"),
        (lambda a: [a], "List is not for kernels"),
        (lambda a: not_there(a), "not_there has no value"),  # noqa: F821
    ],
)
def test_what_cannot_be_traced_says_why_and_where(function, message):
    with pytest.raises(UntraceableError, match=message) as found:
        kernel(function)(1.0)
    if function is fails:
        line = fails.__code__.co_firstlineno + 2
        assert any(f"test_tracing.py:{line}, in fails" in note for note in found.value.__notes__)


def lives(a):
    first = second = third = fourth = 0
    for i in range(a):
        temporary = i + first
        if temporary > 2:
            second = temporary
        first = second
        third = i
        while first > 9:
            first -= fourth
            fourth = 1
    return third


def test_loops_keep_what_is_read_again_and_no_more():
    tree = source_of(lives)
    outer = tree.body[1]
    inner = outer.body[-1]
    assert kept(outer, tree) == {"first", "second", "third", "fourth"}
    assert kept(inner, tree) == {"first", "fourth"}
    assert "temporary" not in living(tree)[outer.body[1]]
