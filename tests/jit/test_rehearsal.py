"""Rehearsals: kernels are noted with the types of their arguments, and not called."""

from pathlib import Path

import numpy as np
import pytest
import rank_scenes

from pgimp.case.load import load
from pgimp.jit.bound import Bound
from pgimp.jit.kernel import kernel
from pgimp.jit.rehearsal import marked, needed, note_calls, rehearsal
from pgimp.mpi.comm import Serial
from pgimp.scene.geometry import share
from pgimp.scene.scene import Scene
from pgimp.solver.start.warmup import _rehearse

CASES = Path(__file__).resolve().parents[2] / "cases"


@kernel
def doubled(values, found) -> tuple[int, float]:
    for i in range(len(values)):
        found[i] = 2.0 * values[i]
    return len(values), values[0]


def test_a_call_is_noted_once_and_not_made():
    values, found, call = np.ones(2), np.zeros(2), Bound()

    def twice():
        assert doubled(values, found) == call(doubled, values, found) == (0, 0.0)

    noted = note_calls(twice)
    assert [each for each, _ in noted] == [doubled] and not found.any()
    for each, types in noted:
        each.compile(types)
    assert call(doubled, values, found) == call(doubled, values, found) == (2, 1.0)
    assert found.tolist() == [2.0, 2.0]
    assert note_calls(lambda: doubled(values, found)) == []  # what is compiled is called


def test_what_is_needed_in_a_rehearsal_alone():
    marks = np.array([0, 3, 0])
    assert needed(2) and not needed(0) and marked(marks).tolist() == [1]
    with rehearsal():
        assert needed(0) and marked(marks).tolist() == [0, 1, 2]
    assert not needed(())


def noted(case):
    """Kernels of a stage's rehearsal, which are not compiled."""
    scene = Scene(case)
    scene.interaction.rigid_bodies.measure(Serial())
    with rehearsal():
        return note_calls(lambda: _rehearse(scene))


@pytest.mark.parametrize("path", sorted(CASES.glob("*.yaml")), ids=lambda path: path.stem)
def test_shipped_cases_are_rehearsed(path):
    """On several ranks, too, where kernels that are noted return zeros."""
    case = load(path)
    share(case, Serial())
    for each in case.stages:  # kernels compiled before in this process are not noted
        assert isinstance(noted(each), list)


@pytest.mark.parametrize("name", ["line_gimp", "initial_contact", "meeting"])
def test_a_rehearsal_leaves_the_scene_as_it_was(name):
    """Free rigid bodies too: their first states are the run's."""
    scene = Scene(load(rank_scenes.SCENES[name]).stages[0])
    scene.interaction.rigid_bodies.measure(Serial())
    before = [repr(state) for state in scene.interaction.rigid_bodies.first]
    with rehearsal():
        first, second = (note_calls(lambda: _rehearse(scene)) for _ in range(2))
    assert first == second
    assert [repr(state) for state in scene.interaction.rigid_bodies.first] == before
