"""What is known while a kernel is traced: by types, classes, constants and Python's functions."""

from typing import NamedTuple

import numba
import numpy as np
import pytest

from pgimp.jit.kernel import (
    allocating_kernel,
    class_of,
    inlined,
    is_empty,
    is_number,
    is_record,
    kernel,
)

FACTORS = {"half": 0.5, "pair": (2.0, 3.0)}


class Line(NamedTuple):
    """A function of x with parameters."""

    rise: float

    @staticmethod
    def value(own, x):
        return own.rise * x


class Square(NamedTuple):
    """Another one, which also has a derivative."""

    factor: float

    @staticmethod
    def value(own, x):
        return own.factor * x * x

    @staticmethod
    def slope(own, x):
        return 2.0 * own.factor * x


def spelled(name):
    """What only Python can do."""
    return f"{name}".upper() == "HALF"


@inlined
def value_of(function, x, name):
    """By the class of the function, and by a name."""
    found = class_of(function).value(function, x)
    if hasattr(class_of(function), "slope"):
        found += class_of(function).slope(function, x)
    if isinstance(function, Square) and not isinstance(x, int) and spelled(name):
        found *= FACTORS[name]
    if name in FACTORS and name != "half":
        found += sum(factor * a for factor in FACTORS[name] for a in (x, 1.0))
    return found


@kernel
def values(functions, x):
    half = tuple(value_of(f, x, "half") for f in functions)
    return *half, value_of(functions[0], x, "pair"), value_of(functions[0], x, "none")


def test_classes_and_constants_choose():
    line, square = 3.0 * 2.0, 1.5 * 4.0 + 3.0 * 2.0
    expected = line, 0.5 * square, line + 5.0 * (2.0 + 1.0), line
    assert values((Line(3.0), Square(1.5)), 2.0) == pytest.approx(expected, rel=1e-14)


def doubled(name, x):
    """Run by Python where both are known, which is asked about types too."""
    return 2.0 * x if name == "twice" and is_number(x) else x


@kernel
def doubles(x):
    return doubled("twice", 0.5), doubled("twice", x), doubled("once", True)


def test_python_is_asked_about_types_as_the_kernel_is():
    assert doubles(3) == (1.0, 6.0, True) == (doubled("twice", 0.5), doubled("twice", 3), True)


@inlined
def kinds(a, b):
    """Records, what is in their place, tuples of numbers."""
    every = is_record(a), is_empty(a), is_record(b), is_empty(b)
    return tuple(1 if each else 0 for each in every), any(each > 1.0 for each in b)


@kernel
def seen(a, b):
    return kinds(a, b), kinds((), b), all(n == m for n in (1, 2) for m in (1, 2) if m == n)


def test_records_and_empty_tuples_are_told_from_tuples_of_numbers():
    assert seen(Line(1.0), (0.5,)) == (((1, 0, 0, 0), False), ((0, 1, 0, 0), False), True)
    assert seen(Line(1.0), (0.5, 2.0)) == (((1, 0, 0, 0), True), ((0, 1, 0, 0), True), True)


@allocating_kernel
def made(n):
    """Arrays of constant size and type are made each time, and not once while tracing."""
    found = np.zeros(3, np.int64)
    found[0] += n
    found[-1] = found[0] + 1
    return found[n - 2], found[-1], found[n - 4]


def test_arrays_of_constant_size_are_made_in_each_call():
    for _ in range(2):
        assert made(2) == (2, 3, 0)
        assert made(3) == (0, 4, 4)


@kernel
def second(tables, flag, n):
    """Uses one array of several, a truth and an index from the end."""
    tables[1][n - 1, 0] += 1.0 if flag else 2.0
    return tables[1][-1, n]


class _NoArray:
    """What no entry can take for an array."""


def test_arguments_that_are_not_used_are_not_looked_at():
    tables = np.zeros((2, 2), np.int32), np.zeros((3, 2)), np.zeros(4)
    assert second(tables, True, 1) == 0.0
    entry = second.overloads[second.signatures[0]].entry_point
    assert entry((_NoArray(), tables[1], _NoArray()), False, np.int64(0)) == 2.0
    assert tables[1].tolist() == [[1.0, 0.0], [0.0, 0.0], [2.0, 0.0]]
    with pytest.raises(TypeError, match="another type than before"):
        entry((tables[0], _NoArray(), tables[2]), False, 0)
    with pytest.raises(TypeError):
        entry(tables, False, "text")


def test_functions_that_numba_compiles_call_kernels_with_all_arguments():
    @numba.njit
    def twice(tables, n):
        return second(tables, True, n) + second(tables, False, n)

    assert twice((np.zeros((2, 2), np.int32), np.zeros((1, 2)), np.zeros(4)), 0) == 4.0
