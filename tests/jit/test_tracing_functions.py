"""Functions that kernels call, by tracing: inlined, given to each other, with their variables."""

import sys
from typing import NamedTuple

import numpy as np
import pytest
from numba.core import types

from pgimp.jit.kernel import inlined, inner_kernel, kernel, of_types


class Pair(NamedTuple):
    """A record with a default."""

    x: float
    y: float = 2.0


@inner_kernel
def applied(function, values, pair):
    """A function, given as an argument, of each value and a part of a pair."""
    found = 0.0
    for each in values:
        found += function(each, pair.y)
    return found


@inlined
def weighted(values, factor):
    """A tuple, and a sum from its first term, for tuples of any length."""
    if len(values) == 0:
        return (), factor
    scaled = tuple(factor * v for v in values if not is_text(v))
    return scaled, sum(a * b + i for i, (a, b) in enumerate(zip(values, scaled, strict=True)))


@of_types
def is_text(kind):
    """Whether a value is a text; in Python none is."""
    return isinstance(kind, types.UnicodeType)


@kernel
def weights(n):
    """The variables of a sum are not those of a loop around it."""
    total, a = 0.0, 1
    for i in range(n):
        total += weighted((1.0, i + 2.0), 0.5)[1] + sum(a * i for a in (1, 2))
        a += i
    return total, a, weighted((), 3)[1]


def test_plain_functions_are_inlined():
    assert weighted((1.0, 2.0), 0.5) == ((0.5, 1.0), 3.5)
    parts = [0.5 * (1.0 + (i + 2.0) ** 2) + 1.0 + 3 * i for i in range(4)]
    assert weights(4) == (pytest.approx(sum(parts)), 7, 3)


@inner_kernel
def halved(values):
    """Half of a number, or of the first of a pair; each type has a function of its own."""
    if len(values) == 1:
        return values[0] / 2
    return halved(values[1:]) + halved((values[0] + 0.5,))


@kernel
def corners(n, a):
    """What is easily mixed up: types of a variable in two loops, functions of one name."""
    index, total = 0, 0
    for i in range(n):
        index = index + i
    whole = index // 2
    index = 0
    for i in range(n):
        index = index + 0.5 * i
    parts = ()
    total = sum(each for each in parts)
    if n > 100:
        total += 1 // (len(parts))
    return whole, index, total, halved((1, 2.0, a))


def test_variables_of_two_loops_and_functions_of_one_name_are_kept_apart():
    before = sys.getrecursionlimit()
    assert corners(4, 3.0) == (3, 3.0, 0, 3.5)
    assert sys.getrecursionlimit() == before


@kernel
def applications(values, pair):
    return applied(max, values, pair), applied(min, values, pair), applied(max, values, Pair(0, 1))


def test_functions_are_given_to_functions():
    values = np.array([1.0, 2.5, 4.0])
    assert applications(values, Pair(1.0, 2.0)) == (8.5, 5.0, 7.5)
