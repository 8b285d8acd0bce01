"""Rings that meet by their own surfaces: uniform stress, rebounds, tubes, books, themselves."""

import numpy as np
import pytest
from ring_section import SOLID, box, case
from scenes import energy, finish, start
from tiers import wide

pytestmark = pytest.mark.slow(60)

EXACT = {"formulation": "total-lagrangian", "surface": "exact"}
E, NU = SOLID["young"], SOLID["poisson"]


def body(region, velocity=0.0):
    return {"material": "m", "region": region, "velocity": [0.0, velocity]} | EXACT


def rings(bodies, size, h=0.125, **parts):
    """A case of rings that all meet."""
    found = case(box([0.0, 0.0], [1.0, 1.0]), h=h, size=size, contact=[{"bodies": "all"}], **parts)
    return found | {"bodies": bodies}


@pytest.mark.parametrize("middle", [1.07, wide(1.0), wide(1.1)])
def test_cylinders_end_on_end_are_pressed_evenly(middle):
    """Of two lattices that are apart, also on the axis; the areas are those of whole disks."""
    radius, top, strain, end = 1.03, 2.13, 2e-3, 3.0
    speed = [0.0, -1.5 * strain * top / (0.4 * end)]
    table = [[0.0, speed], [0.4 * end, speed], [0.401 * end, [0.0, 0.0]]]
    bodies = {
        "a": body(box([0.0, 0.0], [radius, middle])),
        "b": body(box([0.0, middle], [radius, top])),
        "plate": {"rigid": {"velocity": {"table": table}}, "region": box([-2.0, top], [2.0, 2.7])},
    }
    sim = finish(start(rings(bodies, (1.5, 3.0), end=end, boundaries={"y-min": "slip"},
                             damping={"mass": 10.0})))  # fmt: skip
    p, rows = sim.particles, sim.live()
    stress = p.sigma[rows]
    np.testing.assert_allclose(stress[:, 1], -1.5 * strain * E, rtol=3e-3)
    np.testing.assert_allclose(stress[:, 1], stress[:, 1].mean(), rtol=1e-4)
    np.testing.assert_allclose(stress[:, [0, 2, 3]], 0.0, atol=1e-4 * E * strain)
    # Both bodies look for each other beside their edges.
    area = sim.diagnostics()["contact.all.area"]
    assert area == pytest.approx(2.0 * np.pi * radius**2, rel=0.03)


def rebound(regions, drift, speed=0.25):
    """Relative speed after over before of two bodies on the axis, and what was lost else."""
    bodies = {name: body(region, drift + way * speed)
              for name, region, way in zip("ab", regions, (1.0, -1.0), strict=True)}  # fmt: skip
    sim = start(rings(bodies, (1.25, 6.0), end=0.6))
    first, last = sim.diagnostics(), finish(sim).diagnostics()
    assert abs(last["momentum-y"] - first["momentum-y"]) < 1e-13 * first["body.a.mass"]
    assert energy(last) < energy(first)
    before, after = (
        line["body.a.momentum-y"] / line["body.a.mass"]
        - line["body.b.momentum-y"] / line["body.b.mass"]
        for line in (first, last)
    )
    return -after / before


@pytest.mark.parametrize("kind", ["cylinders", wide("balls")])
def test_rebound_on_the_axis_is_the_same_in_any_frame(kind):
    """And wherever the surfaces lie in the cells."""
    found = []
    for drift, offset in ((0.0, 0.0), (2.0, 0.0), (0.0, 0.041), (2.0, 0.078)):
        y = 1.0 + offset
        if kind == "cylinders":
            regions = [box([0.0, y], [1.0, y + 1.0]), box([0.0, y + 1.02], [1.0, y + 2.02])]
        else:
            regions = [{"ball": {"centre": [0.0, y + 0.5 + k * 1.02], "radius": 0.5}}
                       for k in range(2)]  # fmt: skip
        found.append(rebound(regions, drift))
    assert found[1] == pytest.approx(found[0], abs=1e-6)
    assert max(found) - min(found) < 0.005
    assert 0.6 < min(found) < 1.0


@pytest.mark.parametrize(("inner", "error"), [(0.517, 0.008), wide(0.142, 0.016)])
def test_a_tube_pressed_on_a_core_moves_as_lame_says(inner, error):
    """The core ends on the axis; the books have the force on it, all round."""
    outer, h, p, end = inner + 0.5, 0.125, 1.0, 2.0
    rise = {"table": [[0.0, 0.0], [0.5 * end, p]]}
    bodies = {
        "tube": body(box([inner, 0.0], [outer, 2 * h])),
        "core": {"rigid": {"velocity": [0.0, 0.0]}, "region": box([0.0, -1.0], [inner, 1.0])},
    }
    press = {"out": {"body": "tube", "face": "x-max", "pressure": rise}}
    sim = start(rings(bodies, (1.25, 2 * h), h, end=end, damping={"mass": 10.0}, tractions=press,
                      boundaries={"y-min": "slip", "y-max": "slip"}))  # fmt: skip
    while not sim.finished:
        sim.advance()
        if sim.time < 0.95 * end:
            sim.diagnostics()
    q, rows, line = sim.particles, sim.live(), sim.diagnostics()
    A = -p / (1 + (1 - 2 * NU) * inner**2 / outer**2)
    B = -(1 - 2 * NU) * A * inner**2
    r = q.origin[rows][:, 0]
    exact = (1 + NU) / E * ((1 - 2 * NU) * A * r + B / r)
    np.testing.assert_allclose(q.x[rows][:, 0] - r, exact, atol=error * np.abs(exact).max())
    force, area = 2 * (1 - NU) * A, 2 * np.pi * inner * 2 * h
    assert line["contact.all.area"] == pytest.approx(area, rel=1e-9)
    assert line["rigid.core.force-x"] == pytest.approx(force * area, rel=3 * error)


@pytest.mark.wide
def test_a_tube_in_a_tube_is_as_one():
    """A pressure outside goes through both: Lame's solution of the whole."""
    a, b, c, h, p = 0.517, 0.817, 1.217, 0.05, 1.0
    rise = {"table": [[0.0, 0.0], [1.0, p]]}
    bodies = {"inner": body(box([a, 0.0], [b, 2 * h])), "outer": body(box([b, 0.0], [c, 2 * h]))}
    sim = finish(start(rings(bodies, (1.5, 2 * h), h, end=3.0, damping={"mass": 10.0},
                             boundaries={"y-min": "slip", "y-max": "slip"},
                             tractions={"out": {"body": "outer", "face": "x-max",
                                                "pressure": rise}})))  # fmt: skip
    q, rows = sim.particles, sim.live()
    A = -p * c * c / (c * c - a * a)
    r = q.origin[rows][:, 0]
    exact = (1 + NU) / E * ((1 - 2 * NU) * A * r + A * a * a / r)
    np.testing.assert_allclose(q.x[rows][:, 0] - r, exact, atol=4e-3 * np.abs(exact).max())


def test_rigid_disks_on_the_axis_take_what_others_lose():
    """A ball between two free ones, which meet each other as well."""
    disks = {"low": ([-0.6, 0.3], [0.6, 0.7], 2.0), "high": ([-0.5, 2.3], [0.5, 2.7], -1.0),
             "last": ([-0.7, 2.8], [0.7, 3.2], -3.0)}  # fmt: skip
    bodies = {"ball": body({"ball": {"centre": [0.0, 1.5], "radius": 0.61}})} | {
        name: {"rigid": {"density": 3.0}, "region": box(low, high), "velocity": [0.0, v]}
        for name, (low, high, v) in disks.items()
    }
    sim = start(rings(bodies, (1.25, 4.0), end=0.5))
    first, last = sim.diagnostics(), finish(sim).diagnostics()
    whole = [
        line["momentum-y"] + sum(line[f"rigid.{name}.momentum-y"] for name in disks)
        for line in (first, last)
    ]
    assert abs(whole[1] - whole[0]) < 1e-12 * abs(first["rigid.last.momentum-y"])
    changes = [
        last[f"rigid.{name}.momentum-y"] - first[f"rigid.{name}.momentum-y"] for name in disks
    ]
    assert np.abs(changes).min() > 0.1 * abs(first["rigid.low.momentum-y"])
    kinetic = [
        energy(line) + sum(line[f"rigid.{name}.kinetic-energy"] for name in disks)
        for line in (first, last)
    ]
    assert kinetic[1] < kinetic[0] * (1.0 + 1e-3)


@pytest.mark.wide
def test_flanges_of_one_ring_meet():
    """A plate presses the upper one on the lower one, which stays in the floor's way."""
    web = [box([0.3, 0.0], [0.6, 1.5]), box([0.3, 0.0], [1.4, 0.4]), box([0.3, 1.1], [1.4, 1.5])]
    way = {"table": [[0.0, [0.0, -0.65]], [1.2, [0.0, -0.65]], [1.201, [0.0, 0.0]]]}
    bodies = {
        "ring": body({"union": web}),
        "plate": {"rigid": {"velocity": way}, "region": box([1.0, 1.52], [1.6, 2.0])},
    }
    found = rings(bodies, (2.0, 2.5), 0.1, end=1.2, boundaries={"y-min": "unilateral"},
                  damping={"mass": 5.0})  # fmt: skip
    found["contact"].append({"bodies": ["ring"], "self": True})
    sim = finish(start(found))
    assert sim.diagnostics()["contact.ring.normal-impulse"] > 0.0
    p, rows = sim.particles, sim.live()
    x, begun = p.x[rows], p.origin[rows]
    upper, lower = (begun[:, 1] > 1.1), (begun[:, 1] < 0.4)
    out = begun[:, 0] > 1.3
    assert x[upper & out][:, 1].min() > x[lower & out][:, 1].max()
