"""Walls that let go: bodies feel them when they are there, at any place, and keep their bits."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as some
from scenes import box, field, finish, scene, start, tracked
from tiers import wide

from pgimp.physics.boundaries.unilateral import UnilateralParameters


def falling(dimension, axis, side, gap, shape="gimp", **parts):
    """A block of two cells that moves towards one face, `gap` cells away from it, at a speed 1."""
    cells = [8, 7, 6][:dimension]
    low, velocity = [2.0] * dimension, [0.0] * dimension
    low[axis] = gap if side < 0 else cells[axis] - gap - 2.0
    velocity[axis] = float(side)
    face = f"{'xyz'[axis]}-{'min' if side < 0 else 'max'}"
    case = scene(
        dimension, box(low, [x + 2.0 for x in low], velocity), cells=cells, shape=shape,
        per_cell=2 if dimension < 3 else 1, boundaries={face: "unilateral"}, **parts,
    )  # fmt: skip
    return case, f"reaction.{face}-{face[0]}"


@settings(max_examples=12, deadline=None)
@given(data=some.data())
def test_a_face_is_felt_when_it_is_reached(data):
    """A face on the lattice that falls flat on any wall: in the step that closes the gap."""
    D = data.draw(some.integers(1, 2))
    axis, side = data.draw(some.integers(0, D - 1)), data.draw(some.sampled_from([-1, 1]))
    gap = 0.5 * data.draw(some.integers(1, 3))
    case, name = falling(D, axis, side, gap, end=2.0, step=0.02)
    (force,) = tracked(start(case), name)
    touch = np.flatnonzero(force)[0]
    assert abs(0.02 * touch - gap) <= 0.05


@pytest.mark.parametrize(
    "shape", ["finite-gimp", *map(wide, ("mpm", "fuzzy-nearest", "fuzzy-constant"))]
)
def test_other_shapes(shape):
    """Boxes know the gap, tents to less than a cell; points are felt from a cell on."""
    case, name = falling(2, 1, -1, 1.5, shape, end=2.0, step=0.02)
    (force,) = tracked(start(case), name)
    gap = 1.5 - 0.02 * np.flatnonzero(force)[0]
    assert abs(gap) < {"mpm": 1.1, "finite-gimp": 0.03}.get(shape, 0.8)


def test_what_lies_on_a_wall_lies_there():
    """A block under its weight, for long: where its strain puts it, with its weight as reaction."""
    body = box([1.0, 0.0], [5.0, 3.0])
    case = scene(2, body, end=30.0, step={"courant": 0.3}, gravity=[0.0, -0.02],
                 boundaries={"y-min": "unilateral"})  # fmt: skip
    case["method"]["pic-damping"] = 0.5
    sim = start(case)
    height, force = tracked(sim, "body.body.centre-y", "reaction.y-min-y")
    assert force[-200:].mean() == pytest.approx(12.0 * 0.02, rel=0.01)
    assert field(sim, "x")[:, 1].min() > 0.2
    assert 0.0 < 1.5 - height[-200:].mean() < 0.05


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_what_a_wall_does_not_change_keeps_its_bits(friction):
    """A vertex that moves away, and without friction what is along the wall of one that comes."""
    rng = np.random.default_rng(3)
    face = UnilateralParameters(1, -1, friction, friction, 1e-3)
    for _ in range(500):
        v, a = (tuple(rng.normal(size=3) * scale) for scale in (1.0, 100.0))
        away, pulled = (v[0], abs(v[1]) + 0.2, v[2]), (a[0], -abs(a[1]), a[2])
        assert face.approach(face, away, pulled, 0.0) == (away, pulled)
        into = (v[0], -abs(v[1]), v[2])
        w, b = face.approach(face, into, a, 0.0)
        assert w[1] >= 0.0
        if friction == 0.0:
            assert (w[0], w[2], b[0], b[2]) == (v[0], v[2], a[0], a[2])


def test_in_a_corner_each_wall_holds_what_comes():
    """Thrown into a corner: both walls push, nothing passes them, and it comes out again."""
    case = scene(2, box([0.7, 1.2], [3.7, 4.2], [-0.6, -0.8]), end=4.0, step=0.01,
                 boundaries={"x-min": "unilateral", "y-min": "unilateral"})  # fmt: skip
    sim = start(case)
    across, up = tracked(sim, "reaction.x-min-x", "reaction.y-min-y")
    assert across.max() > 0.1 and up.max() > 0.1
    assert min(across.min(), up.min()) > -1e-6
    first = [0.01 * np.flatnonzero(force > 0.05 * force.max())[0] for force in (across, up)]
    assert first == pytest.approx([0.7 / 0.6, 1.2 / 0.8], abs=0.2)
    assert (field(sim, "x") > 0.1).all()
    line = sim.diagnostics()
    assert line["momentum-x"] > 0.0 and line["momentum-y"] > 0.0


def test_bodies_that_meet_on_a_rough_wall_do_not_depend_on_units():
    """The same in seconds and in thousandths: what is written per time knows the step's length."""
    found = []
    for unit in (1.0, 1000.0):
        bodies = {
            "a": box([1.0, 0.0], [3.0, 2.0], [0.5 / unit, 0.0]),
            "b": box([3.2, 0.3], [5.2, 2.3], [-0.3 / unit, -0.2 / unit]),
        }
        case = scene(
            2, bodies, end=2.0 * unit, step=0.01 * unit, gravity=[0.0, -0.3 / unit**2],
            boundaries={"y-min": {"unilateral": {"friction": 0.3}}},
            contact=[{"bodies": "all", "friction": 0.4}],
        )  # fmt: skip
        soft = case["materials"]["soft"]
        case["materials"]["soft"] = soft | {"young": soft["young"] / unit**2}
        sim = finish(start(case))
        found.append(field(sim, "x"))
    # Powers of ten round; two hundred steps of a soft body carry that on.
    np.testing.assert_allclose(*found, rtol=0.0, atol=1e-9)
