"""Records of arrays are passed to parts of kernels whole; kernels get their items one by one."""

from typing import NamedTuple

import numba
import numpy as np
import pytest

from pgimp.jit.compiled.arguments import PartTypes, passed_whole
from pgimp.jit.kernel import inner_kernel, kernel
from pgimp.kernels.data.arguments import Order


class Numbers(NamedTuple):
    """A record without arrays, as of a material's parameters."""

    a: float
    b: float


class Mixed(NamedTuple):
    """A record of several types, some of them records."""

    order: Order
    flag: bool
    numbers: Numbers
    nothing: tuple = ()


ORDER = Order(np.arange(5), np.arange(3))
RECORDS = {
    "of arrays": (ORDER, True),
    "of several types": (Mixed(ORDER, True, Numbers(2.0, 3.0)), True),
    "of numbers": (Numbers(2.0, 3.0), False),
    "without a name": (tuple(ORDER), False),
}


@pytest.mark.parametrize(("record", "whole"), RECORDS.values(), ids=RECORDS.keys())
def test_records_of_arrays_are_passed_whole(record, whole):
    assert passed_whole(numba.typeof(record)) == whole


@inner_kernel
def _inner(record, factor):
    order, numbers = record.order, record.numbers
    chosen = numbers.a if record.flag else numbers.b
    for i in range(len(order.rows)):
        order.rows[i] += int(factor * chosen) + order.start[1]


@kernel
def _outer(record, factor):
    _inner(record, factor)


@pytest.mark.parametrize("flag", [True, False])
def test_a_part_gets_all_of_a_record(flag):
    rows = np.arange(5)
    record = Mixed(Order(rows, np.array([7, 4])), flag, Numbers(2.0, 3.0))
    _outer(record, 10.0)
    np.testing.assert_array_equal(rows, np.arange(5) + (24 if flag else 34))
    for function, is_part in ((_inner, True), (_outer, False)):
        for compiled in function.overloads.values():
            assert isinstance(compiled.fndesc.argtypes, PartTypes) == is_part
