"""Rings of which some are in the current configuration: uniform stress, tubes, momentum."""

import numpy as np
import pytest
from ring_section import SOLID, box, case
from scenes import energy, finish, start
from tiers import wide

pytestmark = pytest.mark.slow(60)

E, NU = SOLID["young"], SOLID["poisson"]


def body(region, configuration, velocity=0.0):
    return {"material": "m", "region": region, "velocity": [0.0, velocity],
            "formulation": configuration}  # fmt: skip


def rings(bodies, size, h=0.125, **parts):
    """A case of rings that all meet."""
    found = case(box([0.0, 0.0], [1.0, 1.0]), h=h, size=size, contact=[{"bodies": "all"}], **parts)
    return found | {"bodies": bodies}


@pytest.mark.parametrize("middle", [1.0625, wide(1.0), wide(1.1)])
def test_a_cylinder_presses_on_a_current_one_evenly(middle):
    """Of a section whose area, all round, is that of whole disks; also on the axis.

    The current one's own surface beside cuts boxes, whose stress is not even without contact.
    """
    radius, top, strain, end = 1.03, 2.13, 2e-3, 3.0
    speed = [0.0, -1.5 * strain * top / (0.4 * end)]
    table = [[0.0, speed], [0.4 * end, speed], [0.401 * end, [0.0, 0.0]]]
    bodies = {
        "a": body(box([0.0, 0.0], [radius, middle]), "updated-lagrangian"),
        "b": body(box([0.0, middle], [radius, top]), "total-lagrangian"),
        "plate": {"rigid": {"velocity": {"table": table}}, "region": box([-2.0, top], [2.0, 2.7])},
    }
    sim = finish(start(rings(bodies, (1.5, 3.0), end=end, boundaries={"y-min": "slip"},
                             damping={"mass": 10.0})))  # fmt: skip
    p, rows = sim.particles, sim.live()
    stress, of = p.sigma[rows, 1] / (-1.5 * strain * E), p.body[rows]
    np.testing.assert_allclose(stress[of == 1], 1.0, atol=0.02)
    inside = (of == 0) & (p.x[rows, 0] < 0.85)
    np.testing.assert_allclose(stress[inside], 1.0, atol=0.06)
    area = sim.diagnostics()["contact.all.area"]
    assert area == pytest.approx(2.0 * np.pi * radius**2, rel=1e-6)


@pytest.mark.parametrize("inner", ["updated-lagrangian", wide("total-lagrangian")])
def test_a_tube_in_a_tube_is_as_one(inner):
    """A pressure outside goes through both: Lame's solution of the whole."""
    a, b, c, h, p = 0.5, 0.8, 1.217, 0.05, 1.0
    outer = "total-lagrangian" if inner == "updated-lagrangian" else "updated-lagrangian"
    rise = {"table": [[0.0, 0.0], [1.0, p]]}
    bodies = {"inner": body(box([a, 0.0], [b, 2 * h]), inner),
              "outer": body(box([b, 0.0], [c, 2 * h]), outer)}  # fmt: skip
    sim = finish(start(rings(bodies, (1.5, 2 * h), h, end=3.0, damping={"mass": 10.0},
                             boundaries={"y-min": "slip", "y-max": "slip"},
                             tractions={"out": {"body": "outer", "face": "x-max",
                                                "pressure": rise}})))  # fmt: skip
    q, rows = sim.particles, sim.live()
    A = -p * c * c / (c * c - a * a)
    r = q.origin[rows][:, 0]
    exact = (1 + NU) / E * ((1 - 2 * NU) * A * r + A * a * a / r)
    np.testing.assert_allclose(q.x[rows][:, 0] - r, exact, atol=0.01 * np.abs(exact).max())
    line = sim.diagnostics()
    assert line["contact.all.area"] == pytest.approx(2 * np.pi * b * 2 * h, rel=0.01)


def test_rings_of_both_kinds_keep_momentum():
    """Cylinders meet on the axis, and rebound; nothing gives energy."""
    bodies = {"a": body(box([0.0, 1.0], [1.0, 2.0]), "total-lagrangian", 0.25),
              "b": body(box([0.0, 2.02], [1.0, 3.02]), "updated-lagrangian", -0.25)}  # fmt: skip
    sim = start(rings(bodies, (1.25, 6.0), end=0.6))
    first, last = sim.diagnostics(), finish(sim).diagnostics()
    assert abs(last["momentum-y"] - first["momentum-y"]) < 1e-13 * first["body.a.mass"]
    assert energy(last) < energy(first)
    before, after = (
        line["body.a.momentum-y"] / line["body.a.mass"]
        - line["body.b.momentum-y"] / line["body.b.mass"]
        for line in (first, last)
    )
    assert 0.6 < -after / before < 1.0
