"""Kernels called by their entry points (`pgimp.jit.bound`)."""

from typing import NamedTuple

import numpy as np
import pytest
import rank_scenes
from scenes import start

from pgimp.jit import bound
from pgimp.jit.bound import Bound, require_same_types
from pgimp.jit.kernel import kernel


class Pair(NamedTuple):
    values: np.ndarray
    factor: float


@kernel
def total(pair, number):
    return pair.values.sum() * pair.factor + number


def test_calls_give_what_the_kernel_gives():
    call = Bound()
    for n in range(1, 5):
        pair = Pair(np.arange(float(n)), 2.0)
        assert call(total, pair, n) == total(pair, n) == n * (n - 1) + n
    with pytest.raises(TypeError, match="an argument has another type"):
        call(total, Pair(np.arange(3, dtype=np.int32), 2.0), 1)  # what it does see


def test_checked_calls_refuse_other_types(monkeypatch):
    """Without the check this call would read 1.5 as an integer."""
    monkeypatch.setattr(bound, "CHECKED", True)
    call, pair = Bound(), Pair(np.arange(3.0), 2.0)
    assert call(total, pair, 1) == call(total, pair, 2) - 1
    with pytest.raises(TypeError, match="total is called with other types: argument 2 is float64"):
        call(total, pair, 1.5)


def test_other_functions_are_called_as_they_are():
    call = Bound()
    assert [call(max, 1, 2), call(max, 0.5, 0.25)] == [2, 0.5]


@pytest.mark.parametrize("name", ["line_mpm", "plane_gimp", "plane_leaves"])
def test_a_run_calls_each_kernel_with_the_same_types(name, monkeypatch):
    """Walls, constraints and gravity by tables, particles that leave, stops."""
    seen = set()

    def checked(kernel, first, now):
        seen.add(kernel)
        require_same_types(kernel, first, now)

    monkeypatch.setattr(bound, "CHECKED", True)
    monkeypatch.setattr(bound, "require_same_types", checked)
    sim = start(getattr(rank_scenes, name)())
    while not sim.finished and sim.step < 300:
        sim.advance()
    assert len(seen) >= 3
