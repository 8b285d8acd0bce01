"""The book of momentum with a gravity by a function of one's own."""

from math import sin

import numpy as np
import pytest
from scenes import box, scene

import pgimp
from pgimp.physics.functions.registry import FUNCTIONS
from pgimp.running.accuracy.books import momentum_books
from pgimp.running.accuracy.find import of_run


@pytest.fixture(autouse=True)
def registered():
    """Functions that a test registers are gone after it."""
    before = dict(FUNCTIONS)
    yield
    FUNCTIONS.clear()
    FUNCTIONS.update(before)


def pulse(t, height):
    return height * sin(9.0 * t) ** 2


def fallen(**parts):
    """A block that falls freely by a pulse of gravity, which eleven steps hardly resolve."""
    gravity = [0.0, {"function": "pulse", "parameters": {"height": -3.0}}]
    return scene(2, box([2.0, 2.0], [5.0, 5.0]), cells=[8, 8], gravity=gravity, end=0.22, **parts)


@pytest.mark.parametrize("step", [0.02, {"courant": 0.3}])
def test_a_step_takes_the_force_at_its_beginning(tmp_path, step):
    """So that the momentum is not that of the integral over time, and no line blames it."""
    pgimp.coefficient(pulse)
    case = fallen(step=step, history={"every": {"steps": 1}})
    run = pgimp.run(case, output=tmp_path / "run", quiet=True)
    (_, book), why = momentum_books(run.case, np.asarray(run.history))
    assert not why and abs(book.rest) < 1e-12 * book.scale
    case = fallen(step=step, history={"every": {"steps": 4}})
    run = pgimp.run(case, output=tmp_path / "seldom", quiet=True)
    (_, book), _ = momentum_books(run.case, np.asarray(run.history))
    assert abs(book.rest) < (1e-12 if step == 0.02 else 5e-3) * book.scale


def stronger(t, height):
    return 2.0 * height * sin(9.0 * t) ** 2


def test_a_function_that_was_edited_leaves_no_book(tmp_path):
    pgimp.coefficient(pulse)
    case = fallen(step=0.02, checkpoint={"every": {"steps": 5}})
    short = {**case, "time": {**case["time"], "end": 0.1}}
    run = pgimp.run(short, output=tmp_path / "run", quiet=True)
    assert any(one.name == "momentum" for one in of_run(run))
    del FUNCTIONS["pulse"]
    stronger.__name__, stronger.__qualname__ = "pulse", "pulse"
    pgimp.coefficient(stronger)
    run = pgimp.run(case, output=tmp_path / "run", quiet=True, resume=True)
    assert not any(one.name == "momentum" for one in of_run(run))
    assert "accuracy: momentum" not in (run.path / "log.txt").read_text()
