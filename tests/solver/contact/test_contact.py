"""Contact of bodies: what must hold exactly, and what exact solutions say."""

import numpy as np
import pytest
from scenes import box, energy, field, finish, scene, start, stir, tracked
from tiers import wide

from pgimp.physics.contact.pairs import ContactEntry, Pairs
from pgimp.solver.vertex_sums import VertexSums

pytestmark = pytest.mark.slow(30)


def blocks(first=(0.0, 0.0), second=(0.0, 0.0), gap=0.0, **parts):
    """Two blocks that touch along x, or have a gap, with their velocities."""
    bodies = {
        "left": box([2.0, 2.0], [5.0, 5.0], list(first)),
        "right": box([5.0 + gap, 2.0], [8.0 + gap, 5.0], list(second)),
    }
    return scene(2, bodies, cells=[14, 8], **parts)


def test_tied_bodies_are_one_body():
    """The same particles as one body, to rounding, for a thousand steps through walls and cells."""
    parts = {
        "cells": [12, 8],
        "end": 8.0,
        "step": 0.008,
        "gravity": [0.0, -1.0],
        "boundaries": {"y-min": "unilateral", "x-max": "slip"},
    }
    whole = start(scene(2, box([2.0, 1.0], [6.0, 4.0]), **parts))
    halves = {"left": box([2.0, 1.0], [4.0, 4.0]), "right": box([4.0, 1.0], [6.0, 4.0])}
    two = start(scene(2, halves, contact=[{"bodies": "all", "law": "tie"}], **parts))
    for sim in (whole, two):
        stir(sim, 0.5)
        finish(sim)
    assert whole.step == 1000
    assert max(two.rank.contact.fields) == 1  # there are two velocity fields
    mine, others = (
        np.concatenate([field(sim, name) for name in ("x", "v", "F", "sigma")], axis=1)
        for sim in (whole, two)
    )
    # Ids follow the bodies: the particles are found again by where they were.
    places = (field(start(sim.case), "x") for sim in (whole, two))
    first, second = (np.lexsort(np.round(x, 6).T) for x in places)
    assert np.allclose(mine[first], others[second], rtol=0.0, atol=1e-11)
    assert np.abs(mine).max() > 5.0


@pytest.mark.parametrize("law", ["friction", "tied", "ignore"])
def test_no_pull_between_blocks_that_part(law):
    """Blocks that touch and move apart: the one at rest takes nothing, unless they are tied."""
    case = blocks(second=(1.0, 0.2), end=0.5, contact=[{"bodies": "all", "law": law}])
    line = finish(start(case)).diagnostics()
    taken = np.array([line["body.left.momentum-x"], line["body.left.momentum-y"]])
    if law == "tied":
        assert taken[0] > 0.1 * line["momentum-x"]
    else:
        assert np.abs(taken).max() <= 1e-12 * line["momentum-x"]


def test_bodies_that_ignore_each_other_pass_through():
    contact = [{"bodies": "all", "law": "ignore"}]
    case = blocks((2.0, 0.0), (-2.0, 0.0), 1.0, end=1.5, contact=contact)
    line = finish(start(case)).diagnostics()
    assert line["body.left.centre-x"] == pytest.approx(3.5 + 3.0, abs=1e-9)
    assert line["strain-energy"] < 1e-20


def test_without_friction_blocks_slide():
    """Blocks pressed together slide past each other as if alone; with friction they take along."""
    pressed = {"end": 1.0, "step": 0.02}
    slid = {}
    for friction in (0.0, 5.0):
        case = blocks((0.5, 1.0), (-0.5, -1.0), contact=[{"bodies": "all", "friction": friction}],
                      **pressed)  # fmt: skip
        columns = ("friction-heat", "normal-impulse", "tangential-impulse")
        momentum, heat, push, slip = tracked(
            start(case), "body.left.momentum-y", *(f"contact.all.{name}" for name in columns)
        )
        slid[friction] = momentum[-1] / momentum[0]
        assert push[-1] > 1.0
        assert (np.diff(heat) >= -1e-12).all()
        if friction == 0.0:
            assert heat[-1] == slip[-1] == 0.0
        else:
            assert slip[-1] > 0.5
    # On three cells the normals at the edges are inclined.
    assert slid[0.0] == pytest.approx(1.0, abs=0.06)
    assert slid[5.0] < 0.7


@pytest.mark.parametrize("friction", [0.1, 0.4])
def test_friction_is_coulombs(friction):
    """A block drawn over another that is held: all of the friction is mu times what presses."""
    lower = box([1.0, 0.0], [13.0, 2.0])
    upper = box([2.0, 2.0], [5.0, 4.0], [3.0, 0.0])
    case = scene(
        2, {"lower": lower, "upper": upper}, cells=[14, 8], end=2.0, gravity=[0.0, -1.0],
        boundaries={"y-min": "fixed"},
        contact=[{"bodies": ["upper", "lower"], "friction": friction}],
    )  # fmt: skip
    case["materials"]["soft"] = {**case["materials"]["soft"], "young": 1000.0}
    line = finish(start(case)).diagnostics()
    push = line["contact.upper+lower.normal-impulse"]
    slip = line["contact.upper+lower.tangential-impulse"]
    assert slip == pytest.approx(friction * push, rel=0.02)
    assert push == pytest.approx(6.0 * 2.0, rel=0.05)  # its weight over time, but for a bounce
    momentum = 6.0 * 3.0 - line["body.upper.momentum-x"]
    assert momentum == pytest.approx(friction * push, rel=0.03)
    way = line["body.upper.centre-x"] - 3.5
    heat = line["contact.upper+lower.friction-heat"]
    assert heat == pytest.approx(friction * 6.0 * way, rel=0.06)


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_momentum_is_kept_by_collisions(dimension):
    """Free bodies that meet with friction: momentum to rounding, energy never grows."""
    D = dimension
    bodies = {
        "flies": box([1.5] * D, [3.5] * D, [2.0, 0.7, -0.3][:D]),
        "meets": box([4.2] + [2.3] * (D - 1), [6.2] + [4.3] * (D - 1), [-1.0, 0.1, 0.4][:D]),
    }
    contact = [{"bodies": "all", "friction": 0.5}]
    case = scene(D, bodies, cells=[9, 7, 7][:D], end=1.0, contact=contact)
    names = [f"momentum-{axis}" for axis in "xyz"[:D]]
    *momentum, push = tracked(start(case), *names, "contact.all.normal-impulse")
    assert push[-1] > 1.0
    scale = np.abs(momentum).max()
    assert np.ptp(momentum, axis=1).max() <= 1e-13 * scale
    sim = start(case)
    before = energy(sim.diagnostics())
    assert energy(finish(sim).diagnostics()) <= before


def test_force_of_a_pair_is_on_the_first_body():
    """A block at rest on another: the weight, and against it if they are named the other way."""
    bodies = {"lower": box([2.0, 0.0], [6.0, 2.0]), "upper": box([2.0, 2.0], [6.0, 4.0])}
    for names, sign in ((["lower", "upper"], -1.0), (["upper", "lower"], 1.0)):
        case = scene(2, bodies, end=20.0, step=0.02, gravity=[0.0, -0.2],
                     boundaries={"y-min": "fixed"}, contact=[{"bodies": names}])  # fmt: skip
        case["method"]["pic-damping"] = 3.0
        sim = start(case)
        sim.diagnostics()
        force = finish(sim).diagnostics()[f"contact.{'+'.join(names)}-y"]
        assert force == pytest.approx(sign * 0.2 * 8.0, rel=0.02)


@pytest.mark.parametrize("angle", [0.0, 30.0, 45.0])
@pytest.mark.parametrize("shift", [0.1, 0.63])
def test_flat_faces_meet_when_they_touch(angle, shift):
    """Half-planes turned and placed anyhow: the gap at the first impulse, in cells.

    Beside the closing of a step, 0.01 cells, bodies are strained nowhere before.
    """
    turn = np.radians(angle)
    way, across = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    middle = np.array([8.0, 8.0]) + shift * way

    def slab(side, gap):
        planes = [(middle + side * (0.5 * gap) * way, -side * way)]
        planes += [(middle + side * 4.0 * way, side * way)]
        planes += [(middle + s * 3.0 * across, s * across) for s in (-1.0, 1.0)]
        parts = [
            {"half-space": {"point": point.tolist(), "normal": normal.tolist()}}
            for point, normal in planes
        ]
        return {"material": "soft", "region": {"intersection": parts}}

    bodies = {"a": slab(-1.0, 1.0) | {"velocity": way.tolist()}, "b": slab(1.0, 1.0)}
    case = scene(2, bodies, cells=[16, 16], end=2.0, step=0.01, contact=[{"bodies": ["a", "b"]}])
    sim, left = start(case), 1.0
    while sim.diagnostics()["contact.a+b.normal-impulse"] == 0.0:
        left = 1.0 - sim.time
        sim.advance()
    assert abs(left) < 0.05


def test_laws_of_pairs():
    """Entries for some bodies go before that for all; who is in none is tied to the others."""
    entries = [
        ContactEntry(bodies="all", friction=0.2),
        ContactEntry(bodies=("c", "a"), law="ignore"),
        ContactEntry(bodies=("d", "b", "a"), friction=0.4),
    ]
    names = ("a", "b", "c", "d")
    entry = Pairs.of(entries, names).entry
    assert entry[0].tolist()[1:] == [-3, 0, -3]
    assert entry[1].tolist()[2:] == [1, -3]
    assert entry[2, 3] == 1
    assert (np.abs(Pairs.of(entries[2:], names).entry[:2, 2]) == 2).all()


@pytest.mark.parametrize(
    "shape", ["mpm", "finite-gimp", wide("fuzzy-constant"), wide("fuzzy-nearest")]
)
def test_other_shapes_meet_too(shape):
    """Bars collide and part; the exchange of momentum of equal bars is all of it."""
    bodies = {"a": box([1.3], [7.3], [0.2]), "b": box([8.3], [14.3], [0.0])}
    parts = {"end": 8.0, "step": 0.02, "contact": [{"bodies": "all"}]}
    case = scene(1, bodies, cells=[24], shape=shape, **parts)
    line = finish(start(case)).diagnostics()
    assert line["body.b.momentum-x"] == pytest.approx(line["momentum-x"], rel=0.2)
    assert line["body.b.centre-x"] - line["body.a.centre-x"] > 6.1


def test_walls_and_constraints_hold_bodies_that_meet():
    """Three blocks pushed into a corner by one that is moved: no particle is lost or overlaps."""
    bodies = {
        "lies": box([0.0, 0.0], [2.0, 2.0]),
        "leans": box([2.0, 0.0], [4.0, 2.0]),
        "pusher": box([4.5, 0.0], [5.5, 2.0]),
    }
    push = {"body": "pusher", "region": {"box": {"min": [4.5, 0.0], "max": [5.5, 2.0]}}}
    case = scene(
        2, bodies, cells=[8, 5], end=1.0, step=0.01,
        boundaries={"x-min": "unilateral", "y-min": "unilateral"},
        constraints={"push": push | {"velocity": [-1.0, 0.0]}},
        contact=[{"bodies": "all", "friction": 0.3}],
    )  # fmt: skip
    sim = start(case)
    sim.diagnostics()
    finish(sim)
    x, body = field(sim, "x"), field(sim, "body")
    ends = [(x[body == b, 0].min(), x[body == b, 0].max()) for b in range(3)]
    assert ends[2] == pytest.approx((3.75, 4.25))
    # Particles stand for half a cell each way at most; none is deeper than that in another body.
    assert ends[0][1] < ends[1][0] < ends[1][1] < ends[2][0]
    line = sim.diagnostics()
    assert line["reaction.x-min-x"] > 1.0


def test_sums_of_earlier_steps_do_not_matter(monkeypatch):
    """Two bodies at mirrors, which fold sums beyond them: those must be of this step, too."""
    bodies = {
        "a": box([0.0, 1.0], [2.5, 3.0], [-1.0, 0.3]),
        "b": box([0.0, 3.2], [3.0, 5.0], [-0.8, -2.0]),
    }
    case = scene(
        2, bodies, cells=[16, 8], wall="mirror", end=0.5,
        boundaries={"x-min": "slip", "y-min": "slip"}, contact=[{"bodies": "all", "friction": 0.3}],
    )  # fmt: skip
    plain, other = finish(start(case)), start(case)
    add = VertexSums.add

    def after_others(self, *args):
        self.grid.G[:] = np.nan
        add(self, *args)

    monkeypatch.setattr(VertexSums, "add", after_others)
    finish(other)
    assert other.diagnostics()["contact.all.normal-impulse"] > 0.0
    assert np.array_equal(field(plain, "x"), field(other, "x"))
