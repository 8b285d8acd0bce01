"""Loads on any part of a surface, crossed with regions, dimensions, shapes, rings and contact.

A liquid around a body lifts it by the weight of the displaced liquid: of the whole body at once, so
that the mass of its particles is the exact volume.
"""

import numpy as np
import pytest
from mesh_bodies import BALL, mesh
from meshes import stl
from scenes import scene, start
from tiers import wide

pytestmark = pytest.mark.slow(90)

LIQUID = {"hydrostatic": {"level": 8.0, "density": 0.7}}
EVERYWHERE = {"min": [-99.0] * 3, "max": [99.0] * 3}


def lift(region, D, *, more=None, load=LIQUID, **parts):
    """Force per mass of the load on a body in the first step, with the body's mass."""
    g = [0.0, -2.0, 0.0][:D]
    body = {"material": "soft", "region": region, **parts.pop("body", {})}
    box = {name: ends[:D] for name, ends in EVERYWHERE.items()}
    tractions = {"load": {"body": "body", "region": {"box": box}, **load}}
    parts = {"cells": [9] * D, "end": 0.05, "step": 0.001, "gravity": g} | parts
    sim = start(scene(D, {"body": body, **(more or {})}, tractions=tractions, **parts))
    before = sim.diagnostics()
    sim.advance()
    after, p, rows = sim.diagnostics(), sim.particles, sim.live()
    axes = "xyz"[:D] if not parts.get("geometry") else "y"
    gained = np.array([after[f"momentum-{a}"] - before[f"momentum-{a}"] for a in axes])
    mass = after["mass"]
    own = p.m[rows][p.body[rows] == 0].sum() / p.m[rows].sum() * mass
    weight = np.array([mass * g["xyz".index(a)] for a in axes])
    return (gained / sim.dt - weight) / own, sim


@pytest.mark.parametrize("configuration", ["current", "initial"])
@pytest.mark.parametrize(
    "region",
    [
        {"ball": {"center": [4.1, 4.2, 3.9], "radius": 2.53}},
        pytest.param(
            {"cylinder": {"from": [2.3, 3.1, 2.9], "to": [6.4, 5.2, 5.1], "radius": 1.4}},
            marks=pytest.mark.wide,
        ),
        "mesh",
    ],
)
def test_a_liquid_lifts_bodies_in_3d(tmp_path, region, configuration):
    if region == "mesh":
        stl(tmp_path / "ball.stl", BALL * 1.7 + [4.1, 4.2, 3.9])
        region = mesh(tmp_path / "ball.stl")
    force, _ = lift(region, 3, body={"formulation": configuration})
    np.testing.assert_allclose(force, [0.0, 1.4, 0.0], rtol=0, atol=2e-3)


@pytest.mark.wide
def test_half_a_disk_is_a_ball_under_water():
    """In axisymmetric scenes, where the ball has its exact volume."""
    disk = {"ball": {"center": [0.0, 4.2], "radius": 2.53}}
    force, _ = lift(disk, 2, geometry="axisymmetric", boundaries={"x-min": "slip"})
    np.testing.assert_allclose(force, [1.4], rtol=0, atol=2e-3)


def test_a_ring_bears_the_pressure_on_its_end():
    """On the upper end of a tube: p pi (b^2 - a^2), over 2 pi as all totals or not."""
    tube = {"box": {"min": [2.0, 2.0], "max": [5.0, 6.0]}}
    top = {"region": {"box": {"min": [-9.0, 5.9], "max": [9.0, 9.0]}}, "pressure": 3.0}
    force, _ = lift(tube, 2, load=top, geometry="axisymmetric", boundaries={"x-min": "slip"})
    np.testing.assert_allclose(force, [-3.0 / 4.0], rtol=1e-9)  # p A / (rho A h)


@pytest.mark.parametrize("shape", ["mpm", wide("cpdi")])
def test_every_shape_bears_the_whole_load(shape):
    disk = {"ball": {"center": [4.1, 4.2], "radius": 2.53}}
    force, _ = lift(disk, 2, shape=shape)
    np.testing.assert_allclose(force, [0.0, 1.4], rtol=0, atol=2e-3)


@pytest.mark.wide
def test_a_body_bears_its_load_beside_another_under_contact():
    """In velocity fields of their own; the other one falls freely."""
    other = {"material": "soft", "region": {"box": {"min": [6.7, 2.0], "max": [8.0, 7.0]}}}
    disk = {"ball": {"center": [4.1, 4.2], "radius": 2.53}}
    force, sim = lift(disk, 2, more={"other": other}, contact=[{"bodies": "all", "friction": 0.2}])
    np.testing.assert_allclose(force, [0.0, 1.4], rtol=0, atol=2e-3)
    rows = sim.live()
    free = sim.particles.v[rows][sim.particles.body[rows] == 1]
    np.testing.assert_allclose(free, np.tile([0.0, -0.002], (len(free), 1)), rtol=0, atol=1e-12)


def test_a_load_turns_nothing_that_it_should_not():
    """The moment of a liquid about the middle of a disk is 0, to a part of force times radius."""
    disk = {"ball": {"center": [4.1, 4.2], "radius": 2.53}}
    _, sim = lift(disk, 2)
    p, rows = sim.particles, sim.live()
    arm, v = p.x[rows] - [4.1, 4.2], p.v[rows]
    turned = (p.m[rows] * (arm[:, 0] * v[:, 1] - arm[:, 1] * v[:, 0])).sum()
    assert abs(turned) < 1e-3 * sim.dt * 1.4 * p.m[rows].sum() * 2.53
