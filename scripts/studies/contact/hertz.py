"""Hertz's contact of two bodies that both give way: cylinders pressed slowly, balls that meet.

Planes of symmetry, `slip` faces, cut both. Of equal bodies each is pressed as on a rigid wall.
"""

from math import pi, sqrt

import numpy as np
from ruamel.yaml import YAML
from studies.contact import motion
from studies.contact.problems import impact
from studies.harness import CASES
from studies.scenes import ball, box

import pgimp
from pgimp.solver.state.grid_state import active_grid

YOUNG, POISSON = 1.0, 0.3
STIFFNESS = YOUNG / (1.0 - POISSON**2)
#: Radius of cylinders and the half-width of their contact, in which it is as wide as it gets.
RADIUS, WIDTH = 1.0, 0.1
#: Of each cylinder's flat face, in speeds of waves.
SPEED = 1e-3


def _columns(simulation, across):
    """Places across the normal, which is the last axis, and the force of contact there."""
    core = simulation.core
    found = active_grid(core.rank, simulation.time, simulation.dt)
    places, index = np.unique(found.position[:, :across], axis=0, return_inverse=True)
    return places, np.bincount(index.reshape(-1), np.abs(found.contact[:, across]))


def cylinders(cells):
    """Half-width over Hertz's, by the second moment of the pressure, and pressures over p0.

    Two half-cylinders, of which a plane of symmetry leaves halves, with `cells` in the half-width;
    the pressures are that in the middle, and the greatest.
    """
    h = WIDTH / cells
    across = round(RADIUS / h)
    size = [(across + 4) * h, 2.0 * (across + 3) * h]
    middle, gap = 0.5 * size[1] + 0.3 * h, 0.5 * h
    bodies, constraints = {}, {}
    for name, side in (("low", -1.0), ("high", 1.0)):
        centre = middle + side * (RADIUS + 0.5 * gap)
        ends = sorted((middle, centre))
        half = [ball([0.0, centre], RADIUS), box([0.0, ends[0]], [size[0], ends[1]])]
        bodies[name] = ({"intersection": half}, [0.0, 0.0])
        ends = sorted((centre - side * h, centre + side * h))
        face = box([0.0, ends[0]], [size[0], ends[1]])
        constraints[name] = {"body": name, "region": face, "velocity": [0.0, -side * SPEED]}
    case = motion.case_of(
        bodies, size, h, 1.0 / SPEED, motion.SOLID | {"young": YOUNG, "poisson": POISSON},
        constraints=constraints, boundaries={"x-min": "slip"}, courant=0.4,
        contact=[{"bodies": ["low", "high"]}],
    )  # fmt: skip
    force = 0.25 * pi * STIFFNESS * WIDTH**2 / RADIUS
    simulation, pushed = pgimp.Simulation(case), 0.0
    while pushed < 0.5 * force:  # of the half
        simulation.step(20)
        pushed = abs(simulation.diagnostics()["contact.low+high-y"])
    places, found = _columns(simulation, 1)
    x = places[:, 0]
    pressure = found / (h * np.where(x < 0.5 * h, 0.5, 1.0))
    a = sqrt(8.0 * found.sum() * RADIUS / (pi * STIFFNESS))
    p0 = 0.5 * STIFFNESS * a / RADIUS
    width = 2.0 * sqrt((found * x * x).sum() / found.sum())
    return width / a, pressure[np.abs(x).argmin()] / p0, pressure.max() / p0


def balls(cell):
    """Two of the balls of cases/hertz.yaml meet, on a quarter of them; all over Hertz's.

    Time from one per cent of the greatest force to one per cent, greatest force, the circle's
    radius by the second moment of the pressure, pressure in its middle, and the energy lost.
    """
    force, radius, top, greatest = 72.276, 0.1, 119.1e3, 0.01702
    case = YAML(typ="safe").load(CASES / "hertz.yaml")
    del case["boundaries"]["z-min"], case["output"]
    case["grid"]["cell"] = [cell] * 3
    side, (middle, gap) = 0.12, (0.24, 0.01)
    case["grid"]["size"] = [side, side, 2.0 * middle]
    case["bodies"] = {
        name: {
            "material": "rubber", "velocity": [0.0, 0.0, -0.2 * way],
            "region": {"intersection": [
                ball([0.0, 0.0, middle + way * (radius + 0.5 * gap)], radius),
                box([0.0, 0.0, 0.0], case["grid"]["size"]),
            ]},
        } for name, way in (("low", -1.0), ("high", 1.0))
    }  # fmt: skip
    case["contact"] = [{"bodies": ["low", "high"]}]
    simulation = pgimp.Simulation(case)
    first, lines, most, pressed = simulation.diagnostics(), [], 0.0, None
    while not simulation.finished:
        simulation.step()
        lines.append(simulation.diagnostics())
        push = 4.0 * abs(lines[-1]["contact.low+high-z"]) / force
        if push > most:
            most = push
            if push > 0.9:
                pressed = _columns(simulation, 2)
    span, most, lost = impact(first, lines, "contact.low+high-z")
    places, found = pressed
    wide = sqrt(2.5 * (found * (places**2).sum(axis=1)).sum() / found.sum())
    middle = found[(places**2).sum(axis=1).argmin()] / (0.25 * cell**2)
    return span, most, wide / greatest, middle / top, lost
