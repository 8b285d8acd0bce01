"""Sinks: what comes into a region of `outflow` is taken out, and its sums are booked.

That the number of ranks and a resume change no bit of such a run: tests/proofs/test_ranks.py.
"""

import numpy as np
import pytest
from scenes import box, finish, scene, start
from tiers import wide

import pgimp
from pgimp.mpi.comm import Serial

pytestmark = pytest.mark.slow(60)

SPEED = 2.0
#: By dimension: where a block that flies along x goes out, and how much of its section.
BALL = {"ball": {"centre": [8.0, 2.0], "radius": 1.1}}
REGIONS = {
    1: {"box": {"min": [7.0], "max": [9.0]}},
    2: {"union": [{"box": {"min": [7.0, 1.0], "max": [9.0, 2.0]}}, BALL]},
    3: {"half-space": {"point": [7.0, 0.0, 0.0], "normal": [-1.0, 0.0, 0.0]}},
}


def flying(dimension, **parts):
    """A block, 2 cells long, that flies along x at a constant speed."""
    low = [2.0, *[1.0] * (dimension - 1)]
    body = box(low, [a + 2.0 for a in low], [SPEED, *[0.0] * (dimension - 1)])
    entries = {"cells": [12, 4, 4][:dimension], "end": 4.0, "step": 0.02}
    return scene(dimension, body, **entries | parts)


def sums(p, rows):
    """Mass, momentum along x, and kinetic energy."""
    m, v = p.m[rows], p.v[rows]
    return np.array([m.sum(), m @ v[:, 0], 0.5 * m @ (v**2).sum(axis=1)])


@pytest.mark.parametrize("dimension", [1, 2, wide(3)])
def test_what_is_inside_when_a_step_ends_is_taken_out_and_booked(dimension):
    """Exactly these particles, in each step: the block flies as if nothing happened."""
    case = flying(dimension, outflow={"drain": {"region": REGIONS[dimension]}})
    sim, free = start(case), start(flying(dimension))
    region = sim.case.outflow["drain"].region
    names = ("mass", "momentum-x", "kinetic-energy")
    begun, gone, left = sums(sim.particles, sim.live()), np.zeros(3), set()
    while not sim.finished:
        sim.advance()
        free.advance()
        p = free.particles
        inside = p.id[free.live()][region.contains(p.x[free.live()])]
        left |= set(inside.tolist())
        there = set(sim.particles.id[sim.live()].tolist())
        assert there == set(range(sim.count)) - left
        line = sim.diagnostics()
        gone = begun - sums(sim.particles, sim.live())
        booked = [line[f"outflow.{name}"] for name in names]
        assert booked == pytest.approx(gone, abs=1e-12)
        assert line["dissipated-energy"] == pytest.approx(0.0, abs=1e-12)
    part = {1: 1.0, 2: 0.5, 3: 1.0}[dimension]  # of the section
    assert gone[0] / begun[0] >= part and (dimension == 2 or len(there) == 0)
    assert sim.present() == len(there)


def test_stages_open_and_close_a_sink():
    """Closed, half of the stream has passed by its region."""
    case = flying(1, end=2.5)  # the block is at 7 to 9
    case["time"]["stages"] = [
        {"name": "opened", "end": 2.52, "outflow": {"drain": {"region": REGIONS[1]}}},
        {"name": "closed", "end": 3.0, "outflow": {"drain": None}},
    ]
    case["bodies"] = {"first": case["bodies"]["body"], "second": box([0.0], [1.0], [SPEED])}
    line = finish(start(case)).diagnostics()
    assert line["body.first.mass"] == 0.0 and line["body.second.mass"] == 1.0
    assert line["outflow.mass"] == 2.0
    assert line["outflow.momentum-x"] == pytest.approx(2.0 * SPEED, rel=1e-13)


def test_bodies_in_the_initial_configuration_stay_what_they_are():
    """Of a pair only the one in the current configuration goes out."""
    bodies = {
        "stays": box([2.0, 1.0], [4.0, 2.0], [SPEED, 0.0]) | {"formulation": "total-lagrangian"},
        "goes": box([2.0, 2.5], [4.0, 3.5], [SPEED, 0.0]),
    }
    case = flying(2, outflow={"drain": {"region": REGIONS[2]}}, contact=[{"bodies": "all"}])
    line = finish(start(case | {"bodies": bodies})).diagnostics()
    assert line["body.stays.mass"] == 2.0 and line["outflow.mass"] == 1.0
    assert line["body.goes.mass"] + line["outflow.mass"] == pytest.approx(2.0, rel=1e-14)


def test_a_scene_without_sinks_has_none_and_the_log_names_those_that_there_are(tmp_path):
    assert start(flying(1, outflow={"x-max": "remove"})).rank.sinks is None
    case = flying(1, outflow={"drain": {"region": REGIONS[1]}})
    run = pgimp.run(pgimp.load(case), Serial(), tmp_path / "out", quiet=True)
    assert "4 of 4 particles left through drain" in (run.path / "log.txt").read_text()
    resolved = pgimp.load(run.path / "case.yaml")
    assert resolved.outflow == run.case.outflow
