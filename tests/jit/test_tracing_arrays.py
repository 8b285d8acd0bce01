"""Arrays in traced kernels: read, set, made and released as by Python."""

import numpy as np
import pytest
from numba.core.runtime import _nrt_python, rtsys

from pgimp.jit.kernel import allocating_kernel, kernel
from pgimp.jit.tracing.values import UntraceableError

POINT = np.dtype([("x", np.float64), ("normal", np.float64, 2), ("count", np.int64)])


@kernel
def traced_arrays(matrix, rows, points, scale):
    """Entries, rows, parts and records of arrays, read and set."""
    matrix[1:, 0] = scale
    for j in range(2):
        matrix[0, j] += 1.0
    for row in rows:
        matrix[row, -1] = matrix[row, 0] + matrix.shape[1] * len(rows)
        point = points[row]
        point.x, point.count = matrix[row, 1], point.count + row
        point.normal[0] = point.normal[1] = point.x
        points[0].count += 1
    line = matrix[rows[0]]
    line[1] -= 4.0
    found = line[0]
    if scale > 1.0:
        for j in range(1, len(line)):
            found += line[j]
    return found


@pytest.mark.parametrize("scale", [0.5, 2.0])
def test_arrays_are_those_of_python(scale):
    rng = np.random.default_rng(7)
    matrix, rows = rng.random((4, 3)), np.array([2, 0, 3], np.int32)
    points = np.zeros(4, POINT).view(np.recarray)
    other = matrix.copy(), points.copy()
    found = traced_arrays(matrix, rows, points.view(np.ndarray), scale)

    def plain(matrix, rows, points, scale):
        matrix[1:, 0] = scale
        matrix[0, :2] += 1.0
        for row in rows:
            matrix[row, -1] = matrix[row, 0] + 9
            points["x"][row] = matrix[row, 1]
            points["count"][row] += row
            points["normal"][row] = matrix[row, 1]
            points["count"][0] += 1
        matrix[rows[0], 1] -= 4.0
        return matrix[rows[0]].sum() if scale > 1.0 else matrix[rows[0], 0]

    assert found == plain(other[0], rows, other[1], scale)
    assert np.array_equal(matrix, other[0])
    assert all(np.array_equal(points[name], other[1][name]) for name in POINT.names)


@allocating_kernel
def made(values, n):
    """Arrays made, in part for results, in inlined functions too; an argument is returned."""
    scratch, (low, high) = np.empty(n), np.zeros((2, 3))
    total = 0.0
    for i in range(n):
        scratch[i] = sum_of_squares(values, i)
        total += scratch[i]
    low[0], high[1] = total, 2.0 * total
    some = scratch[: n - 1].copy()
    if n > 3:
        some = np.full(2, total)
    return values, low, some, high[1:], total


@allocating_kernel
def sum_of_squares(values, n):
    squares = np.empty(n + 1)
    for i in range(n + 1):
        squares[i] = values[i] ** 2
    part = squares[1:]
    return part.sum() + squares[0]


@pytest.mark.parametrize("n", [3, 5])
def test_arrays_made_by_a_kernel_are_right_and_none_is_lost(n):
    values = np.arange(1.0, 9.0)
    squares = np.cumsum(values**2)[:n]
    total = squares.sum()
    before = None
    made(values, n)
    _nrt_python.memsys_enable_stats()
    for _ in range(3):
        given, low, some, high, found = made(values, n)
        assert given is values or np.shares_memory(given, values)
        assert found == pytest.approx(total) and low[0] == found
        assert [*some] == pytest.approx([total, total] if n > 3 else [*squares[:-1]])
        assert [*high] == pytest.approx([2.0 * total, 0.0])
        del given, low, some, high
        now = rtsys.get_allocation_stats()
        assert before is None or now.alloc - now.free == before.alloc - before.free
        assert now.alloc - now.free >= 0
        before = now


def test_an_array_made_in_a_loop_is_refused():
    @allocating_kernel
    def grows(n):
        found = np.empty(1)
        for i in range(n):
            found = np.empty(i)
        return found

    with pytest.raises(UntraceableError, match="made in a loop"):
        grows(3)
