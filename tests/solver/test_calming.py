"""Velocities of soil that no vertex sees fade: by dense matrices, alone, and a heap at rest."""

from copy import deepcopy
from unittest.mock import patch

import numpy as np
import pytest
from scenes import start
from tiers import wide

from pgimp.solver.flows import CALM, EVERY

pytestmark = pytest.mark.slow(90)

#: Speed of waves is sqrt(1.2 young/density), times cells of 1.
SAND = {
    "model": "drucker-prager", "young": 1.0e3, "poisson": 0.25, "density": 1.0, "cohesion": 0.0,
    "friction-angle": 30.0,
}  # fmt: skip
SPEED = np.sqrt(1.2e3)


def block(low, high, material="sand", **parts):
    """A body in a box."""
    return {"material": material, "region": {"box": {"min": low, "max": high}}} | parts


def blocks(relaxation="auto", bodies=None, shape="gimp", **parts):
    """Blocks without weight on a grid of 12 by 8 cells."""
    grains = {key: SAND[key] for key in ("young", "poisson", "density")}
    return deepcopy({
        "format": 1, "dimensions": 2, "grid": {"size": [12.0, 8.0], "cell": [1.0, 1.0]},
        "method": {"shape": shape, "particles-per-cell": [2, 2], "relaxation": relaxation},
        "time": {"end": 1.0e3, "step": 1.0e-3},
        "materials": {
            "sand": SAND, "solid": {"model": "hooke"} | grains,
            "water": {"model": "newtonian", "bulk": 800.0, "density": 1.0},
            "grains": {
                "model": "mu-i", "mu-s": 0.4, "mu-2": 0.7, "i0": 0.3, "grain": 0.01,
                "grain-density": 2.0,
            } | grains,
        },
        "bodies": bodies or {"sand": block([2.0, 2.0], [6.0, 6.0])},
    } | parts)  # fmt: skip


def shaken(case, v):
    """After a first step that calms, which began with `v(x)`: velocities, x, masses, bodies."""
    case["materials"] = {
        name: law for name, law in case["materials"].items()
        if name in {body["material"] for body in case["bodies"].values()}
    }  # fmt: skip
    sim = start(case)
    while sim.step < EVERY - 1:
        sim.advance()
    p, rows = sim.particles, sim.live()
    x, before = p.x[rows].copy(), p.id[rows].copy()
    p.v[rows] = v(x)
    sim.advance()
    p, rows = sim.particles, sim.live()
    rows = rows[np.argsort(p.id[rows])]
    return p.v[rows], x[np.argsort(before)], p.m[rows], p.body[rows]


def gains(case, v):
    """What calming alone has changed: velocities less those without; places, masses, bodies.

    Without is at a rate of 0, whose kernels are the same.
    """
    found, *more = shaken(case, v)
    with patch("pgimp.solver.flows.CALM", 0.0):
        without, *_ = shaken(case, v)
    return found - without, *more


def tents(x, vertex, half=0.25):
    """Mean of a vertex's tent over a particle's box, by its integral."""

    def whole(s):
        s = np.clip(s, -1.0, 1.0)
        return s - 0.5 * s * abs(s)

    return (whole(x + half - vertex) - whole(x - half - vertex)) / (2.0 * half)


def weights(x):
    """S_vp of particles of half a cell, one row a particle."""
    return np.stack(
        [tents(x[:, 0], i) * tents(x[:, 1], j) for i in range(13) for j in range(9)], axis=1
    )


def noise(x):
    """Velocities that differ from particle to particle, the same for the same places."""
    return 1.0e-3 * np.stack([np.sin(71.0 * x[:, 0] + 13.0 * x[:, 1]), np.cos(37.0 * x.sum(1))], 1)


@pytest.mark.parametrize("material", ["sand", "grains"])
def test_velocities_relax_to_those_of_the_vertices(material):
    """By dense matrices; momentum is kept, and no energy gained."""
    found, x, m, _ = gains(blocks(bodies={"one": block([2, 2], [6, 6], material)}), noise)
    S, v = weights(x), noise(x)
    mass = S.T @ m
    seen = (S.T @ (m[:, None] * v)) / np.maximum(mass, 1e-9)[:, None]
    part = 1.0 - np.exp(-CALM * EVERY * 1.0e-3 * SPEED)
    assert found == pytest.approx(part * (S @ seen - v), abs=1e-17)
    assert abs(found).max() > 0.5 * part * 1.0e-3
    assert m @ found == pytest.approx(0.0, abs=1e-17)
    assert (m[:, None] * v * found).sum() < -0.1 * part * (m[:, None] * v * v).sum()


def test_without_calming_velocities_are_those_at_a_rate_of_0():
    with patch("pgimp.solver.flows.CALM", 0.0):
        still, *_ = shaken(blocks(), noise)
    assert np.array_equal(still, shaken(blocks(0.0), noise)[0])


@pytest.mark.parametrize("shape", ["gimp", "cpdi", wide("bspline-quadratic"), wide("mpm")])
def test_what_moves_as_a_whole_is_left_as_it_is(shape):
    """A translation everywhere; a turn in the inside."""
    wide = {"bodies": {"sand": block([2, 2], [10, 10])}, "grid": {"size": [12, 12], "cell": [1, 1]}}
    case = blocks(shape=shape, **wide)
    found, x, _, _ = gains(case, lambda x: np.full_like(x, 1.0e-3))
    assert abs(found).max() < 1e-16
    found, x, _, _ = gains(case, lambda x: 1.0e-3 * (x[:, ::-1] - 6.0) * [-1.0, 1.0])
    inside = (abs(x - 6.0) < 0.5).all(axis=1)
    assert inside.any() and abs(found[inside]).max() < 1e-16


@pytest.mark.wide
def test_other_bodies_have_no_part_in_it():
    """A solid on sand, on the same vertices: sand keeps its momentum, the solid every bit."""
    bodies = {
        "sand": block([2, 2], [6, 4]), "solid": block([2, 4], [6, 6], "solid"),
        "water": block([6, 2], [8, 4], "water"),
    }  # fmt: skip
    found, _, m, body = gains(blocks(bodies=bodies), noise)
    assert not found[body > 0].any()
    assert abs(found[body == 0]).max() > 1e-7
    assert m @ found == pytest.approx(0.0, abs=1e-17)


def test_sands_of_any_stiffness_keep_their_momentum():
    """They are calmed at different rates, each for itself."""
    bodies = {"below": block([2, 2], [6, 4]), "above": block([2, 4], [6, 6], "stiff")}
    laws = {"sand": SAND, "stiff": SAND | {"young": 4.0e3}}
    found, _, m, body = gains(blocks(bodies=bodies, materials=laws), noise)
    for one in (0, 1):
        assert abs(found[body == one]).max() > 1e-7
        assert m[body == one] @ found[body == one] == pytest.approx(0.0, abs=1e-17)


def test_sand_that_slides_on_sand_is_not_braked():
    """Where bodies meet each has its own motion; without contact they are one."""
    bodies = {"below": block([2, 2], [6, 4]), "above": block([2, 4], [6, 6])}
    law = [{"bodies": ["below", "above"], "friction": 0.1}]

    def apart(x):
        return np.stack([1.0e-3 * np.sign(x[:, 1] - 4.0), np.zeros(len(x))], axis=1)

    assert abs(gains(blocks(bodies=bodies, contact=law), apart)[0]).max() < 1e-16
    assert abs(gains(blocks(bodies=bodies), apart)[0]).max() > 1e-7


@pytest.mark.wide
def test_what_a_constraint_holds_has_no_part_in_it():
    """Held particles keep what is prescribed; the others keep their momentum."""
    held = {"body": "sand", "region": {"box": {"min": [2, 2], "max": [6, 3]}}}
    case = blocks(constraints={"held": held | {"velocity": [0.0, None]}})
    found, x, m, _ = gains(case, noise)
    free = x[:, 1] > 3.0
    assert not found[~free].any() and abs(found[free]).max() > 1e-7
    assert m @ found == pytest.approx(0.0, abs=1e-17)


def test_who_is_calmed():
    """Loose soil and grains, of the current configuration, unless the case gives a rate."""

    def calms(material, relaxation="auto", **parts):
        case = blocks(relaxation, {"one": block([2, 2], [6, 6], material, **parts)})
        case["materials"] = {material: case["materials"][material]}
        flows = start(case).scene.interaction.flows
        return bool(flows and flows.calms.any())

    assert calms("sand") and calms("grains")
    assert not calms("sand", 0.0) and not calms("sand", 3.0)
    assert not calms("sand", configuration="initial")
    assert not calms("water") and not calms("solid")


def test_sand_that_has_collapsed_comes_to_rest():
    """Under 2 % of the greatest kinetic energy is left, without calming over 5 %: 0.5 and 13 %.

    Nothing that has been lost comes back.
    """
    left, undone = [], []
    for relaxation in ("auto", 0.0):
        sim = start(blocks(
            relaxation, {"one": block([0.0, 0.0], [4.0, 8.0])}, gravity=[0.0, -1.0],
            grid={"size": [24.0, 10.0], "cell": [1.0, 1.0]}, time={"end": 60.0, "step": 0.008},
            boundaries={"x-min": "slip", "y-min": {"unilateral": {"friction": 0.5}}},
            materials={"sand": SAND},
        ))  # fmt: skip
        most, lost = 0.0, [0.0]
        while not sim.finished:
            for _ in range(50):
                sim.advance()
            line = sim.diagnostics()
            most = max(most, line["kinetic-energy"])
            lost.append(line["dissipated-energy"])
        left.append(line["kinetic-energy"] / most)
        undone.append((max(lost) - lost[-1]) / most)
    assert left[0] < 0.02 and left[1] > 0.05
    assert undone[0] < 0.005


@pytest.mark.parametrize("count", [16, 17])
def test_many_bodies_that_meet_are_not_calmed(count):
    """Each would need a field: numbers of fields that bodies share change when a run is resumed."""
    bodies = {f"g{n}": block([0.25 * n, 0.0], [0.25 * n + 0.25, 0.5]) for n in range(count)}
    case = blocks(bodies=bodies, contact=[{"bodies": "all"}])
    flows = start(case).scene.interaction.flows
    assert flows.calms.any() == (count == 16)
    assert len(set(flows.fields)) == (16 if count == 16 else 1)
