"""Problems that other codes are verified with: rods, blocks with friction, a corner, disks."""

from itertools import combinations
from math import cos, radians, sin, sqrt

import numpy as np
from studies.contact import motion
from studies.harness import CASES
from studies.scenes import a_line, ball, box, history, looked

import pgimp


def rods(cells):
    """VM265: rods meet; errors of the instants at which they touch and part, and the rebound.

    The errors are over the time between.
    Each is 10 inches long, and they come at 202.2 inches a second from 0.01 inch on both sides of
    a plane, which is a rigid wall for each. They press on each other with rho c V until the waves
    come back from their ends, after 2 L/c; the instants are those at half of that.
    """
    young, density, speed, gap, length = 3.0e7, 0.73, 202.2, 0.01, 10.0
    wave, cell = sqrt(young / density), length / cells
    middle = 1.2 * length
    bodies = {
        "a": (box([middle - gap - length], [middle - gap]), [speed]),
        "b": (box([middle + gap], [middle + gap + length]), [-speed]),
    }
    touch, apart = gap / speed, gap / speed + 2.0 * length / wave
    simulation = pgimp.Simulation(motion.case_of(
        bodies, [2.4 * length], cell, 1.2 * apart, contact=[{"bodies": ["a", "b"]}],
        solid={"model": "linear-1d", "young": young, "density": density},
    ))  # fmt: skip
    first, lines = simulation.diagnostics(), history(simulation)
    time = np.array([line["time"] for line in lines])
    force = -np.array([line["contact.a+b-x"] for line in lines])
    pressed = np.flatnonzero(force > 0.5 * density * wave * speed)
    found = 0.5 * (time[pressed[0]] + time[pressed[0] - 1]), time[pressed[-1]]
    rebound = -lines[-1]["body.a.momentum-x"] / first["body.a.momentum-x"]
    scale = apart - touch
    return (found[0] - touch) / scale, (found[1] - apart) / scale, rebound


def friction_block(cell):
    """Uintah's friction block: acceleration over the exact one, friction over Coulomb's.

    A block of 40 x 15 x 5 mm on a plane of the same material, pressed from above and from the left
    with 35.293 N each, within 0.1 ms; friction 0.5. In mm, ms and g: forces are in N. The velocity
    is fitted by a line from 0.15 to 1 ms, as the block vibrates on the plane.
    """
    load, friction, thickness, mass, ramp = 35.293, 0.5, 5.0, 3.0, 0.1
    bulk, shear = 2451.0, 939.8
    young = 9.0 * bulk * shear / (3.0 * bulk + shear)
    low, high = [10.0, 10.0], [50.0, 25.0]
    bodies = {
        "plane": (box([0.0, 0.0], [65.0, 10.0]), [0.0, 0.0]),
        "block": (box(low, high), [0.0, 0.0]),
    }

    def pressed(face, length):
        rows = [[0.0, 0.0], [ramp, load / (thickness * length)]]
        return {"body": "block", "face": face, "pressure": {"table": rows}}

    solid = {
        "model": "neo-hookean", "young": young, "density": 1.0e-3,
        "poisson": (3.0 * bulk - 2.0 * shear) / (6.0 * bulk + 2.0 * shear),
    }  # fmt: skip
    case = motion.case_of(
        bodies, [65.0, 30.0], cell, 1.0, solid,
        boundaries={"y-min": "fixed", "x-min": "slip", "x-max": "slip"},
        contact=[{"bodies": ["plane", "block"], "friction": friction}],
        tractions={"top": pressed("y-max", 40.0), "left": pressed("x-min", 15.0)},
    )  # fmt: skip
    lines, _, _ = looked(case, np.arange(0.15, 1.0001, 0.01), a_line)
    rows = [(line["time"], line["body.block.momentum-x"] * thickness / mass) for line in lines]
    line = lines[-1]
    acceleration = np.polyfit(*np.transpose(rows), 1)[0]
    law = line["contact.plane+block.tangential-impulse"] / friction
    exact = load * (1.0 - friction) / mass
    return acceleration / exact, law / line["contact.plane+block.normal-impulse"]


def corner(cell):
    """Three blocks in a corner: greatest error of four forces, and what momentum is off by.

    One lies in the corner, one beside it on the floor, one on it at the wall, and gravity points
    into the corner: the forces of wall and floor and between blocks follow from their weights.
    The first error is over the weight of a block, the second over the impulse of all weights.
    """
    g, side, ramp = (sin(radians(25.0)), cos(radians(25.0))), 2.0, 4.0
    bodies = {
        "inner": (box([0.0, 0.0], [side, side]), [0.0, 0.0]),
        "beside": (box([side, 0.0], [2.0 * side, side]), [0.0, 0.0]),
        "above": (box([0.0, side], [side, 2.0 * side]), [0.0, 0.0]),
    }
    case = motion.case_of(
        bodies, [6.0, 6.0], cell, 12.0, motion.SOLID | {"young": 1e3}, method={"pic-damping": 1.0},
        gravity={"table": [[0.0, [0.0, 0.0]], [ramp, [-a for a in g]]]},
        boundaries={"x-min": "unilateral", "y-min": "unilateral"},
        contact=[{"bodies": [*pair]} for pair in combinations(bodies, 2)],
    )  # fmt: skip
    simulation = pgimp.Simulation(case)
    simulation.advance(ramp + 0.1)
    lines, impulse = [simulation.diagnostics()], np.zeros(2)
    while not simulation.finished:
        simulation.advance(min(simulation.time + 0.05, 12.0))
        lines.append(simulation.diagnostics())
        time = lines[-1]["time"] - lines[-2]["time"]
        impulse += [
            time * (lines[-1][f"reaction.x-min-{a}"] + lines[-1][f"reaction.y-min-{a}"])
            for a in "xy"
        ]
    mass, late = lines[0]["body.inner.mass"], [line for line in lines if line["time"] > 10.0]
    forces = {
        "reaction.x-min-x": 3.0 * g[0], "reaction.y-min-y": 3.0 * g[1],
        "contact.inner+beside-x": -g[0], "contact.inner+above-y": -g[1],
    }  # fmt: skip
    found = {name: np.mean([line[name] for line in late]) / mass for name in forces}
    weights = -3.0 * mass * np.array(g) * (lines[-1]["time"] - lines[0]["time"])
    gained = [lines[-1][f"momentum-{a}"] - lines[0][f"momentum-{a}"] for a in "xy"]
    return (
        max(abs(found[name] - force) for name, force in forces.items()),
        np.abs(np.array(gained) - weights - impulse).max() / np.abs(weights).max(),
    )


def disks(cell):
    """NairnMPM's two disks of 20 mm, closing at 1 % of the wave speed: part of the energy lost."""
    young, poisson, density, radius = 1000.0, 0.33, 1.5, 10.0
    wave = sqrt(young * (1.0 - poisson) / (1.0 + poisson) / (1.0 - 2.0 * poisson) / density)
    speed = 0.005 * wave
    centre = 12.0 + np.array([0.0, 2.0 * radius + 1.0 * cell])
    bodies = {
        name: (ball([x, 12.0], radius), [v, 0.0])
        for name, x, v in zip("ab", centre.tolist(), (speed, -speed), strict=True)
    }
    end = (0.5 * cell + 2.0) / speed
    solid = {"model": "neo-hookean", "young": young, "poisson": poisson, "density": density}
    case = motion.case_of(bodies, [46.0, 24.0], cell, end, solid, contact=[{"bodies": "all"}])
    first, last = motion.run(case)
    return 1.0 - motion.energy(last) / motion.energy(first), (
        -last["body.a.momentum-x"] / first["body.a.momentum-x"]
    )


def rubber_ball(cell):
    """cases/hertz.yaml: time on the wall and greatest force over Hertz's, and the energy lost.

    The time is that from one per cent of the greatest force to one per cent of it.
    """
    simulation = pgimp.Simulation(CASES / "hertz.yaml", overrides={"grid.cell": [cell] * 3})
    return impact(simulation.diagnostics(), history(simulation), "reaction.z-min-z")


def impact(first, lines, name):
    """Of a quarter of a ball of cases/hertz.yaml whose force is in a column; see `rubber_ball`."""
    force, span = 72.276, 0.041312
    time = np.array([line["time"] - 0.5 * line["dt"] for line in lines])
    push = 4.0 * np.abs([line[name] for line in lines]) / force
    on = np.flatnonzero(push > 0.01)
    begin = np.interp(0.01, push[on[0] - 1 : on[0] + 1], time[on[0] - 1 : on[0] + 1])
    end = np.interp(-0.01, -push[on[-1] : on[-1] + 2], time[on[-1] : on[-1] + 2])
    lost = 1.0 - motion.energy(lines[-1]) / motion.energy(first)
    return (end - begin) / span, push.max(), lost


def pressed(cell):
    """A block pressed flat between rigid bodies without friction: force over the exact one.

    32 x 20 cells of size 1, by 30 % of its height, while waves cross it fifty times. Strains are
    homogeneous: the stress along the bodies is zero.
    """
    size, young, nu = (32.0, 20.0), motion.SOLID["young"], motion.SOLID["poisson"]
    shear, lame = young / (2.0 * (1.0 + nu)), young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
    wave = sqrt((lame + 2.0 * shear) / motion.SOLID["density"])
    end = 50.0 * size[1] / wave
    low = [16.0, 5.5]
    top = low[1] + size[1]
    steps = np.linspace(0.0, 1.0, 101)
    speed = 0.3 * size[1] * 0.5 * np.pi * np.sin(np.pi * steps) / (0.8 * end)
    table = [[0.8 * end * s, [0.0, -v]] for s, v in zip(steps, speed, strict=True)]
    bodies = {"block": (box(low, [low[0] + size[0], top]), [0.0, 0.0])}
    case = motion.case_of(bodies, [64.0, 32.0], cell, end, contact=[{"bodies": "all"}])
    rigid = {"punch": (top, top + 4.0, {"velocity": {"table": table}}), "die": (1.0, low[1], {})}
    for name, (y0, y1, how) in rigid.items():
        case["bodies"][name] = {"rigid": how, "region": box([-8.0, y0], [72.0, y1])}
    simulation = pgimp.Simulation(case)
    force = []
    while not simulation.finished:
        simulation.step(1)
        if simulation.time > 0.85 * end:
            force.append(simulation.diagnostics()["rigid.punch.force-y"])
    widths = np.linspace(1.0, 1.5, 100001)
    across = shear * (widths - 1.0 / widths) + lame * np.log(0.7 * widths) / widths
    along = np.interp(0.0, across, widths)
    stress = shear * (0.7 - 1 / 0.7) + lame * np.log(0.7 * along) / 0.7
    return np.mean(force) / (-stress * size[0])
