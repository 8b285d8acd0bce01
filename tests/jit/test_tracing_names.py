"""Traced kernels as Python: arguments by name, chains, generators, indices, classes."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np
import pytest

from pgimp.jit.bound import Bound
from pgimp.jit.kernel import allocating_kernel, inlined, inner_kernel, kernel
from pgimp.jit.tracing.values import UntraceableError

TABLE = {"half": 0.5, "third": 0.25}
ROW = np.arange(5.0)


class Pair(NamedTuple):
    x: float
    y: float = 2.0


def plain(a, b=1.0, c=2.0):
    return a + 10.0 * b + 100.0 * c


@inlined
def inside(a, b=1.0, c=2.0):
    return plain(a, c=c, b=b)


@inner_kernel
def outside(a, b=1.0, c=2.0):
    return plain(a, b, c)


@kernel
def by_name(a, b=3.0):
    """Some by name, those between by default; the kernel has a default too."""
    return (
        plain(a, c=5.0), inside(a, c=5.0), outside(a, c=5.0), outside(b=5.0, a=a), outside(a, b),
        Pair(y=a, x=b),
    )  # fmt: skip


def test_arguments_by_name_and_default_are_in_their_places():
    expected = (513.0, 513.0, 513.0, 253.0, 233.0, (3.0, 3.0))
    assert by_name(3.0) == by_name(a=3.0) == expected
    assert by_name(3.0, 4.0) == (*expected[:4], 243.0, (4.0, 3.0))


def chains(n, a, word):
    """The values of chains, not only their truth; what is in tuples and dictionaries."""
    one, other = n or 5, a and 2.0 * a
    found = 1 if n in (1, 2) else 2 if n not in (3, a) else 3
    found += 10 if word not in TABLE else 20 if word in ("half", "none") else 30
    return one, other, found, n > 1 or a, not (n and a), 2 in (1, 2, n)


@pytest.mark.parametrize(("n", "a"), [(0, 0.5), (2, 0.0), (3, 2.0), (4, 4.0)])
def test_chains_and_memberships_are_those_of_python(n, a):
    @inlined
    def each(n, a):
        return tuple(chains(n, a, word) for word in ("half", "third", "none"))

    found = kernel(lambda n, a: each(n, a))(n, a)
    assert found == tuple(chains(n, a, word) for word in ("half", "third", "none"))


def generated(flag, n, t):
    """Generators have names of their own; sums begin where they are told to."""
    if flag:
        a = 1.0
    else:
        a = 2.0
    count, total = sum(1.0 for a in (1, 2)), 0.0
    for i in range(n):
        count = sum(1.0 for a in t)
        total = total + a * count
        a = a + i
    t = sum((x for x in t), 10.0) + sum((x for x in t), start=i)
    return count, total, t


def indices(n, k, t):
    """Items of tuples from both ends."""
    return t[n], t[-n], t[k], t[n > 1], sum(x * y for x, y in zip(t, (1.0, 2.0)))  # noqa: B905


@pytest.mark.parametrize("flag", [False, True])
def test_generators_and_indices_are_those_of_python(flag):
    t = (0.5, 2.5, 4.5)
    assert kernel(generated)(flag, 4, t) == generated(flag, 4, t)
    for n, k in ((1, np.uint8(2)), (2, np.uint64(0))):
        assert kernel(indices)(n, k, t) == indices(n, k, t)


def classes(a, values, word):
    kinds = isinstance(a, int | float), isinstance(a, (int, str)), isinstance(values, np.ndarray)
    return *kinds, isinstance((a, a), tuple), isinstance(word, str), isinstance(Pair(a), Pair)


def test_classes_are_those_of_python():
    found = kernel(lambda a, values: classes(a, values, "half"))
    assert found(1.0, ROW) == classes(1.0, ROW, "half")
    assert found(1, ROW) == classes(1, ROW, "half")


@inner_kernel
def picked(table, n):
    return table[n]


@inner_kernel
def added(numbers, x):
    for i in numbers:
        x += i
    return x


@kernel
def handed_over(n, x, place):
    """What functions of their own cannot be given is given all the same."""
    total = x
    for name, factor in (("half", 2.0), ("third", 4.0)):
        total += picked(TABLE, name) * factor
    place[()] += total
    return total, picked(ROW, n), added(range(n), x), added(range(n, 9), x)


def test_ranges_tables_and_constant_arrays_are_arguments():
    place = np.array(1.0)
    assert handed_over(3, 1.0, place) == (3.0, 3.0, 4.0, 34.0)
    assert place == 4.0


def one(value):
    return 1


def half(value):
    return 0.5 * value


@inlined
def total_of(function, values):
    total = 0
    for each in values:
        total += function(each)
    return total


class Kind(IntEnum):
    FIRST = 1
    SECOND = 2


NUMBERS = [0.5, 1.5]


@kernel
def totals(values, n):
    """Of integers by one function and of floats by another; of objects that only Python has."""
    table = tuple(NUMBERS[i] for i in range(len(NUMBERS)))
    found = total_of(one, values), total_of(half, values), Kind.SECOND * n, values[Kind.FIRST]
    return *found, *table, ROW.sum(), len(TABLE)


def test_functions_enumerations_and_lists_are_known():
    found = totals(ROW, 3)
    assert found == (5, 5.0, 6, 1.0, 0.5, 1.5, 10.0, 2)
    assert [*map(type, found)] == [int, float, int, *[float] * 4, int]


@inner_kernel
def factorial(n):
    return 1 if n < 2 else n * factorial(n - 1)


@allocating_kernel
def copies(values):
    n = 0
    while values.copy().sum() > n:
        n += 1
    return n


@allocating_kernel
def in_place(values):
    values += 1.0
    return values.sum()


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (kernel(lambda a: sum(x for x in (a[0], a[1]) if x > 0.0)), "what only the run knows"),
        (kernel(lambda a: a[1:]), "returns an array that it makes"),
        (kernel(lambda a: factorial(len(a))), "calls itself"),
        (kernel(lambda a: Pair(a, z=1.0)), "Pair takes x, y"),
        (kernel(lambda a: plain(a, b=1.0, d=1.0)), "plain takes a, b, c"),
        (kernel(lambda a: plain(a[0], 1.0, 1.0, 1.0)), "is given 4 arguments"),
        (kernel(lambda a: (a, a)[a[0]]), "float64 as the index"),
        (kernel(lambda a: added(range(a[0]), 0)), "bounds are no integers"),
        (kernel(lambda a: TABLE["fourth"]), "KeyError: 'fourth'"),
        (copies, "made in a loop"),
        (in_place, r"write values\[:\]"),
    ],
)
def test_what_would_be_wrong_is_refused(function, message):
    with pytest.raises(UntraceableError, match=message):
        function(ROW.copy())


def test_errors_of_python_and_numba_have_a_place():
    def missing(values):
        return TABLE["fourth"] * values[0]

    with pytest.raises(UntraceableError) as found:
        kernel(missing)(ROW)
    (note,) = found.value.__notes__
    assert note.endswith(
        f"{__file__}:{missing.__code__.co_firstlineno + 1}, in {missing.__qualname__}"
    )


@kernel
def unsigned(a, b, c):
    return a + b * c[0]


def test_numbers_of_numpy_are_arguments_and_none_may_be_missing():
    assert unsigned(np.uint8(200), np.uint64(3), (np.uint32(7),)) == 221
    call = Bound()
    for _ in range(2):
        assert call(unsigned, 1, 2, (3,)) == 7
    with pytest.raises(TypeError, match="3 arguments by position"):
        call(unsigned, 1, 2)
    with pytest.raises(TypeError, match="3 arguments by position"):
        call(unsigned, 1, 2, (3,), 4)
