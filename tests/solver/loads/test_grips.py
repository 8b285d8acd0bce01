"""Grips that given forces move: against exact motions, momentum, rest, stages, restarts."""

import numpy as np
import pytest
from loaded_block import loaded
from run_files import digests
from scenes import box, field, finish, scene, start

import pgimp
from pgimp.case.schema import Case
from pgimp.mpi.comm import Serial

pytestmark = pytest.mark.slow(60)

RAMP = [[0.0, 0.0], [0.3, 6.0], [1.0, -2.0]]


def press(low, high, *force, **more):
    """A grip on what lies in a box."""
    return {"body": "body", "region": {"box": {"min": low, "max": high}}, "force": [*force], **more}


def bar(grip, **parts):
    """A bar from 2 to 10; weight 8."""
    parts = {"cells": [14], "end": 1.0, "constraints": {"press": grip}, **parts}
    return scene(1, box([2.0], [10.0]), **parts)


@pytest.mark.wide
def test_a_force_moves_the_mass_of_grip_and_addition():
    sim = start(bar(press([0.0], [12.0], 6.0, mass=4.0)))
    finish(sim)
    np.testing.assert_allclose(field(sim, "v")[:, 0], 0.5, rtol=1e-12)
    line = sim.diagnostics()
    assert line["displacement.press-x"] == pytest.approx(0.5 * 0.5 * 1.01, rel=1e-12)
    assert line["external-work"] == pytest.approx(line["kinetic-energy"], rel=0.02)


def test_a_spring_swings_as_it_should():
    """Of a rigid bar: x = F/k (1 - cos wt) with w^2 = k/m, and the decay of a dashpot."""
    sim = start(bar(press([0.0], [12.0], 40.0, spring={"stiffness": 200.0}), end=2.0))
    w, line = np.sqrt(200.0 / 8.0), {}
    for _ in range(200):
        sim.advance()
        line = sim.diagnostics()
        x = 0.2 * (1.0 - np.cos(w * sim.time))
        assert line["displacement.press-x"] == pytest.approx(x, abs=0.2 * 0.04)
    grip = press([0.0], [12.0], 0.0, spring={"stiffness": 0.0, "dashpot": 16.0})
    sim = start(bar(grip) | {"bodies": {"body": box([2.0], [10.0], [3.0])}})
    finish(sim)
    np.testing.assert_allclose(field(sim, "v")[:, 0], 3.0 * np.exp(-2.0), rtol=1e-4)


def test_a_stiff_spring_does_not_shorten_the_steps():
    sim = start(bar(press([0.0], [12.0], 1.0, spring={"stiffness": 1e8}), end=3.0))
    finish(sim)
    assert abs(sim.diagnostics()["displacement.press-x"]) < 1e-3


@pytest.mark.parametrize("configuration", ["current", "initial"])
def test_momentum_grows_by_the_force_alone(configuration):
    """Of a block with a grip, of which one half is pulled to and fro, and turned about."""
    force = [{"table": RAMP}, 2.0]
    case = loaded(
        constraints={"pull": press([6.0, 0.0], [8.0, 5.0], *force)}, tractions={},
        boundaries={}, gravity=[0.0, 0.0], end=0.6,
    )  # fmt: skip
    case["bodies"]["body"] = box([2.1, 2.0], [8.0, 5.0], [2.0, 0.0]) | {
        "formulation": configuration
    }
    if configuration == "initial":
        case["materials"]["soft"] = {k: v for k, v in case["materials"]["soft"].items()
                                     if k != "viscosity"}  # fmt: skip
    sim = start(case)
    before = sim.diagnostics()
    while not sim.finished:
        t = sim.time
        sim.advance()
        line = sim.diagnostics()
        given = np.array([np.interp(t, *np.transpose(RAMP)), 2.0])
        gain = [line[f"momentum-{a}"] - before[f"momentum-{a}"] for a in "xy"]
        np.testing.assert_allclose(gain, sim.dt * given, rtol=0, atol=1e-9)  # light vertices
        force = [line[f"constraint.pull-{a}"] for a in "xy"]
        np.testing.assert_allclose(force, given, rtol=0, atol=1e-7)
        before = line
    held = field(sim, "constraint")[:, 0] == 1
    for d in range(2):
        np.testing.assert_allclose(np.ptp(field(sim, "v")[held, d]), 0.0, atol=1e-12)
    assert before["displacement.pull-x"] > 1.0


@pytest.mark.parametrize("configuration", ["current", "initial"])
def test_a_press_comes_to_rest_where_the_force_is_balanced(configuration):
    """A bar of 8 on a wall, of which 7 up to a vertex are strained, with a spring in parallel."""
    body = box([0.0], [8.0]) | {"formulation": configuration}
    case = scene(
        1, body, cells=[14], end=0.5, boundaries={"x-min": "fixed"},
        start={"equilibrate": {"tolerance": 1e-5, "steps": 20000}},
        constraints={"press": press([7.5], [9.0], -0.5, spring={"stiffness": 100.0 / 7.0})},
    )  # fmt: skip
    if configuration == "initial":
        case["materials"] = {"soft": {"model": "neo-hookean", "young": 100.0, "poisson": 0.0,
                                      "density": 1.0}}  # fmt: skip
    sim = start(case)
    while sim.settling:
        sim.advance()
    sim.diagnostics()
    finish(sim)
    line = sim.diagnostics()
    assert line["reaction.x-min-x"] == pytest.approx(0.25, rel=5e-3)
    assert line["constraint.press-x"] == pytest.approx(-0.25, rel=5e-3)
    assert abs(line["displacement.press-x"]) < 1e-5  # since time 0
    assert sim.rank.grips.state[0, 2, 0] == pytest.approx(-0.0175, rel=0.02)


@pytest.mark.wide
def test_a_stage_lets_go_of_a_press_and_brings_it_to_a_velocity():
    grip = press([8.0], [12.0], 2.0)
    then = {"name": "drive", "end": 0.4,
            "constraints": {"press": {"force": [], "velocity": [-1.0]}}}  # fmt: skip
    last = {"name": "again", "end": 0.6,
            "constraints": {"press": {"force": [2.0], "velocity": []}}}  # fmt: skip
    case = bar(grip, end=0.2)
    case["time"] |= {"stages": [then, last]}
    sim = start(case)
    way, before = 0.0, 0.0
    while not sim.finished:
        sim.advance()
        line = sim.diagnostics()
        held = field(sim, "constraint")[:, 0] == 1
        way += sim.dt * field(sim, "v")[held, 0].mean()
        assert line["displacement.press-x"] == pytest.approx(way, rel=1e-9, abs=1e-12)
        if sim.stage == 1:
            np.testing.assert_array_equal(field(sim, "v")[held, 0], -1.0)
        assert abs(line["displacement.press-x"] - before) < 0.02
        before = line["displacement.press-x"]


def problems(**entry):
    grip = {"body": "body", "region": {"box": {"min": [7.0, 0.0], "max": [8.0, 4.0]}}}
    with pytest.raises(Exception) as caught:
        Case.model_validate(loaded(constraints={"pull": grip | entry}))
    return str(caught.value)


def test_wrong_entries_are_named():
    text = problems(velocity=[1.0, None], force=[2.0, 0.0])
    assert "constraints.pull.force.0" in text and "force.1" not in text
    assert "a velocity, a rotation or a force" in problems()
    assert "constraints.pull.mass" in problems(velocity=[1.0, 0.0], mass=2.0)
    assert "stiffness" in problems(force=[1.0, 0.0], spring={"dashpot": 2.0})
    assert "has no force" in problems(force=[1.0, 0.0], spring={"stiffness": 0.0})
    assert "expected 2 entries" in problems(force=[1.0])


def test_a_stage_ends_the_last_press(tmp_path):
    """And all other loads; what is left flies on, resumed or not, with the columns of before."""
    case = bar(
        press([8.0], [12.0], 2.0), end=0.2, damping={"mass": 1.0}, gravity=[-1.0],
        tractions={"push": {"body": "body", "face": "x-min", "traction": [1.0]}},
        boundaries={"x-min": "fixed"}, outflow={"x-max": "remove"}, output={"every": 0.1},
    )  # fmt: skip
    ended = {name: {key: None for key in case[name]}
             for name in ("constraints", "tractions", "boundaries", "outflow")}  # fmt: skip
    free = {"name": "free", "end": 0.4, "damping": None, "gravity": None, **ended}
    staged = case | {"time": case["time"] | {"stages": [free]}}
    options = {"comm": Serial(), "quiet": True}
    together = pgimp.run(staged, output=tmp_path / "together", **options)
    pgimp.run(case, output=tmp_path / "parts", **options)
    pgimp.run(staged, output=tmp_path / "parts", resume=True, **options)
    assert digests(tmp_path / "parts") == digests(together.path)
    momentum = together.history["momentum-x"][together.history["time"] >= 0.2]
    np.testing.assert_allclose(momentum, momentum[0], rtol=1e-12)
    assert np.isnan(together.history["displacement.press-x"][-1])
