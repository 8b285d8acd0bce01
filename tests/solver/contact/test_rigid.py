"""Rigid bodies that move as prescribed: what must hold exactly, and what exact solutions say."""

from math import cos, pi, radians, sin

import numpy as np
import pytest
from rams import rigid, struck
from scenes import box, energy, finish, scene, start, tracked

from pgimp.case.reader import dump_case, read_case
from pgimp.case.schema import Case

pytestmark = pytest.mark.slow(30)


def impulses(sim, name):
    """Impulse and moment of momentum that a rigid body got in a whole run, and its last line."""
    total, last = np.zeros(6), sim.diagnostics()["time"]
    while not sim.finished:
        sim.advance()
        line = sim.diagnostics()
        names = [f"rigid.{name}.{what}-{a}" for what in ("force", "torque") for a in "xyz"]
        total += (line["time"] - last) * np.array([line.get(each, 0.0) for each in names])
        last = line["time"]
    return total, line


@pytest.mark.parametrize("D", [1, 2, 3])
def test_momentum_and_work_of_a_ram(D):
    """A ram at constant velocity: the block leaves faster; all it has is what the ram gave."""
    velocity = [1.0, 0.5, -0.25][:D]
    sim = start(struck(D, {"friction": 0.5}, velocity=velocity))
    total, line = impulses(sim, "ram")
    momentum = np.array([line[f"momentum-{a}"] for a in "xyz"[:D]])
    assert momentum[0] > 1.1 * line["mass"]
    assert total[:D] == pytest.approx(-momentum, abs=2e-12 * momentum[0])
    assert line["rigid.ram.work"] == pytest.approx(momentum @ velocity, rel=1e-12)
    assert line["external-work"] == line["rigid.ram.work"]
    assert line["rigid.ram.displacement-x"] == pytest.approx(1.0, abs=1e-12)
    lost = line["dissipated-energy"]
    assert 0.0 < lost < 0.3 * line["rigid.ram.work"]
    # Moments about the origin of the coordinates where it began, which goes along.
    if D == 2:
        gained = line["angular-momentum-z"]
        assert -total[5] == pytest.approx(gained, abs=0.1 * abs(momentum[0]))


@pytest.mark.parametrize("law", ["friction", "tied", "ignore"])
def test_a_ram_that_is_pulled_away(law):
    """It takes nothing along, unless it is tied: then all."""
    sim = finish(start(struck(2, {"law": law}, velocity=[-1.0, 0.2])))
    line = sim.diagnostics()
    if law == "tied":
        velocity = np.array([line["momentum-x"], line["momentum-y"]]) / line["mass"]
        assert velocity[0] < -0.5
        assert line["body.block.centre-x"] == pytest.approx(5.5 - 1.0, abs=0.4)
    else:
        assert line["momentum-x"] == line["momentum-y"] == 0.0
        assert energy(line) == 0.0


@pytest.mark.parametrize("law", ["friction", "tied"])
def test_a_block_on_a_table_that_speeds_up(law):
    """It gets the acceleration of what it lies on: pushed from behind, or tied."""
    motion = {"velocity": {"table": [[0.0, [0.0, 0.0]], [4.0, [2.0, 0.0]]]}}
    case = struck(2, {"law": law}, **motion)
    case["time"]["end"], case["method"]["affine"] = 4.0, True
    line = finish(start(case)).diagnostics()
    assert line["momentum-x"] / line["mass"] == pytest.approx(2.0, abs=0.1)
    assert line["body.block.centre-x"] == pytest.approx(5.5 + 4.0, abs=0.15)


@pytest.mark.parametrize("friction", [0.3, 0.1])
def test_a_block_slides_down_a_rigid_slope(friction):
    """Its acceleration within one per cent, with what presses while it bounces."""
    slope, g = radians(24.0), 1.0
    n, along = np.array([sin(slope), cos(slope)]), np.array([cos(slope), -sin(slope)])
    corner = np.array([3.0, 13.0])

    def half(point, normal):
        return {"half-space": {"point": point.tolist(), "normal": normal.tolist()}}

    whole = {"box": {"min": [0.0, 0.0], "max": [30.0, 18.0]}}
    block = [whole, half(corner, -n), half(corner + 4.0 * n, n), half(corner, -along)]
    region = {"intersection": [*block, half(corner + 9.0 * along, along)]}
    ground = {"intersection": [{"box": {"min": [-5.0, -5.0], "max": [40.0, 18.0]}},
                               half(corner, n)]}  # fmt: skip
    bodies = {"block": {"material": "soft", "region": region},
              "slope": {"rigid": {}, "region": ground}}  # fmt: skip
    case = scene(2, bodies, cells=[30, 18], end=5.0, step={"courant": 0.3}, gravity=[0.0, -g],
                 contact=[{"bodies": ["block", "slope"], "friction": friction}])  # fmt: skip
    case["materials"]["soft"] = {**case["materials"]["soft"], "young": 1000.0}
    case["method"]["affine"] = True
    sim = start(case)
    lines = []
    for time in (1.0, 5.0):
        while sim.time < time and not sim.finished:
            sim.advance()
        lines.append(sim.diagnostics())
    begin, end = lines
    change = [end[name] - begin[name] for name in ("momentum-x", "momentum-y")]
    gained, bounced = (np.dot(change, way) / end["mass"] / 4.0 for way in (along, n))
    assert abs(bounced) < 0.03 * g
    pressed = g * cos(slope) + bounced
    assert gained == pytest.approx(g * sin(slope) - friction * pressed, rel=0.01)
    push = end["contact.block+slope.normal-impulse"]
    slip = end["contact.block+slope.tangential-impulse"]
    assert slip == pytest.approx(friction * push, rel=0.04)  # it begins at rest
    assert push == pytest.approx(g * cos(slope) * end["mass"] * end["time"], rel=0.04)
    assert end["rigid.slope.work"] == 0.0


def test_a_wheel_turns_a_disk():
    """Two round bodies that touch: the disk begins to turn the other way, without moving off."""
    bodies = {
        "disk": {"material": "soft", "region": {"ball": {"centre": [10.0, 6.0], "radius": 4.0}}},
        "wheel": {
            "rigid": {"rotation": {"about": [10.0, 13.0], "rate": 0.5}},
            "region": {"ball": {"centre": [10.0, 13.0], "radius": 3.0}},
        },
        "bed": rigid([0.0, 0.0], [20.0, 2.0]),
    }
    contact = [{"bodies": ["disk", "wheel"], "friction": 0.4}, {"bodies": ["disk", "bed"]}]
    case = scene(2, bodies, cells=[20, 16], end=6.0, gravity=[0.0, 0.1], contact=contact)
    sim = start(case)
    heat, torque, work = tracked(
        sim, "contact.disk+wheel.friction-heat", "rigid.wheel.torque-z", "rigid.wheel.work"
    )
    assert torque[1:].min() < 0.0  # the disk holds the wheel back
    assert work[-1] > 0.0
    assert (np.diff(heat) > -1e-12).all()
    x, v = (sim.particles.x[sim.live()], sim.particles.v[sim.live()])
    arm = x - x.mean(axis=0)
    assert (arm[:, 0] * v[:, 1] - arm[:, 1] * v[:, 0]).mean() < 0.0


def test_poses_are_integrals_of_the_motion():
    """Exact for tables and constant rates, about any axis."""
    motion = {
        "velocity": {"table": [[0.0, [0.0, 0.0, 1.0]], [2.0, [4.0, 0.0, 1.0]]]},
        "rotation": {"about": [4.0, 4.0, 4.0], "axis": [2.0, 0.0, 0.0],
                     "rate": {"table": [[0.0, 0.0], [1.0, pi]]}},
    }  # fmt: skip
    bodies = {"block": box([1.0] * 3, [2.0] * 3), "ram": rigid([3.0] * 3, [5.0] * 3, **motion)}
    case = Case.model_validate(scene(3, bodies, end=2.0))
    body = case.rigid_bodies["ram"].rigid
    centre, turn = body.pose(1.0)
    assert centre == pytest.approx((5.0, 4.0, 5.0))
    assert np.array(turn).reshape(3, 3) @ [0, 1, 0] == pytest.approx([0, 0, 1], abs=1e-15)
    velocity, spin = body.velocities(1.5)
    assert velocity == pytest.approx((3.0, 0.0, 1.0))
    assert spin == pytest.approx((pi, 0.0, 0.0))
    assert read_case(dump_case(case), "case.yaml") == case


def test_a_fast_ram_shortens_the_steps():
    """Under Courant control it moves by no more than that part of a cell in a step."""
    case = struck(2, {"friction": 0.1}, velocity={"table": [[0.0, [0.0, 0.0]], [0.2, [50.0, 0.0]]]})
    case["time"] = {"end": 0.05, "step": {"courant": 0.2}}
    sim = start(case)
    sim.advance()
    assert sim.dt <= 0.2 / 50.0


def test_distant_rigid_bodies_leave_others_as_they_are():
    """What no entry is for does not tie others: their clearances from walls stay their own."""
    bodies = {
        "low": box([2.0, 0.03], [5.0, 2.03]),
        "high": box([5.0, 0.0], [8.0, 3.0]),
        "far": rigid([10.0, 5.0], [12.0, 7.0]),
    }
    parts = {"cells": [14, 8], "end": 0.3, "gravity": [0.0, -1.0],
             "boundaries": {"y-min": "unilateral"},
             "contact": [{"bodies": ["low", "high"], "friction": 0.3}]}  # fmt: skip
    alone = {name: bodies[name] for name in ("low", "high")}
    lines = [finish(start(scene(2, some, **parts))).diagnostics() for some in (bodies, alone)]
    assert lines[0]["strain-energy"] == lines[1]["strain-energy"] > 0.0


@pytest.mark.parametrize("law", ["friction", "tied"])
def test_what_relaxation_takes_is_booked(law):
    """The ram's impulse is the block's momentum, also where velocities relax to the grid's."""
    case = struck(2, {"law": law}, velocity=[1.0, 0.5])
    case["method"]["pic-damping"] = 5.0
    total, line = impulses(start(case), "ram")
    momentum = np.array([line["momentum-x"], line["momentum-y"]])
    assert total[:2] == pytest.approx(-momentum, abs=1e-12 * np.abs(momentum).max())


def test_long_cells_along_x_and_along_y_give_the_same():
    """What counts as flat, and as an edge, is told by the cells along a surface, whatever axis."""
    found = []
    for turn in (slice(None), slice(None, None, -1)):
        ball = {
            "rigid": {"velocity": [0.1, -0.8][turn]},
            "region": {"ball": {"centre": [8.1, 9.3][turn], "radius": 3.13}},
        }
        bodies = {"plate": box([2.0, 2.0][turn], [14.0, 6.0][turn]), "ball": ball}
        case = scene(2, bodies, contact=[{"bodies": ["plate", "ball"], "friction": 0.3}], end=1.6)
        case["grid"] = {"size": [16.0, 16.0], "cell": [1.0, 0.5][turn]}
        found.append(finish(start(case)).diagnostics())
    for name in ("normal-impulse", "friction-heat", "impact-loss"):
        one, other = (line[f"contact.plate+ball.{name}"] for line in found)
        assert other == pytest.approx(one, rel=1e-9) and one > 1e-5, name
