"""Bodies that meet a wall of the domain: the gap at which they feel it, impact, friction, cost."""

from math import cos, radians, sin

import numpy as np
from studies.contact import gap, motion
from studies.scenes import a_line, ball, box, looked

import pgimp


def first(region, dimensions, distance):
    """Gap that is left before the step in which a stiff body first feels y-min, or in 3D z-min."""
    face = f"{'xyz'[dimensions - 1]}-min"
    case = gap.stiff({"a": region}, -np.eye(dimensions)[-1])
    case["grid"]["size"] = [24.0] * dimensions
    case["boundaries"] = {face: "unilateral"}
    return gap.felt(case, distance, f"reaction.{face}-{face[0]}", 1e-14)


def _ball(dimensions, radius, shift):
    centre = [12.0 + shift] * (dimensions - 1) + [1.0 + radius]
    return first(ball(centre, radius), dimensions, 1.0)


def _corner(angle, shift):
    high = 3.0 * (cos(radians(angle)) + sin(radians(angle)))
    region = gap.turned(np.array([12.0 + shift, 1.0 + high]), [3.0, 3.0], angle)
    return first(region, 2, 1.0)


def gaps(quick):
    """Rows of the table: what meets the wall, and the least and greatest gap."""
    shifts = np.random.default_rng(2).random(2 if quick else 6)
    lattice = [first(box([4.0, low], [8.0, low + 3.0]), 2, low) for low in (0.5, 1.0)]
    anywhere = [first(box([4.0, 0.5 + s], [8.0, 3.0 + s]), 2, 0.5 + s) for s in shifts]
    found = {"a box on the particles' lattice and a wall": lattice,
             "a box anywhere and a wall": anywhere}  # fmt: skip
    for radius in (5.0,) if quick else (5.0, 10.0):
        disks = [_ball(2, radius, s) for s in shifts[:4]]
        found[f"disks, R = {radius:.0f} cells, and a wall"] = disks
    if not quick:
        found["balls, R = 4 cells, and a wall, 3D"] = [_ball(3, 4.0, s) for s in shifts[:2]]
    corners = [_corner(angle, s) for angle in (45.0, 20.0) for s in shifts[:3]]
    found["a square's corner and a wall"] = corners
    return [(what, min(values), max(values)) for what, values in found.items()]


def bar(cell):
    """A bar of a length of 10 hits a wall: rebound, energy lost, time in touch over the exact."""
    solid = {"model": "linear-1d", "young": 100.0, "density": 1.0}
    first_line, last = motion.run(motion.case_of(
        {"a": (box([0.5 * cell], [10.0 + 0.5 * cell]), [-0.05])}, [15.0], cell, 7.0, solid,
        boundaries={"x-min": "unilateral"},
    ))  # fmt: skip
    return (
        -last["momentum-x"] / first_line["momentum-x"],
        1.0 - motion.energy(last) / motion.energy(first_line),
    )


def incline(cell, angle=24.0, friction=0.3):
    """A block slides down a wall: acceleration over the exact one, way sunk in or risen, cells.

    With `friction` enough to stick the first is the way that it slips.
    """
    g, slope = 1.0, motion.slope_of(angle)
    gravity = [g * slope[0], -g * slope[1]]
    case = _on_a_wall(30.0, cell, gravity, {"unilateral": {"friction": friction}})
    (start, begin, end), _, _ = looked(case, (0.0, 1.0, 6.0), a_line)
    sunk = (end["body.block.centre-y"] - start["body.block.centre-y"]) / cell
    exact = g * (slope[0] - friction * slope[1])
    if exact <= 0.0:
        return (end["body.block.centre-x"] - start["body.block.centre-x"]) / cell, sunk
    change = end["momentum-x"] - begin["momentum-x"]
    return change / end["mass"] / (end["time"] - begin["time"]) / exact, sunk


def sticking(cell, angle=24.0, friction=0.6):
    """A block that should stick on a wall: greatest way, in cells, by which it is off a held one.

    The wall that holds does so from the beginning; shear of the block is in both.
    """
    slope = motion.slope_of(angle)
    ramp = {"table": [[0.0, [0.0, 0.0]], [1.0, [slope[0], -slope[1]]]]}
    cases = [
        _on_a_wall(12.0, cell, ramp, condition)
        for condition in ({"unilateral": {"friction": friction}}, "fixed")
    ]
    return motion.apart(cases, np.arange(0.25, 6.001, 0.25)) / cell


def _on_a_wall(length, cell, gravity, condition):
    """A block on the wall y-min."""
    return motion.case_of(
        {"block": (box([2.0, 0.0], [8.0, 2.0]), [0.0, 0.0])}, [length, 5.0], cell, 6.0,
        motion.SOLID | {"young": 1e3}, gravity=gravity, boundaries={"y-min": condition},
    )  # fmt: skip


def cost(dimensions, rounds):
    """Time of a step of a block on a unilateral floor over that on one that holds it."""
    D, cells = dimensions, float(motion.CELLS[dimensions])
    block = box([2.0] * (D - 1) + [0.0], [cells + 2.0] * (D - 1) + [cells])
    cases = [
        motion.case_of({"a": (block, [0.0] * D)}, [cells + 4.0] * D, 1.0, 1e9,
                       boundaries={f"{'xyz'[D - 1]}-min": condition})
        for condition in ("slip", "unilateral")
    ]  # fmt: skip
    return motion.ratio([pgimp.Simulation(case) for case in cases], rounds, 16)


def rigid_cost(dimensions, rounds):
    """Time of a step of a block on a rigid body over that on a floor that holds it."""
    D, cells = dimensions, float(motion.CELLS[dimensions])
    held, lying = (
        motion.case_of(
            {"a": (box([2.0] * (D - 1) + [low], [cells + 2.0] * (D - 1) + [cells + low]),
                   [0.0] * D)},
            [cells + 4.0] * (D - 1) + [cells + 8.0], 1.0, 1e9,
            gravity=[0.0] * (D - 1) + [-0.001],
        )
        for low in (0.0, 4.0)
    )  # fmt: skip
    held["boundaries"] = {f"{'xyz'[D - 1]}-min": "slip"}
    floor = box([-2.0] * D, [cells + 8.0] * (D - 1) + [4.0])
    lying["bodies"]["floor"] = {"rigid": {}, "region": floor}
    lying["contact"] = [{"bodies": "all", "friction": 0.3}]
    return motion.ratio([pgimp.Simulation(held), pgimp.Simulation(lying)], rounds, 16)
