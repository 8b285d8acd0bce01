"""Rigid bodies that meet others by their surfaces: books, rebounds, and rest."""

import numpy as np
import pytest
from scenes import box, scene, start

import pgimp
from pgimp.errors import CaseError

pytestmark = pytest.mark.slow(60)

EXACT = {"formulation": "total-lagrangian", "surface": "exact"}
#: Cases have a body of a material; here it is far from all others.
FAR = box([0.1, 8.1], [1.1, 9.1]) | EXACT
FLOOR = {"rigid": {}, "region": {"box": {"min": [1.5, 0.5], "max": [11.5, 3.0]}}}


def history(case):
    """Lines of all steps, with the start."""
    sim = start(case)
    lines = [sim.diagnostics()]
    while not sim.finished:
        sim.advance()
        lines.append(sim.diagnostics())
    return sim, {name: np.array([line[name] for line in lines]) for name in lines[0]}


@pytest.mark.parametrize("body", [EXACT, EXACT | {"surface": "whole-particles"}])
@pytest.mark.parametrize(
    ("velocity", "friction"),
    [([0.0, -1.0], 0.0), ([2.0, 0.0], 0.4),
     ({"translation": [0.5, -0.7], "rotation": {"about": [5.3, 4.5], "rate": -1.0}}, 0.3)],
    ids=["falls", "slides", "spins"],
)  # fmt: skip
def test_friction_and_impacts_are_what_is_lost(body, velocity, friction):
    """Of a heavy box on an elastic base: heat and impact loss, up to second order in the step.

    Velocities are half a step behind positions: with energies of position taken half a step
    earlier, those of all columns add up to what there was, to rounding.
    """
    bodies = {
        "base": box([1.0, 0.0], [9.5, 3.0]) | body,
        "heavy": {"rigid": {"density": 8.0}, "velocity": velocity,
                  "region": {"box": {"min": [4.1, 3.4], "max": [6.5, 5.6]}}},
    }  # fmt: skip
    case = scene(2, bodies, cells=[11, 9], step=0.01, end=4.0,
                 gravity=[0.0, -1.0], boundaries={"y-min": "fixed"},
                 contact=[{"bodies": "all", "friction": friction}])  # fmt: skip
    sim, line = history(case)
    (heavy,) = sim.scene.interaction.rigid_bodies.free.values()
    kinetic, strain = line["rigid.heavy.kinetic-energy"], line["strain-energy"]
    own = line["kinetic-energy"] + strain
    height = heavy.bulk.mass * (line["rigid.heavy.displacement-y"] + 0.4)
    scale = np.max(kinetic + height)
    weight = line["external-work"] - line["rigid.heavy.work"]
    whole = kinetic + own + line["dissipated-energy"] - weight + height
    whole = whole[1:] - 0.5 * np.diff(height)
    assert np.ptp(whole) < 1e-12 * scale
    heat, loss = line["contact.all.friction-heat"], line["contact.all.impact-loss"]
    rest = line["dissipated-energy"] - heat - loss
    rest += 0.5 * np.gradient(strain - weight)
    assert np.abs(rest).max() < 0.005 * scale
    assert loss[-1] > 0.01 * scale


def ball(centre, radius, velocity=(0.0, 0.0)):
    """A free rigid ball."""
    region = {"ball": {"centre": [*map(float, centre)], "radius": radius}}
    return {"rigid": {"density": 1.0}, "velocity": [*velocity], "region": region}


def block(low, high, velocity=(0.0, 0.0)):
    """A free rigid box."""
    region = {"box": {"min": [*map(float, low)], "max": [*map(float, high)]}}
    return {"rigid": {"density": 1.0}, "velocity": [*velocity], "region": region}


def turned(middle, sides, angle):
    """A rectangle that is turned, in degrees, and the directions of its sides."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    axes = np.array([[c, s], [-s, c]])
    planes = [
        {"point": (np.array(middle) + 0.5 * way * side * axis).tolist(),
         "normal": (way * axis).tolist()}
        for axis, side in zip(axes, sides, strict=True) for way in (-1.0, 1.0)
    ]  # fmt: skip
    return {"intersection": [{"half-space": plane} for plane in planes]}, axes


def alone(bodies, contact, **parts):
    """A case of rigid bodies, which none of a material meets."""
    parts = {"cells": [12, 12], "step": 0.02, "end": 3.0} | parts
    return scene(2, {"far": FAR} | bodies, contact=contact, **parts)


def kinetic(line, names):
    """Kinetic energy of rigid bodies at all times."""
    return sum(line[f"rigid.{name}.kinetic-energy"] for name in names)


@pytest.mark.parametrize("on", ["body", "wall"])
@pytest.mark.parametrize("e", [0.0, 0.5, 0.8, 1.0])
def test_heights_of_bounces(e, on):
    """A box falls by 3 onto a floor: it comes back to e^2 of that, up to the way of a step."""
    floor = 3.0 if on == "body" else 0.0
    low = np.array([4.3, floor + 3.0])
    bodies = {"box": block(low, low + 2.0)}
    entry = {"bodies": ["far", "box"]}
    if on == "body":
        bodies["floor"] = FLOOR
        entry = {"bodies": ["box", "floor"], "restitution": e}
    wall = {"boundaries": {"y-min": {"unilateral": {"restitution": e}}}} if on == "wall" else {}
    _, line = history(alone(bodies, [entry], gravity=[0.0, -1.0], end=11.0, **wall))
    y = line["rigid.box.displacement-y"] + 3.0
    tops = [y[k] for k in range(1, len(y) - 1) if y[k - 1] < y[k] >= y[k + 1] and y[k] > 0.03]
    way = 0.02 * np.sqrt(6.0)
    number = np.arange(1, 1 + len(tops))
    off = (1.0 - e**2 + 0.5 * e * (1.0 - e)) * number * way
    assert len(tops) >= (0 if e == 0.0 else 2)
    assert (np.abs(tops - 3.0 * e ** (2.0 * number)) <= off + 1e-4).all()
    assert y.min() > -1e-6
    assert (line["rigid.box.kinetic-energy"] + 4.0 * y).max() < 12.0 * (1.0 + 0.01)
    if e in (0.0, 0.5):  # at rest
        assert abs(y[-1]) < 1e-6 and line["rigid.box.kinetic-energy"][-1] < 1e-12


@pytest.mark.parametrize(("e", "friction"), [(1.0, 0.0), (0.8, 0.1), (0.5, 0.6)])
def test_oblique_impact_of_balls(e, friction):
    """One slips or rolls on the other at the end: both as two disks with one point in common."""
    radius, n = 3.0, np.array([np.cos(0.7), np.sin(0.7)])
    one = np.array([4.1, 4.3])
    # Where they meet, n is along the line of centres.
    bodies = {"a": ball(one, radius, [1.0, 0.0]),
              "b": ball(one + 2.0 * radius * n + [0.41, 0.0], radius)}  # fmt: skip
    _, line = history(
        alone(
            bodies,
            [{"bodies": ["a", "b"], "restitution": e, "friction": friction}],
            cells=[16, 14],
            end=1.0,
        )
    )
    mass, t = np.pi * radius**2, np.array([-n[1], n[0]])
    push = 0.5 * mass * (1.0 + e) * n[0]
    drag = np.clip(mass * t[0] / 6.0, -friction * push, friction * push)
    expected = (push * n + drag * t) / mass
    found = [line[f"rigid.b.velocity-{x}"][-1] for x in "xy"]
    np.testing.assert_allclose(found, expected, atol=0.02)
    spins = [line[f"rigid.{name}.angular-velocity-z"][-1] for name in "ab"]
    np.testing.assert_allclose(spins, -2.0 * drag / (mass * radius), atol=0.015)
    for name in ("momentum-x", "momentum-y", "angular-momentum-z"):
        whole = line[f"rigid.a.{name}"] + line[f"rigid.b.{name}"]
        assert np.ptp(whole) < 1e-11
    energy = kinetic(line, "ab")
    assert energy.max() < energy[0] * (1.0 + 1e-6)
    lost = line["contact.a+b.friction-heat"] + line["contact.a+b.impact-loss"]
    np.testing.assert_allclose(energy + lost, energy[0], rtol=1e-6)


@pytest.mark.parametrize("first", [1, 2])
def test_cradle(first):
    """As many balls leave a row of five as have come, at their speed; the others stay."""
    bodies = {
        f"b{k}": ball([5.4 + 6.0 * k - (k < first), 4.6], 3.0, [float(k < first), 0.0])
        for k in range(5)
    }
    names = [*bodies]
    _, line = history(alone(bodies, [{"bodies": names, "restitution": 1.0}], cells=[38, 10]))
    speeds = [line[f"rigid.{name}.velocity-x"][-1] for name in names]
    np.testing.assert_allclose(speeds, [0.0] * (5 - first) + [1.0] * first, atol=5e-4)
    energy = kinetic(line, names)
    assert abs(energy[-1] / energy[0] - 1.0) < 1e-5


@pytest.mark.parametrize("angle", [30.0, 50.0, 70.0])
def test_a_rebound_with_friction_creates_no_energy(angle):
    """A rod slides as its end hits the floor: Newton's hypothesis alone would give energy."""
    high = 5.0 * np.sin(np.radians(angle)) + np.cos(np.radians(angle))
    rod = block([0.0, 0.0], [1.0, 1.0], [-1.5, -1.0])
    rod["region"], _ = turned([6.0, 3.3 + 0.5 * high], [5.0, 1.0], angle)
    entry = {"bodies": ["rod", "floor"], "restitution": 1.0, "friction": 1.0}
    _, line = history(alone({"rod": rod, "floor": FLOOR}, [entry], end=1.0))
    energy = line["rigid.rod.kinetic-energy"]
    assert energy[-1] != energy[0]
    assert energy.max() < energy[0] * (1.0 + 1e-5)


@pytest.mark.parametrize(
    ("contact", "boundaries", "said"),
    [
        ([{"bodies": ["far", "box"], "restitution": 0.5}], {}, "'far' is of a material"),
        ([{"bodies": "all", "restitution": 0.5}], {}, "'far' is of a material"),
        ([{"bodies": ["box", "floor"], "law": "tie", "restitution": 0.5}], {}, "no restitution"),
        ([{"bodies": ["box", "floor"], "restitution": 1.5}], {}, "restitution"),
        ([], {"y-min": {"unilateral": {"restitution": 0.5}}}, "boundaries.y-min"),
    ],
)
def test_where_there_is_no_restitution(contact, boundaries, said):
    """Bodies of a material rebound by their waves; a wall's is of rigid bodies only."""
    bodies = {"box": block([3.0, 4.0], [5.0, 6.0]), "floor": FLOOR}
    if boundaries:
        del bodies["box"]
    with pytest.raises(CaseError, match=said):
        pgimp.load(alone(bodies, contact, boundaries=boundaries))


@pytest.mark.parametrize("friction", [0.1, 0.4, 0.5])
def test_a_box_on_an_incline(friction):
    """It slides with g (sin - mu cos), or stays. A corner of the lattice lies in the plane."""
    corner = np.array([7.0, 6.0])
    _, (along, normal) = turned(corner, [1.0, 1.0], -25.0)
    bodies = {
        "box": block([0.0, 0.0], [1.0, 1.0])
        | {"region": turned(corner - 1.8 * along + normal, [3.0, 2.0], -25.0)[0]},
        "floor": {"rigid": {}, "region": turned(corner - normal, [10.0, 2.0], -25.0)[0]},
    }
    entry = {"bodies": ["box", "floor"], "friction": friction}
    case = alone(bodies, [entry], gravity=[0.0, -1.0], end=2.0, cells=[14, 12])
    case["bodies"]["far"] = box([0.1, 0.1], [1.1, 1.1]) | EXACT
    _, line = history(case)
    way = np.array([line[f"rigid.box.displacement-{x}"][-1] for x in "xy"])
    sine, cosine = np.sin(np.radians(25.0)), np.cos(np.radians(25.0))
    exact = 2.0 * max(0.0, sine - friction * cosine)
    assert abs(way @ along - exact) < 0.015 * exact + 1e-8
    assert abs(way @ normal) < 1e-6 and abs(line["rigid.box.angle-z"][-1]) < 1e-6


@pytest.mark.parametrize("wide", [2.0, 4.0])
def test_a_block_rocks_about_its_edges(wide):
    """Housner's block, three times as high as wide: a quarter of a period, and the next angle.

    Its edges are known to 0.06 cells, half a facet: of 2 cells they tell the period by 0.03, and
    the next angle by 0.05. About points half a cell inside, it was 0.17 and more.
    """
    b, h, theta = 0.5 * wide, 1.5 * wide, np.radians(4.0)
    R, alpha = np.hypot(b, h), np.arctan2(b, h)
    pivot = np.array([4.0 + 0.5 * wide, 3.0])
    _, axes = turned(pivot, [1.0, 1.0], -4.0)
    middle = pivot + np.array([-b, h]) @ axes
    region, _ = turned(middle, [wide, 2.0 * h], -4.0)
    bodies = {"block": block([0.0, 0.0], [1.0, 1.0]) | {"region": region}, "floor": FLOOR}
    quarter = np.arccosh(1.0 / (1.0 - theta / alpha)) / np.sqrt(0.75 / R)
    entry = {"bodies": ["block", "floor"], "friction": 1.0}
    case = alone(bodies, [entry], cells=[14, 18], gravity=[0.0, -1.0], step=0.005,
                 end=np.ceil(600.0 * quarter) * 0.005)  # fmt: skip
    _, line = history(case)
    angle = line["rigid.block.angle-z"] - theta
    left = 1.0 - 1.5 * np.sin(alpha) ** 2
    next_one = alpha * (1.0 - np.sqrt(1.0 - left**2 * (1.0 - (1.0 - theta / alpha) ** 2)))
    assert abs(line["time"][np.argmax(angle > 0.0)] / quarter - 1.0) < 0.06 / wide
    assert abs(angle.max() / next_one - 1.0) < 0.1 / wide


@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_a_stack_stays(friction):
    """Five boxes, one on another, at rest for two free falls from their height: to rounding."""
    bodies = {
        f"b{k}": block([4.3 + 0.17 * (k % 3), 3.0 + 2.0 * k], [8.3 + 0.17 * (k % 3), 5.0 + 2.0 * k])
        for k in range(5)
    }
    names = [*bodies]
    entry = {"bodies": [*names, "floor"], "friction": friction}
    _, line = history(
        alone(bodies | {"floor": FLOOR}, [entry], gravity=[0.0, -1.0], cells=[14, 16], end=9.0)
    )
    for name in names:
        for what in ("displacement-x", "displacement-y", "angle-z"):
            assert np.abs(line[f"rigid.{name}.{what}"]).max() < 1e-6
    assert kinetic(line, names).max() < 1e-10
