"""Planes of symmetry: a part of a scene between slip faces gives what the whole does.

Of shapes that reflect at walls: boxes of `gimp` that cross the plane as they come near it are held
there otherwise than by the other half, also without contact.
"""

import numpy as np
import pytest
from scenes import field, finish, scene, start
from tiers import wide

pytestmark = pytest.mark.slow(30)


def pressed(dimension, part, floor="unilateral"):
    """A ball that falls on a plate on a floor, or the part of both beyond x = 0 (and y = 0)."""
    cut = dimension - 1  # directions across which there are planes of symmetry
    low = [0.0 if part else -8.0] * cut + [0.0]
    size = [(8.0 if part else 16.0)] * cut + [12.0]
    height = f"{'xyz'[cut]}-min"
    faces = {f"{axis}-min": "slip" for axis in "xyz"[:cut]} if part else {}
    ball = {"ball": {"centre": [0.0] * cut + [6.2], "radius": 3.0}}
    plate = {"box": {"min": [-6.0] * cut + [0.0], "max": [6.0] * cut + [3.0]}}
    if part:
        inside = {"box": {"min": [0.0] * dimension, "max": [8.0] * cut + [12.0]}}
        ball, plate = {"intersection": [ball, inside]}, {"intersection": [plate, inside]}
    bodies = {
        "ball": {
            "material": "soft",
            "region": ball,
            "velocity": [0.0] * cut + [-0.5],
            "surface": "whole-particles",
        },
        "plate": {"material": "soft", "region": plate},
    }
    case = scene(
        dimension, bodies, step=0.02, end=2.4, boundaries=faces | {height: floor},
        contact=[{"bodies": "all", "friction": 0.3}], per_cell=2 if dimension == 2 else 1,
        wall="mirror", shape="fuzzy-nearest",
    )  # fmt: skip
    case["grid"] = {"origin": low, "size": size, "cell": [1.0] * dimension}
    return case


@pytest.mark.parametrize(
    ("dimension", "floor"), [(2, "unilateral"), (2, "fixed"), wide(3, "fixed")]
)
def test_a_part_gives_what_the_whole_does(dimension, floor):
    """Half of a disk on half of a plate, a quarter of a ball on a quarter: to 1e-10."""
    whole, part = (finish(start(pressed(dimension, part, floor))) for part in (False, True))
    push = [sim.diagnostics()["contact.all.normal-impulse"] for sim in (whole, part)]
    assert push[1] * 2 ** (dimension - 1) == pytest.approx(push[0], rel=1e-9)
    assert push[0] > 0.1
    started = start(pressed(dimension, False, floor))
    first = {name: field(started, name) for name in ("x", "body")}
    inside = (first["x"][:, : dimension - 1] > 0.0).all(axis=1)
    found = np.hstack([field(whole, "x"), field(whole, "v"), field(whole, "F")])[inside]
    order = np.lexsort((first["body"][inside], *np.round(first["x"][inside], 6).T))
    lagrangian = start(pressed(dimension, True, floor))
    mine = np.hstack([field(part, "x"), field(part, "v"), field(part, "F")])
    own = np.lexsort((field(lagrangian, "body"), *np.round(field(lagrangian, "x"), 6).T))
    assert mine.shape == found.shape
    np.testing.assert_allclose(mine[own], found[order], rtol=0.0, atol=1e-10)


@pytest.mark.wide
def test_contact_in_the_initial_configuration_keeps_symmetry():
    """Sweeps go through the vertices one after the other: to the tolerance of the impulses."""
    case = pressed(2, part=False)
    del case["method"]["wall"]
    case["method"]["shape"], case["time"]["end"] = "gimp", 10.0
    for body in case["bodies"].values():
        body["formulation"] = "total-lagrangian"
    first = field(start(case), "x").copy()
    last = field(finish(start(case)), "x")
    mirror = np.array([-1.0, 1.0])
    one, other = (np.lexsort(np.round(x, 6).T) for x in (first, first * mirror))
    assert np.abs(last - first).max() > 1.0
    np.testing.assert_allclose(last[one], last[other] * mirror, rtol=0.0, atol=1e-4)


def between_rigid(dimension, part):
    """A plate that a rigid ball from below presses on one that moves freely, or the part of it."""
    cut = dimension - 1
    free = {"density": 0.5, "fixed": [*"xy"[:cut], "rotation"]}
    plate = {"box": {"min": [0.0 if part else -6.0] * cut + [4.0], "max": [6.0] * cut + [7.0]}}
    bodies = {
        "plate": {"material": "soft", "region": plate},
        "above": {
            "rigid": free, "velocity": [0.0] * cut + [-0.5],
            "region": {"ball": {"centre": [0.0] * cut + [12.13], "radius": 5.13}},
        },
        "below": {
            "rigid": {"velocity": [0.0] * cut + [0.5]},
            "region": {"ball": {"centre": [0.0] * cut + [1.03], "radius": 2.87}},
        },
    }  # fmt: skip
    faces = {f"{axis}-min": "slip" for axis in "xyz"[:cut]} if part else {}
    case = scene(
        dimension, bodies, step=0.02, end=2.0, boundaries=faces, wall="mirror",
        contact=[{"bodies": "all", "friction": 0.3}], per_cell=2 if dimension == 2 else 1,
        shape="fuzzy-nearest",
    )  # fmt: skip
    case["grid"] = {
        "origin": [0.0 if part else -8.0] * cut + [0.0],
        "size": [8.0 if part else 16.0] * cut + [18.0], "cell": [1.0] * dimension,
    }  # fmt: skip
    return case


@pytest.mark.parametrize("dimension", [2, wide(3)])
def test_rigid_bodies_lie_across_planes_of_symmetry(dimension):
    """Whole in the case, and half or a quarter in what a free one weighs and gets."""
    whole, part = (finish(start(between_rigid(dimension, part))) for part in (False, True))
    every, own = whole.diagnostics(), part.diagnostics()
    along, k = "xyz"[dimension - 1], 2 ** (dimension - 1)
    assert every[f"rigid.above.displacement-{along}"] > -0.9  # it was stopped
    for name in (f"displacement-{along}", f"velocity-{along}"):
        assert own[f"rigid.above.{name}"] == pytest.approx(every[f"rigid.above.{name}"], rel=1e-10)
    for name in (f"rigid.above.momentum-{along}", "rigid.above.kinetic-energy", "rigid.below.work",
                 "contact.all.normal-impulse", "contact.all.friction-heat",
                 "strain-energy"):  # fmt: skip
        assert own[name] * k == pytest.approx(every[name], rel=1e-10), name
