"""Rigid bodies and round ones: they feel each other when they touch, inclined to the grid too."""

from math import cos, radians, sin

import numpy as np
import pytest
from scenes import start

pytestmark = pytest.mark.slow(20)

SPEED = 0.005


def ring(middle, inner, outer):
    balls = [{"ball": {"centre": middle.tolist(), "radius": r}} for r in (outer, inner)]
    return {"difference": balls}


def first(disk, other, way, rigid, gap):
    """Gap that is left before the step in which the disk first feels the other body."""
    bodies = {"disk": {"region": disk}, "other": {"region": other}}
    for name, body in bodies.items():
        velocity = (SPEED * way).tolist() if name == "disk" else [0.0, 0.0]
        if name == rigid:
            body["rigid"] = {"velocity": velocity}
        else:
            body |= {"material": "solid", "velocity": velocity}
    sim = start({
        "format": 1, "dimensions": 2,
        "grid": {"size": [28.0, 28.0], "cell": [1.0, 1.0]},
        "method": {"shape": "gimp", "particles-per-cell": [2, 2]},
        "time": {"end": 400.0, "step": 1.0},
        "materials": {"solid": {"model": "neo-hookean", "young": 0.02, "poisson": 0.0,
                                "density": 1.0}},
        "bodies": bodies, "contact": [{"bodies": ["disk", "other"]}],
    })  # fmt: skip
    while not sim.finished:
        sim.advance()
        line = sim.diagnostics()
        if line["contact.disk+other.normal-impulse"] > 0.0:
            return gap - SPEED * (line["time"] - 1.0)
    raise AssertionError("they never met")


@pytest.mark.parametrize("angle", [0.0, 30.0, 60.0])
@pytest.mark.parametrize("what", ["rigid disk", "rigid hole", "rigid disk on a plane"])
def test_round_bodies_meet_when_they_touch(what, angle):
    """Within a twentieth of a cell, which is less than half of the clearance."""
    way = np.array([cos(radians(angle)), sin(radians(angle))])
    middle, radius, gap = np.array([14.3, 14.1]), 5.0, 0.3
    disk = {"ball": {"centre": middle.tolist(), "radius": radius}}
    other = ring(middle, radius + gap, radius + gap + 4.0)
    if what == "rigid disk on a plane":
        point = (middle + (radius + gap) * way).tolist()
        inside = {"half-space": {"point": point, "normal": (-way).tolist()}}
        whole = {"box": {"min": [1.0, 1.0], "max": [27.0, 27.0]}}
        other = {"intersection": [whole, inside]}
    rigid = "other" if what == "rigid hole" else "disk"
    assert abs(first(disk, other, way, rigid, gap)) < 0.05
