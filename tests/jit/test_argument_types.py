"""Types of kernels' arguments: those that Numba finds, and each looked for once."""

from typing import NamedTuple

import numba
import numpy as np
import pytest
import rank_scenes
from scenes import start

from pgimp.jit import argument_types
from pgimp.jit.argument_types import type_of


class Pair(NamedTuple):
    values: np.ndarray
    factor: float


class Other(NamedTuple):
    values: np.ndarray
    factor: float


def constant(shape):
    values = np.zeros(shape)
    values.flags.writeable = False
    return values


RECORDS = np.zeros(3, [("x", "f8"), ("y", "i4", (2,))])
VALUES = [
    0, -1, 2**31, 2**40, 2**62 - 1, 2**62, 2**63 - 1, -(2**63), 2**63, 1.5, True, None, "text",
    np.float64(1.0), np.float32(1.0), np.int16(1), np.bool_(True), np.datetime64(1, "s"),
    np.zeros(3), np.zeros(3, np.int32), np.zeros((3, 4)), np.zeros((3, 4)).T,
    np.zeros((3, 4))[:, ::2], np.zeros((0, 4)), np.zeros((1, 4)), np.zeros(()), constant(3),
    RECORDS, RECORDS["x"], RECORDS[0],
    (), (1,), (1, 2), (1, 2.0), (True, 2), (1, 2**63), ((), (1.0,)), ((1.0,), ()),
    Pair(np.zeros(3), 1.0), Pair(np.zeros(3, "f4"), 1.0), Pair(np.zeros((3, 1)), ()),
    Other(np.zeros(3), 1.0), (Pair(np.zeros(3), 1.0), None), (None, Pair(constant(3), 1.0)),
]  # fmt: skip


@pytest.mark.parametrize("again", [False, True])
def test_types_are_those_of_numba(again):
    for value in VALUES:
        assert type_of(value) is numba.typeof(value), value


@pytest.mark.filterwarnings("ignore:First-class function type")
def test_functions_that_are_gone_are_not_taken_for_others():
    """Each has a type of its own, whose place in the memory another may have later."""
    for _ in range(200):
        function = numba.njit(lambda x: x)
        value = (function, 1.0)
        assert type_of(value) is numba.typeof(value)
        del function, value


def test_values_without_a_type_are_refused():
    for value in (object(), (1, object())):
        with pytest.raises(ValueError, match="Cannot determine Numba type"):
            type_of(value)


def test_another_simulation_looks_for_no_type_of_an_array(monkeypatch):
    """It took a third of the time of a start without compilation."""

    def steps():
        sim = start(rank_scenes.SCENES["line_gimp"])
        for _ in range(3):
            sim.advance()
        sim.diagnostics()

    steps()
    seen, find = [], numba.typeof
    looked = type("Numba", (), {"typeof": staticmethod(lambda v: seen.append(v) or find(v))})
    monkeypatch.setattr(argument_types, "numba", looked)
    steps()
    assert not seen
