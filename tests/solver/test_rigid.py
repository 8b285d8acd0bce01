"""Rigid bodies that move as prescribed: what must hold exactly, and what exact solutions say."""

from math import cos, pi, radians, sin

import numpy as np
import pytest
from scenes import box, energy, finish, scene, start, tracked

from pgimp.case.reader import dump_case, read_case
from pgimp.case.schema import Case
from pgimp.errors import CaseError, UsageError
from pgimp.scene.toolchecks import require_same


def rigid(low, high, **motion):
    """A rigid body that fills a box."""
    return {"rigid": motion, "region": {"box": {"min": list(low), "max": list(high)}}}


def struck(D, law, **motion):
    """A block that a rigid body is to meet along x."""
    bodies = {
        "block": box([4.0] + [2.0] * (D - 1), [7.0] + [5.0] * (D - 1)),
        "ram": rigid([1.5] + [1.0] * (D - 1), [4.0] + [6.0] * (D - 1), **motion),
    }
    contact = [{"bodies": ["block", "ram"], **law}]
    return scene(D, bodies, cells=[16, 8, 8][:D], end=1.0, contact=contact)


def impulses(sim, name):
    """Impulse and moment of momentum that a rigid body got in a whole run, and its last line."""
    total, last = np.zeros(6), sim.diagnostics()["time"]
    while not sim.finished:
        sim.advance()
        line = sim.diagnostics()
        names = [f"tool.{name}.{what}-{a}" for what in ("force", "torque") for a in "xyz"]
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
    assert line["tool.ram.work"] == pytest.approx(momentum @ velocity, rel=1e-12)
    assert line["external-work"] == line["tool.ram.work"]
    assert line["tool.ram.displacement-x"] == pytest.approx(1.0, abs=1e-12)
    lost = line["dissipated-energy"]
    assert 0.0 < lost < 0.3 * line["tool.ram.work"]
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
    assert end["tool.slope.work"] == 0.0


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
        sim, "contact.disk+wheel.friction-heat", "tool.wheel.torque-z", "tool.wheel.work"
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
    body = case.tools["ram"].rigid
    centre, turn = body.pose(1.0)
    assert centre == pytest.approx((5.0, 4.0, 5.0))
    assert np.array(turn).reshape(3, 3) @ [0, 1, 0] == pytest.approx([0, 0, 1], abs=1e-15)
    velocity, spin = body.velocities(1.5)
    assert velocity == pytest.approx((3.0, 0.0, 1.0))
    assert spin == pytest.approx((pi, 0.0, 0.0))
    assert read_case(dump_case(case), "case.yaml") == case


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"rigid": {"speed": 1.0}}, "speed"),
        ({"rigid": {"velocity": [1.0]}}, "bodies.ram.rigid.velocity"),
        ({"rigid": {"rotation": {"about": [1.0, 1.0], "axis": [1.0, 0.0, 0.0], "rate": 1.0}}},
         "in 2D the axis is z"),
        ({"material": "soft"}, "bodies.ram.material"),
        ({"velocity": [1.0, 0.0]}, "bodies.ram.velocity"),
        ({"region": {"half-space": {"point": [3.0, 3.0], "normal": [1.0, 0.0]}}}, "has no end"),
        ({"region": {"box": {"min": [1.5, 1.0], "max": [2.0, 6.0]}}}, "0.5 thick"),
        ({"region": {"box": {"min": [1.5, 1.0], "max": [5.5, 6.0]}}}, "'block' reaches 1.5 into"),
        ({"region": {"box": {"min": [1.5, 1.0], "max": [4.3, 6.0]}}}, "'block' reaches 0.3 into"),
        ({"region": {"box": {"min": [5.0, 3.0], "max": [6.0, 4.0]}}}, "'block' reaches 2 into"),
        ({"region": {"points": {"file": "a.csv"}}}, "rigid body has no particles"),
        ({"rigid": {"velocity": [200.0, 0.0]}}, "moves by 2 cells in a step"),
        ({"rigid": {"rotation": {"about": [2.5, 3.0], "rate": 100.0}}}, "cells in a step"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused(change, said):
    case = struck(2, {"friction": 0.1})
    case["bodies"]["ram"] = case["bodies"]["ram"] | change
    with pytest.raises((CaseError, ValueError)) as raised:
        start(case)
    assert said in str(raised.value)


@pytest.mark.parametrize("region", [
    {"box": {"min": [1.5, 1.0], "max": [4.0, 6.0]}},
    {"ball": {"centre": [2.1, 3.4], "radius": 1.9}},
    # A wedge, whose point touches: distances from its planes are much less than from the point.
    {"intersection": [
        {"box": {"min": [1.0, 1.0], "max": [4.0, 6.0]}},
        {"half-space": {"point": [4.0, 3.5], "normal": [1.0, 2.0]}},
        {"half-space": {"point": [4.0, 3.5], "normal": [1.0, -2.0]}},
    ]},
])  # fmt: skip
def test_what_touches_is_not_refused(region):
    """A flat face, a round one, and the point of a wedge."""
    case = struck(2, {"friction": 0.1})
    case["bodies"]["ram"] |= {"region": region}
    start(case)


def test_contact_of_rigid_bodies_alone_is_refused():
    """They do not feel each other, and an entry for them would be thought to do something."""
    case = struck(2, {"friction": 0.1})
    case["bodies"]["wall"] = rigid([10.0, 1.0], [12.0, 6.0])
    case["contact"].append({"bodies": ["ram", "wall"]})
    with pytest.raises((CaseError, ValueError), match=r"contact\.1\.bodies\s+all are rigid"):
        start(case)


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
             "boundaries": {"y-min": "separating"},
             "contact": [{"bodies": ["low", "high"], "friction": 0.3}]}  # fmt: skip
    alone = {name: bodies[name] for name in ("low", "high")}
    lines = [finish(start(scene(2, some, **parts))).diagnostics() for some in (bodies, alone)]
    assert lines[0]["strain-energy"] == lines[1]["strain-energy"] > 0.0


@pytest.mark.parametrize("law", ["friction", "tied"])
def test_what_relaxation_takes_is_booked(law):
    """The ram's impulse is the block's momentum, also where velocities relax to the grid's."""
    case = struck(2, {"law": law}, velocity=[1.0, 0.5])
    case["method"]["relaxation"] = 5.0
    total, line = impulses(start(case), "ram")
    momentum = np.array([line["momentum-x"], line["momentum-y"]])
    assert total[:2] == pytest.approx(-momentum, abs=1e-12 * np.abs(momentum).max())


def test_a_run_goes_on_with_the_same_rigid_bodies_only():
    sim = start(struck(2, {"friction": 0.1}))
    other = struck(2, {"friction": 0.1})
    other["bodies"]["ram"]["region"]["box"]["min"][0] = 1.0
    assert sim.scene.tools.checksum != start(other).scene.tools.checksum
    require_same(sim.scene.tools, sim.scene.tools.checksum)
    with pytest.raises(UsageError, match="has the file of a mesh changed"):
        require_same(sim.scene.tools, start(other).scene.tools.checksum)


def test_nothing_but_contact_may_name_a_rigid_body():
    case = struck(2, {"friction": 0.1})
    case["constraints"] = {
        "grip": {"body": "ram", "region": {"box": {"min": [0.0, 0.0], "max": [9.0, 8.0]}},
                 "velocity": [0.0, 0.0]}
    }  # fmt: skip
    with pytest.raises(ValueError, match=r"constraints\.grip\.body"):
        start(case)
    alone = struck(2, {})
    del alone["bodies"]["block"], alone["contact"]
    with pytest.raises(ValueError, match="needs a body of a material"):
        start(alone)


@pytest.mark.parametrize(("rigid", "speed"), [
    ({"velocity": [0.0, -3.0]}, 0.0),
    ({"velocity": {"table": [[0.0, [0.0, 0.0]], [9.0, [0.0, -6.0]]]}}, 6.0),
    ({"rotation": {"about": [4.0, 6.5], "rate": 3.0}}, 6.0),
    ({"density": 1.0}, 0.0),
])  # fmt: skip
def test_rigid_bodies_that_are_fast_for_waves_are_warned_of(rigid, speed):
    """Waves of 11.6; the one that turns is a ball of R = 2."""
    bodies = {"block": box([2.0, 1.0], [6.0, 4.0]),
              "punch": {"rigid": rigid, "region": {"ball": {"centre": [4.0, 6.5], "radius": 2.0}}}}
    case = scene(2, bodies, cells=[8, 12], step={"courant": 0.3}, contact=[{"bodies": "all"}])
    said = [text for text in start(case).warnings if text.startswith("bodies.punch.rigid")]
    assert len(said) == bool(speed)
    for text in said:
        assert float(text.split("up to ")[1].split(",")[0]) == pytest.approx(speed, rel=0.02)
        assert "waves in 'block' (11.6)" in text


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
