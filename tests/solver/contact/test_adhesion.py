"""Surfaces that hold each other: their strength is a stress times the area where they touch."""

import numpy as np
import pytest
from scenes import box, scene, start

from pgimp.case.schema import Case

pytestmark = pytest.mark.slow(20)


def glued(offset, way, adhesion, friction=0.0, D=2, floor="rigid"):
    """A block of four cells on a floor that is `offset` above vertices, drawn off `way` at 0.03.

    First it is lowered onto the floor, pressed a little, and let rest.
    """
    low, high = [2.0] * D, [6.0] * D
    low[-1], high[-1] = 4.5 if floor == "rigid" else 4.0, 8.0
    region = {"box": {"min": [0.0] * (D - 1) + [1.0], "max": [9.0] * (D - 1) + [4.0 + offset]}}
    held = {"box": {"min": [0.0] * (D - 1) + [7.0], "max": [9.0] * (D - 1) + [9.0]}}
    floors = {"rigid": {"rigid": {}, "region": region},
              "soft": {"material": "soft", "region": region}}  # fmt: skip
    down = (4.0 + offset - low[-1] - 0.02) / 7.0
    velocity = [
        {"table": [[0.0, 0.0], [1.0, down * (d == D - 1)], [7.0, down * (d == D - 1)], [8.0, 0.0],
                   [9.0, 0.03 * way[d]], [20.0, 0.03 * way[d]]]}
        for d in range(D)
    ]  # fmt: skip
    constraints = {"top": {"body": "block", "region": held, "velocity": velocity}}
    if floor == "soft":
        below = {"box": {"min": [0.0] * D, "max": [9.0] * (D - 1) + [2.9]}}
        rest = {"body": "floor", "region": below, "velocity": [0.0] * D}
        constraints["low"] = rest
    case = scene(
        D, {"block": box(low, high), "floor": floors[floor]}, cells=[10] * D, end=20.0,
        step={"courant": 0.4}, constraints=constraints,
        contact=[{"bodies": ["block", "floor"], "friction": friction, "adhesion": adhesion}],
    )  # fmt: skip
    case["materials"]["soft"] = {**case["materials"]["soft"], "young": 400.0, "poisson": 0.0}
    return case


def drawn(case, *axes):
    """Forces on the block over time while it is drawn, quasi-static, and the simulation."""
    sim, force = start(case), []
    while not sim.finished:
        sim.advance()
        sim.particles.v[:] *= 0.99
        line = sim.diagnostics()
        if sim.time > 9.0:
            force.append([line[f"contact.block+floor-{axis}"] for axis in axes])
    return (*np.array(force).T, sim)


@pytest.mark.parametrize("offset", [0.0, 0.3, 0.45])
def test_surfaces_part_at_their_strength(offset):
    """A stress of 4 on four cells, wherever between vertices the surface lies; then nothing."""
    force, sim = drawn(glued(offset, [0.0, 1.0], {"normal": 4.0, "range": 0.1}), "y")
    assert -force.min() == pytest.approx(16.0, rel=0.01)
    assert (force[-100:] == 0.0).all()
    assert sim.diagnostics()["contact.block+floor.impact-loss"] > 0.0


@pytest.mark.wide
def test_surfaces_part_at_their_strength_in_space():
    """Edges and corners count with the area that they have."""
    case = glued(0.3, [0.0, 0.0, 1.0], {"normal": 4.0, "range": 0.1}, D=3)
    force, _ = drawn(case, "z")
    assert -force.min() == pytest.approx(64.0, rel=0.01)
    assert (force[-20:] == 0.0).all()


def test_bodies_that_both_give_way():
    """The outermost half cell of each side does not hold: three of four cells."""
    case = glued(0.0, [0.0, 1.0], {"normal": 4.0, "range": 0.1}, floor="soft")
    force, _ = drawn(case, "y")
    assert -force.min() == pytest.approx(12.0, rel=0.03)
    assert (force[-100:] == 0.0).all()


@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_surfaces_slide_at_their_strength_and_friction(friction):
    """Shear strength times area, and the coefficient times what presses, also while they slide.

    Drawn at its top the block lifts its trailing edge by more than a tenth of a cell.
    """
    case = glued(0.3, [1.0, 0.0], {"shear": 2.0, "range": 0.4}, friction)
    force, press, _ = drawn(case, "x", "y")
    force, press = -force[-100:].mean(), press[-100:].mean()
    assert force == pytest.approx(8.0 + friction * press, rel=0.02)
    assert press > 1.0


@pytest.mark.parametrize(
    "entry, said",
    [
        ({"adhesion": {"normal": 1.0, "range": 1.5}}, "at most the side of a cell, 1"),
        ({"adhesion": {"normal": 1.0}}, "range"),
        ({"adhesion": {"range": 0.1}}, "expected a stress above 0 here or as `shear`"),
        ({"adhesion": {"shear": -1.0, "range": 0.1}}, "must be at least 0"),
        ({"adhesion": {"shear": 1.0, "range": 0.1}, "law": "tie"}, "have no adhesion"),
    ],
)
def test_what_cannot_be_is_refused(entry, said):
    case = glued(0.0, [0.0, 1.0], None)
    case["contact"] = [{"bodies": ["block", "floor"], **entry}]
    with pytest.raises(ValueError, match=said):
        Case.model_validate(case)
