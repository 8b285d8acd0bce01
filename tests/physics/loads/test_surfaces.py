"""Loads on any part of a surface: liquids, tubes, what follows, wrong entries."""

import numpy as np
import pytest
from scenes import box, field, scene, start

from pgimp.case.schema import Case
from pgimp.errors import CaseError

pytestmark = pytest.mark.slow(60)

EVERYWHERE = {"box": {"min": [-9.0, -9.0], "max": [99.0, 99.0]}}
DISK = {"ball": {"center": [4.1, 4.2], "radius": 2.53}}


def loaded(region, load, **parts):
    """A body of a region under one load."""
    body = {"material": "soft", "region": region, **parts.pop("body", {})}
    load = {"body": "body", "region": EVERYWHERE, **load}
    parts = {"cells": [9, 9], "end": 0.05, "step": 0.001} | parts
    return scene(2, body, tractions={"load": load}, **parts)


def force(sim):
    """Force on all in the first step, and their mass."""
    before = sim.diagnostics()
    sim.advance()
    after = sim.diagnostics()
    gained = np.array([after[f"momentum-{a}"] - before[f"momentum-{a}"] for a in "xy"])
    return gained / sim.dt, after["mass"]


@pytest.mark.parametrize("configuration", ["current", "initial"])
@pytest.mark.parametrize("region", [DISK, box([2.2, 1.7], [6.1, 5.9])["region"]])
def test_a_liquid_lifts_by_its_weight(region, configuration):
    load = {"hydrostatic": {"level": 8.0, "density": 0.7}}
    case = loaded(region, load, gravity=[0.0, -2.0], body={"formulation": configuration})
    sim = start(case)
    found, mass = force(sim)
    exact = 2.0 * (0.7 - 1.0) * mass
    np.testing.assert_allclose(found, [0.0, exact], rtol=0, atol=2e-4 * 0.7 * mass)
    line = sim.diagnostics()
    lift = [line["traction.load-x"], line["traction.load-y"]]
    np.testing.assert_allclose(lift, [0.0, 2.0 * 0.7 * mass], rtol=0, atol=2e-4 * 0.7 * mass)


def test_a_liquid_does_not_press_above_its_level():
    load = {"hydrostatic": {"level": 1.0, "density": 0.7}}
    found, mass = force(start(loaded(DISK, load, gravity=[0.0, -2.0])))
    np.testing.assert_allclose(found, [0.0, -2.0 * mass], rtol=1e-9, atol=1e-9)


def test_a_dead_load_keeps_its_direction_and_a_follower_turns():
    """Of a block that has turned by a quarter before: pressure on what was its right side."""
    block = box([3.0, 3.0], [6.0, 6.0])["region"]
    side = {"half-space": {"point": [5.5, 0.0], "normal": [-1.0, 0.0]}}
    for follower, expected in ((True, [0.0, -6.0]), (False, [-6.0, 0.0])):
        load = {"region": side, "pressure": 2.0, "follower": follower}
        sim = start(loaded(block, load))
        rows = sim.live()
        x = sim.particles.x[rows] - 4.5
        sim.particles.x[rows] = np.stack([-x[:, 1], x[:, 0]], axis=1) + 4.5
        sim.particles.F[rows] = [0.0, -1.0, 1.0, 0.0]
        sim.population.sort()
        # The ends of the side reach half a cell along the other faces, which balance each other.
        np.testing.assert_allclose(force(sim)[0], expected, atol=1e-9)
        line = sim.diagnostics()
        told = [line["traction.load-x"], line["traction.load-y"]]
        np.testing.assert_allclose(told, expected, atol=1e-9)


@pytest.mark.parametrize("configuration", ["current", "initial"])
def test_a_tube_widens_as_lame_says(configuration):
    """A quarter, of which the walls are planes of symmetry; 8 cells to the bore."""
    whole = {"intersection": [{"ball": {"center": [0.0, 0.0], "radius": 16.0}},
                              box([0.0, 0.0], [20.0, 20.0])["region"]]}  # fmt: skip
    tube = {"difference": [whole, {"ball": {"center": [0.0, 0.0], "radius": 8.0}}]}
    load = {"region": {"ball": {"center": [0.0, 0.0], "radius": 12.0}}, "pressure": 0.01}
    case = loaded(
        tube, load, cells=[20, 20], step={"courant": 0.3}, body={"formulation": configuration},
        boundaries={"x-min": "slip", "y-min": "slip"},
        start={"equilibrate": {"tolerance": 1e-3, "steps": 5000}},
    )  # fmt: skip
    sim = start(case)
    X = field(sim, "x")
    while sim.settling:
        sim.advance()
    R, r = np.hypot(*X.T), np.hypot(*field(sim, "x").T)
    exact = 1.3 * 0.01 * 64.0 / (100.0 * 192.0) * (0.4 * R + 256.0 / R)
    near = (R > 8.0) & (R < 9.0)
    assert (r - R)[near].mean() == pytest.approx(exact[near].mean(), rel=0.01)


def problem(load, **parts):
    with pytest.raises(Exception) as caught:
        Case.model_validate(loaded(DISK, load, **parts))
    return str(caught.value)


def test_wrong_entries_are_named():
    assert "needs gravity" in problem({"hydrostatic": {"level": 1.0, "density": 1.0}})
    assert "one of traction" in problem({"pressure": 1.0, "traction": [1.0, 0.0]})
    assert "a face of a box or a region" in problem({"pressure": 1.0, "face": "x-min"})
    assert "a region" in problem({"pressure": 1.0, "region": None})
    text = problem({"pressure": 1.0, "region": None, "face": "x-min"})
    assert "load.face" in text and "ball" in text and "region: {box: ..}" in text
    liquid = {"hydrostatic": {"level": 1.0, "density": 1.0}, "follower": False}
    assert "follower" in problem(liquid, gravity=[0.0, -1.0])


def test_a_region_that_touches_no_surface_is_refused():
    inside = {"ball": {"center": [4.0, 4.0], "radius": 1.0}}
    with pytest.raises(CaseError, match=r"load\.region: touches no surface of 'body'"):
        start(loaded(DISK, {"region": inside, "pressure": 1.0}))
