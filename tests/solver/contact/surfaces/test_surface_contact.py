"""Bodies that meet by their own surfaces: momenta, any frame, mirrors, uniform stress, floors."""

import numpy as np
import pytest
from scenes import SOFT, energy, finish, scene, start
from tiers import wide

from pgimp.kernels.data.motion import DISPLACEMENT

pytestmark = pytest.mark.slow(60)

HARD = SOFT | {"young": 1000.0}
#: Speed of waves.
C = np.sqrt(1000.0 * 0.7 / (1.3 * 0.4))
R = 4.0


def exact(region, **more):
    """A body in the initial configuration, exact to its surface."""
    body = {
        "material": "soft",
        "region": region,
        "formulation": "total-lagrangian",
        "surface": "exact",
    }
    return body | more


def box(low, high):
    return {"box": {"min": [*map(float, low)], "max": [*map(float, high)]}}


def ball(centre, radius=R):
    return {"ball": {"centre": [*map(float, centre)], "radius": radius}}


def turned(middle, sides, angle):
    """A rectangle, or a box, that is turned about z, in degrees; the directions of its sides."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    axes = np.eye(len(sides))
    axes[:2, :2] = [[c, s], [-s, c]]
    planes = [
        {"point": (middle + 0.5 * way * side * axis).tolist(), "normal": (way * axis).tolist()}
        for axis, side in zip(axes, sides, strict=True) for way in (-1.0, 1.0)
    ]  # fmt: skip
    return {"intersection": [{"half-space": plane} for plane in planes]}, axes


def case_of(bodies, cells, end, pairs=(("a", "b"),), friction=0.0, **parts):
    contact = [{"bodies": [*two], "friction": friction} for two in pairs]
    parts = {"step": {"courant": 0.3}, "materials": {"soft": HARD}} | parts
    return scene(len(cells), bodies, cells=cells, end=end, contact=contact, **parts)


def disks(V, offset, v=0.01, aside=0.0, friction=0.0):
    """Disks that meet at 2 v along x while all moves at V, in speeds of waves."""
    one = np.array([R + 3.0, R + 3.0]) + offset
    aside = np.array([2.0 * R + 0.3, aside])
    bodies = {
        "a": exact(ball(one), velocity=[C * (V[0] + v), C * V[1]]),
        "b": exact(ball(one + aside), velocity=[C * (V[0] - v), C * V[1]]),
    }
    end = (0.15 / v + 12.0 * R) / C
    size = [4.0 * R + 9.0 + abs(V[0]) * C * end, 2.0 * R + 8.0 + aside[1] + abs(V[1]) * C * end]
    return case_of(bodies, [int(np.ceil(n)) for n in size], end, friction=friction)


def met(case):
    """First line of the history, and the last one."""
    sim = start(case)
    return sim.diagnostics(), finish(sim).diagnostics()


def deepest(sim):
    """Greatest depth of a facet in another body now, in cells of side 1."""
    gaps = sim.rank.contact.proximity.candidates["gap"]
    return -gaps[np.isfinite(gaps)].min(initial=0.0)


def watched(sim):
    """Run to the end: greatest depth, greatest energy at a step's end, and the last line."""
    before, deep, most = sim.diagnostics(), 0.0, 0.0
    while not sim.finished:
        sim.advance()
        line = sim.diagnostics()
        deep = max(deep, deepest(sim))  # speeds are half a step old
        most = max(most, energy(before) + 0.5 * (line["kinetic-energy"] - before["kinetic-energy"]))
        before = line
    return deep, most, before


def rebound(first, last):
    """Relative speed after over before."""
    a, b = (
        line["body.b.momentum-x"] - line["body.a.momentum-x"] for line in (first, last)
    )  # of equal masses
    return -b / a


def test_rebound_is_the_same_in_any_frame():
    """The grid in space is not felt: it took a quarter of a rebound."""
    found = [rebound(*met(disks(V, (0.13, 0.21)))) for V in ((0.0, 0.0), (0.2, 0.05))]
    assert found[0] == pytest.approx(found[1], abs=1e-6)
    assert 0.95 < found[0] < 0.99


@pytest.mark.parametrize("offset", [(0.0, 0.0), wide((0.5, 0.5)), wide((0.37, 0.78))])
def test_momenta_are_kept_and_energy_is_not_made(offset):
    """Askew and with friction: momentum and angular momentum to rounding."""
    first, last = met(disks((0.0, 0.0), offset, aside=1.7, friction=0.4))
    scale = first["body.a.momentum-x"]
    for axis in "xy":
        assert abs(last[f"momentum-{axis}"] - first[f"momentum-{axis}"]) < 1e-12 * scale
    turn = last["angular-momentum-z"] - first["angular-momentum-z"]
    assert abs(turn) < 1e-12 * scale * R
    assert last["contact.a+b.tangential-impulse"] > 0.0
    assert 0.9 < energy(last) / energy(first) < 1.0


def test_mirror_images_meet_alike():
    """Bodies that are each other's images about a plane of the grid nearly stay so."""
    middle = 12.0
    bodies = {
        name: exact(ball([middle + side * (R + 0.1), 8.31]), velocity=[-side * 0.02 * C, 0.0])
        for name, side in (("a", -1.0), ("b", 1.0))
    }
    sim = finish(start(case_of(bodies, [24, 17], 0.6, friction=0.3)))
    p, rows = sim.particles, sim.live()
    x, own = p.x[rows], p.body[rows]
    assert abs(x[:, 1] - p.origin[rows][:, 1]).max() > 1e-3  # they have met

    def ordered(body, side):
        there, begin = x[own == body].copy(), p.origin[rows][own == body].copy()
        for values in (there, begin):
            values[:, 0] = side * (values[:, 0] - middle)
        return there[np.lexsort(np.round(begin, 9).T)]

    # What is the first body there is the second one here: their parts differ, not the force.
    np.testing.assert_allclose(ordered(0, -1.0), ordered(1, 1.0), rtol=0.0, atol=2e-3)


def test_top_and_bottom_of_what_is_symmetric_move_alike():
    """A disk that hits another along a line of the grid: images about this line, but for sweeps."""
    case = disks((0.0, 0.0), (0.3, 0.0))
    sim = finish(start(case))
    p, rows = sim.particles, sim.live()
    x, begin, line = p.x[rows], p.origin[rows], R + 3.0
    order = np.lexsort(np.round(begin, 9).T)
    image = begin * [1.0, -1.0] + [0.0, 2.0 * line]
    other = np.lexsort(np.round(image, 9).T)
    np.testing.assert_allclose(
        x[order], x[other] * [1.0, -1.0] + [0.0, 2.0 * line], rtol=0.0, atol=1e-6
    )


@pytest.mark.parametrize("angle", [17.0, 45.0, wide(0.0), wide(30.0)])
def test_plates_press_a_turned_block_evenly(angle):
    """Stress is uniform to a hundredth, although the surface cuts cells anyhow."""
    middle, strain, end = np.array([10.11, 10.07]), 2e-3, 5.0
    region, axes = turned(middle, [4.0, 3.0], angle)
    bodies = {"a": exact(region)}
    for name, way in (("low", -1.0), ("high", 1.0)):
        speed = (-1.5 * way * strain / (0.4 * end) * axes[1]).tolist()
        table = [[0.0, speed], [0.4 * end, speed], [0.401 * end, [0.0, 0.0]]]
        plate = turned(middle + 2.5 * way * axes[1], [7.0, 2.0], angle)[0]
        bodies[name] = {"rigid": {"velocity": {"table": table}}, "region": plate}
    sim = finish(start(case_of(bodies, [20, 20], end, (("a", "low"), ("a", "high")),
                               damping={"mass": 6.0})))  # fmt: skip
    p, rows = sim.particles, sim.live()
    xx, yy, xy = (p.sigma[rows][:, n] for n in (0, 1, 3))
    n = axes[1]
    along = n[0] ** 2 * xx + n[1] ** 2 * yy + 2.0 * n[0] * n[1] * xy
    mean = p.V0[rows] @ along / p.V0[rows].sum()
    assert mean == pytest.approx(-strain * 1000.0 / 0.91, rel=0.01)
    np.testing.assert_allclose(along, mean, rtol=0.01)


@pytest.mark.parametrize("D", [2, wide(3)])
@pytest.mark.parametrize("angle", [17.0, 45.0, wide(0.0)])
def test_blocks_whose_lattices_differ_press_each_other_evenly(D, angle):
    """All particles have one stress: weights are means over facets that either grid cuts."""
    sides, strain, end = np.array([4.0, 3.0, 4.0][:D]), 2e-3, 7.0
    middle = np.full(D, 10.0) + np.array([0.11, 0.07, -6.69][:D])
    axes = turned(middle, sides, angle)[1]
    there = middle + 3.0 * axes[1]
    # The second one's place in its lattice, from there. At 45 degrees, where its lattice does not
    # fit, normals of its face differ by rounding along x and y.
    away = np.array([*((9.97, 0.02) if angle == 45.0 else (9.2, 0.6)), 0.45][:D])
    bodies = {}
    for name, at, way in (("a", middle, -1.0), ("b", there, 1.0)):
        bodies[name] = exact(turned(at + (away if way > 0.0 else 0.0), sides, angle)[0])
        speed = (-3.0 * way * strain / (0.3 * end) * axes[1]).tolist()
        table = [[0.0, speed], [0.3 * end, speed], [0.301 * end, [0.0] * D]]
        plate = turned(at + 2.5 * way * axes[1], np.array([7.0, 2.0, 7.0][:D]), angle)[0]
        bodies[f"plate-{name}"] = {"rigid": {"velocity": {"table": table}}, "region": plate}
    pairs = [("a", "b"), ("plate-a", "a"), ("plate-b", "b")]
    sim = start(case_of(bodies, [28, 20, 7][:D], end, pairs, damping={"mass": 6.0}))
    grid, rows, p = sim.rank.grid, sim.live(), sim.particles
    first = int(middle[0] + 4.5) + sim.scene.domain.frame.ghost - grid.window.lower[0]
    moved = grid.by_vertex(grid.kept.values)[first:]
    beyond = rows[p.body[rows] == 1]
    for d in range(D):
        moved[..., DISPLACEMENT + d] -= away[d]
        p.x[beyond, d] -= away[d]
    p, rows = finish(sim).particles, sim.live()
    sigma, tensor = p.sigma[rows], np.zeros((len(rows), 3, 3))
    for n, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))[: sigma.shape[1]]):
        tensor[:, i, j] = tensor[:, j, i] = sigma[:, n]
    along = np.einsum("pij,i,j->p", tensor[:, :D, :D], axes[1], axes[1])
    modulus = 1000.0 / (0.91 if D == 2 else 1.0)
    assert along.mean() == pytest.approx(-strain * modulus, rel=0.01)
    np.testing.assert_allclose(along, along.mean(), rtol=1e-4)


@pytest.mark.parametrize("floor", ["wall", "rigid"])
def test_a_pile_rests_on_a_floor(floor):
    """Blocks at rest bear their weights: no depth, no drift, no energy that grows."""
    low = 0.0 if floor == "wall" else 2.0
    bodies, g = {}, 1.0
    for k in range(3):
        y = low + 3.0 * k
        bodies[f"b{k}"] = exact(box([3.0 + 0.17 * k, y], [7.0 + 0.17 * k, y + 3.0]))
    pairs, more = [("b0", "b1"), ("b1", "b2")], {}
    if floor == "wall":
        more["boundaries"] = {"y-min": {"unilateral": {"friction": 0.3}}}
    else:
        bodies["floor"] = {"rigid": {}, "region": box([0.5, 0.5], [10.0, 2.0])}
        pairs.append(("b0", "floor"))
    weight = {"table": [[0.0, [0.0, 0.0]], [5.0, [0.0, -g]]]}
    sim = start(case_of(bodies, [11, 14], 14.0, pairs, 0.3, gravity=weight,
                        damping={"mass": 3.0}, **more))  # fmt: skip
    while sim.time < 10.0:
        sim.advance()
        assert deepest(sim) < 1e-3  # also of facets in planes of the grid, between two cells
    half, last = sim.diagnostics(), finish(sim).diagnostics()
    assert 0 < sim.rank.contact.sweeps <= 8
    for k in range(3):
        for axis in "xy":
            name = f"body.b{k}.centre-{axis}"
            assert abs(last[name] - half[name]) < 1e-4
    assert last["kinetic-energy"] < 1e-6 * last["strain-energy"]
    # The lowest block's bottom is where the floor is, within a thousandth of a cell.
    p, rows = sim.particles, sim.live()
    bottom = p.body[rows] == 0
    deep = p.x[rows][bottom][:, 1].min() - low
    assert deep == pytest.approx(0.25, abs=0.05 * 0.25)


@pytest.mark.wide
def test_a_block_at_rest_gains_no_energy():
    """With friction and nothing that damps, over 15,000 steps."""
    g = 1.0
    bodies = {
        "a": exact(box([3.0, 2.0], [7.0, 5.0])),
        "b": {"rigid": {}, "region": box([0.5, 0.5], [10.0, 2.0])},
    }
    weight = {"table": [[0.0, [0.0, 0.0]], [2.0, [0.0, -g]]]}
    sim = start(case_of(bodies, [11, 8], 1e9, friction=0.3, gravity=weight))
    found = []
    while sim.step < 15000:
        sim.advance()
        if sim.step > 500 and sim.step % 10 == 0:
            line = sim.diagnostics()
            found.append(energy(line) + 12.0 * g * line["body.a.centre-y"])
    n = len(found) // 4
    change = np.mean(found[-n:]) - np.mean(found[:n])
    assert abs(change) < 2e-5 * line["strain-energy"]


def test_long_steps_lose_no_more_of_a_hard_blow():
    """Pressure that moves within patches is a spring: it was too stiff for steps of 0.4 and more.

    What a blow loses are waves of the grid's own length, whatever the step is: to the part of a
    step by which energies that are added are apart.
    """
    bodies = {
        "a": exact(box([3.0, 2.0], [13.0, 8.0]), velocity=[0.0, -0.15 * C]),
        "b": {"rigid": {}, "region": box([0.5, 0.5], [15.5, 2.0])},
    }
    kept = []
    for step in (0.2, 0.6):
        case = case_of(bodies, [16, 12], 16.0 / C, step={"courant": step})
        first, last = met(case)
        assert last["body.a.momentum-y"] > 0.0
        kept.append(energy(last) / energy(first))
    assert 0.9 < kept[0] < 1.0 and abs(kept[1] - kept[0]) < 0.03


def test_a_blow_of_a_disk_loses_the_same_in_any_steps_and_all_of_it_is_booked():
    """Contact wanders from facet to facet: overlaps at a step's end were forgotten, with their way.

    What is lost then is what the surface's vertices have as they stop, whatever the step is.
    """
    bodies = {
        "a": exact(ball([8.0, 6.03]), velocity=[0.0, -0.05 * C]),
        "b": {"rigid": {}, "region": box([0.5, 0.5], [15.5, 2.0])},
    }
    kept = []
    for step in (0.1, 0.3, 0.6):
        first, last = met(case_of(bodies, [16, 12], 48.0 / C, step={"courant": step}))
        kept.append(energy(last) / energy(first))
        booked = last["contact.a+b.impact-loss"] / energy(first)
        assert booked == pytest.approx(1.0 - kept[-1], abs=0.015)
    assert 0.985 < min(kept) and max(kept) < 1.0 and max(kept) - min(kept) < 0.01


def test_a_block_that_leaves_a_table_is_not_held_by_its_side():
    """It slides over the edge and tips; energy falls by what friction takes, and not otherwise."""
    table = box([0.0, 3.0], [10.4, 6.0])
    bodies = {
        "a": exact(box([5.13, 6.0], [11.13, 9.0]), velocity=[0.125 * C, 0.0]),
        "b": {"rigid": {}, "region": table},
    }
    g = 2.0
    sim = start(case_of(bodies, [28, 14], 2.0, gravity=[0.0, -g]))
    first = sim.diagnostics()
    last = finish(sim).diagnostics()
    assert last["body.a.centre-y"] < 7.0
    # Without friction the table pushes up, at the end at its corner, but never along.
    gained = last["body.a.momentum-x"] / first["body.a.momentum-x"]
    assert 0.9 < gained < 1.2
    fallen = 18.0 * g * (first["body.a.centre-y"] - last["body.a.centre-y"])
    assert energy(last) < energy(first) + fallen


def test_bodies_that_meet_again_and_again():
    """A disk bounces on a floor: it comes back, and never higher than before."""
    fall, g = 2.0, 2.0
    bodies = {
        "a": exact(ball([R + 3.13, 3.0 + R + fall])),
        "b": {"rigid": {}, "region": box([0.5, 0.5], [2.0 * R + 6.0, 3.0])},
    }
    sim = start(case_of(bodies, [int(2 * R) + 7, int(2 * R) + 8], 7.0, gravity=[0.0, -g]))
    heights = []
    while not sim.finished:
        sim.advance()
        heights.append(sim.diagnostics()["body.a.centre-y"] - 3.0 - R)
    y = np.array(heights)
    tops = [v for a, v, b in zip(y, y[1:], y[2:], strict=False) if a < v >= b and v > 0.2]
    assert len(tops) >= 2
    assert y.min() > -0.2 * R
    assert all(low < high < 1.001 * fall for high, low in zip([fall, *tops], tops, strict=False))


@pytest.mark.parametrize("order", [("wedge", "block"), ("block", "wedge")])
@pytest.mark.parametrize("soft", [True, wide(False)])
def test_a_sharp_wedge_is_stopped_whichever_body_comes_first(order, soft):
    """Its sides are nearly along the normal of what it meets, which does not see them.

    It stays before the facet that it is over in each step, and energy is never more than it was.
    """
    half, tip = np.radians(15.0), np.array([8.13, 8.2])
    planes = [
        {"point": tip.tolist(), "normal": [way * np.cos(half), -np.sin(half)]}
        for way in (-1.0, 1.0)
    ]
    planes.append({"point": (tip + np.array([0.0, 6.0])).tolist(), "normal": [0.0, 1.0]})
    region = {"intersection": [{"half-space": plane} for plane in planes]}
    v, end = 0.02 * C, 2.0
    entries = {
        "wedge": exact(region, velocity=[0.0, -v])
        if soft
        else {"rigid": {"velocity": [0.0, -v]}, "region": region},
        "block": exact(box([3.37, 2.21], [13.37, 8.11])),
    }
    bodies = {name: entries[name] for name in order}
    parts = {"boundaries": {"y-min": "fixed"}}
    sim = start(case_of(bodies, [17, 16], end, [order], **parts))
    first = sim.diagnostics()
    deep, most, last = watched(sim)
    taken = last["body.block.momentum-y"] if "body.block.momentum-y" in last else 0.0
    assert abs(taken) + last["body.block.strain-energy"] > 0.0
    if soft:
        assert last["body.wedge.momentum-y"] > 0.5 * first["body.wedge.momentum-y"]
        assert most < 1.0005 * energy(first)
        assert deep < (0.003 if order[0] == "wedge" else 0.02)
