"""Friction at walls: a block on an incline, and what the case says and writes."""

from math import cos, radians, sin

import numpy as np
import pytest
from scenes import box, field, finish, scene, start, stir

from pgimp.case.reader import dump_case, read_case
from pgimp.case.schema import Case
from pgimp.decomposition.slabs import cut

pytestmark = pytest.mark.slow(20)

#: Gravity, and the block's mass.
G, MASS = 1.0, 12.0


def sliding(friction, angle, **parts):
    """A block of 6 by 2 cells on an incline, which begins at rest."""
    slope = radians(angle)
    case = scene(
        2,
        box([2.0, 0.0], [8.0, 2.0]),
        cells=[30, 5],
        end=6.0,
        step={"courant": 0.3},
        gravity=[G * sin(slope), -G * cos(slope)],
        boundaries={"y-min": {"unilateral": {"friction": friction}}},
        **parts,
    )
    case["materials"]["soft"] = {**case["materials"]["soft"], "young": 1000.0}
    return case


@pytest.mark.parametrize(
    ("friction", "angle", "wall"),
    [(0.3, 24.0, "ghost"), (0.1, 24.0, "ghost"), (0.4, 35.0, "ghost"), (0.4, 35.0, "mirror")],
)
def test_a_block_slides_as_coulomb_says(friction, angle, wall):
    """The reaction is the weight and its friction; acceleration within a per cent.

    Where walls reflect, a face with friction does not: a mirror would bear the weight without it.
    """
    case = sliding(friction, angle)
    case["method"]["wall"] = wall
    sim = start(case)
    lines = [sim.diagnostics()]
    for time in (1.0, 6.0):
        while sim.time < time and not sim.finished:
            sim.advance()
        lines.append(sim.diagnostics())
    _, begin, end = lines
    press = end["reaction.y-min-y"]
    slope = radians(angle)
    assert press == pytest.approx(MASS * G * cos(slope), rel=0.03)  # and the waves of the start
    assert end["reaction.y-min-x"] == pytest.approx(-friction * press, rel=0.01)
    gained = (end["momentum-x"] - begin["momentum-x"]) / (end["time"] - begin["time"])
    exact = MASS * G * (sin(slope) - friction * cos(slope))
    assert gained == pytest.approx(exact, rel=0.01)
    # It lies on the wall: what it sinks in is its own weight's strain.
    sunk = end["body.body.centre-y"] - begin["body.body.centre-y"]
    assert abs(sunk) < 0.005
    # Gravity works; what friction takes of that is heat.
    way = end["body.body.centre-x"] - begin["body.body.centre-x"]
    work = end["external-work"] - begin["external-work"]
    heat = end["wall.y-min.friction-heat"] - begin["wall.y-min.friction-heat"]
    assert work == pytest.approx(MASS * G * (sin(slope) * way - cos(slope) * sunk), rel=1e-9)
    assert heat == pytest.approx(friction * press * way, rel=0.02)
    assert heat < end["dissipated-energy"] - begin["dissipated-energy"] < 1.05 * heat


@pytest.mark.parametrize("friction", [0.6, {"static": 0.6, "kinetic": 0.5}])
def test_a_block_sticks(friction):
    """Below the static coefficient: it shears, by less than a tenth of a cell, and stays."""
    line = finish(start(sliding(friction, 24.0))).diagnostics()
    assert abs(line["body.body.centre-x"] - 5.0) < 0.1
    assert abs(line["momentum-x"]) < 0.05 * MASS


def test_static_friction_is_less_than_what_pulls():
    """Above it the block slides, with the kinetic coefficient."""
    line = finish(start(sliding({"static": 0.4, "kinetic": 0.1}, 24.0))).diagnostics()
    exact = 0.5 * G * (sin(radians(24.0)) - 0.1 * cos(radians(24.0))) * 36.0
    assert line["body.body.centre-x"] - 5.0 == pytest.approx(exact, rel=0.08)


def test_without_friction_it_is_the_plain_wall():
    """The same bits as the plain word."""
    plain, other = (
        start(
            scene(2, box([2.0, 0.5], [5.0, 3.0], [0.3, -1.0]), end=0.6, boundaries={"y-min": wall})
        )
        for wall in ("unilateral", {"unilateral": {"friction": 0.0}})
    )
    for sim in (plain, other):
        stir(sim, 0.3)
        finish(sim)
    for name in ("x", "v", "F"):
        assert np.array_equal(field(plain, name), field(other, name))


@pytest.mark.parametrize("dimension", [2, 3])
def test_friction_takes_no_more_than_there_is(dimension):
    """Thrown along a wall: it stops, all along its surface, and never goes back."""
    D = dimension
    gravity = [0.0] * (D - 1) + [-4.0]
    body = box([1.0] * (D - 1) + [0.0], [3.0] * D, [1.0, *[0.0] * (D - 2), 0.0])
    face = f"{'xyz'[D - 1]}-min"
    case = scene(D, body, end=1.5, gravity=gravity, per_cell=2 if D == 2 else 1,
                 boundaries={face: {"unilateral": {"friction": 0.5}}})  # fmt: skip
    case["materials"]["soft"] = {**case["materials"]["soft"], "young": 1000.0}
    sim = start(case)
    first = sim.diagnostics()
    last = finish(sim).diagnostics()
    assert abs(last["momentum-x"]) < 0.15 * first["momentum-x"]
    if D == 3:
        assert abs(last["momentum-y"]) < 1e-9
    # All of its kinetic energy has become heat of friction, but for what is left of waves.
    assert last["kinetic-energy"] < 0.05 * first["kinetic-energy"]


def test_a_case_writes_the_wall_as_it_is_read():
    case = sliding(0.3, 24.0)
    typed = Case.model_validate(case)
    assert "unilateral: {friction: 0.3, restitution: 0.0}" in dump_case(typed)
    assert read_case(dump_case(typed), "case.yaml") == typed
    plain = Case.model_validate(case | {"boundaries": {"y-min": "unilateral"}})
    assert "y-min: unilateral" in dump_case(plain)
    assert Case.model_validate(case | {"boundaries": {"y-min": {"unilateral": {}}}}) == plain


def test_the_last_rank_has_the_wall():
    """Those beyond a wall share the clearance of the vertex on it, so the cut leaves both there."""
    case = scene(2, box([5.0, 2.0], [7.7, 5.0]), boundaries={"x-max": "unilateral"})
    made = start(case).scene
    layers, wall = (
        made.domain.frame.vertices[0],
        made.domain.frame.ghost + made.domain.frame.cells[0],
    )
    counts = np.zeros(layers, int)
    counts[-4:] = 1000
    assert cut(counts, 3, made.settings.vertices - 1, made.ends)[-2] <= wall
    assert cut(counts, 3, made.settings.vertices - 1)[-2] > wall
