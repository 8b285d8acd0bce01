"""The parts of a step: one table, in which all of them stand, and the order of their calls."""

import importlib
import pkgutil

import pytest
from scenes import start
from two_blocks import flying

import pgimp.solver
from pgimp.errors import CaseError
from pgimp.solver.damping.relaxation import Relaxation
from pgimp.solver.parts import PARTS, parts_of
from pgimp.solver.vertices import StepPart

CALLS = (
    "begin", "strain", "add_forces", "slow", "book", "force_particles", "complete",
    "change_particles",
)  # fmt: skip


def test_each_kind_of_part_is_made_by_the_table():
    """But for the damping of a run that settles, which takes the place of the scene's."""
    for module in pkgutil.walk_packages(pgimp.solver.__path__, "pgimp.solver."):
        importlib.import_module(module.name)
    made = {make.__module__ for make in PARTS.values()}
    kinds = {kind for kind in StepPart.__subclasses__() if kind.__module__.startswith("pgimp.")}
    assert {kind.__module__ for kind in kinds - {Relaxation}} == made
    assert len(kinds) == 1 + len(made)


def test_a_scene_without_features_has_no_part():
    assert parts_of(start(flying()).rank) == []


def test_a_further_part_acts_by_one_entry(monkeypatch):
    """It sees the step in the order of its methods, and what it adds to the forcing counts."""
    seen = []

    class Slower(StepPart):
        def __getattribute__(self, name):
            seen.extend([name] * (name in CALLS))
            return super().__getattribute__(name)

        def force_particles(self, rank, order, t, forcing):
            return forcing._replace(dt=0.0)

    plain = start(flying())
    plain.advance()
    monkeypatch.setitem(PARTS, "slower", lambda scene, comm, before: before or Slower())
    sim = start(flying())
    rows = sim.live()
    before = sim.particles.x[rows]
    sim.advance()
    assert tuple(seen) == CALLS
    assert (sim.particles.x[rows] == before).all()
    assert (plain.particles.x[rows] != before).any()
    assert sim.time == plain.time


def test_steps_are_short_enough_for_a_part(monkeypatch):
    """Controlled ones follow its rate; a fixed one that is too long is refused."""

    class Fast(StepPart):
        rate = 1.0e4

    monkeypatch.setitem(PARTS, "fast", lambda scene, comm, before: before or Fast())
    followed = flying() | {"time": {"end": 1.0, "step": {"courant": 0.2}}}
    sim = start(followed)
    for _ in range(3):
        sim.advance()
        assert sim.now.dt == pytest.approx(0.2e-4)
    with pytest.raises(CaseError, match=r"time\.step: 0\.01 is a Courant number of 100,"):
        start(flying())


@pytest.mark.parametrize("name", PARTS)
def test_a_part_goes_on_from_the_one_before(name):
    """Each maker takes scene, communicator and the part of the stage before."""
    sim = start(flying())
    assert PARTS[name](sim.scene, sim.comm, None) is None
