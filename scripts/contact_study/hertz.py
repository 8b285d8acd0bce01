"""Hertz's line contact between two soft cylinders: half-width, pressure, and how far they come."""

from math import pi, sqrt

import motion
import numpy as np

import pgimp
from pgimp.solver.gridstate import active_grid

YOUNG, POISSON, RADIUS = 1.0, 0.3, 1.0
#: Of one cylinder; two of them on each other are half as stiff, with half the radius: the contact
#: is as wide as that of one on a rigid plane.
STIFFNESS = YOUNG / (1.0 - POISSON**2)
#: Half-width that is wanted, and the force per thickness that it takes.
WIDTH = 0.1 * RADIUS
FORCE = 0.25 * pi * STIFFNESS * WIDTH**2 / RADIUS
#: Of the cut faces, in speeds of waves; steps between two looks at the force.
SPEED, LOOK = 1e-3, 20


def line(cells, shift=0.3):
    """Two half-cylinders are pressed on each other until the half-width is `cells` cells.

    Their axes are `shift` cells off the vertices, and so is the plane between them. Returns the
    half-width, from the second moment of the pressure, and the greatest pressure, over Hertz's for
    the force that there is. The pressure is that of the forces between the bodies at the vertices,
    over the side of a cell; it is compared with the mean of Hertz's over the weights of a vertex.
    """
    h = WIDTH / cells
    across = round(RADIUS / h) + 4
    middle, plane = (across + shift) * h, (across + 0.5 + shift) * h
    size = [2 * (across + 1) * h] * 2
    case = motion.case_of({}, size, h, 1.0 / SPEED, contact=[{"bodies": ["lower", "upper"]}])
    case["time"]["step"] = {"courant": 0.4}
    case["materials"]["solid"] = {
        "model": "neo-hookean", "young": YOUNG, "poisson": POISSON, "density": 1.0,
    }  # fmt: skip
    case["constraints"] = {}
    for name, side in (("lower", -1.0), ("upper", 1.0)):
        axis = plane + side * RADIUS
        ends = sorted((plane - side * h, axis))
        half = motion.box([0.0, ends[0]], [size[0], ends[1]])
        ball = {"ball": {"centre": [middle, axis], "radius": RADIUS}}
        case["bodies"][name] = {"material": "solid", "region": {"intersection": [ball, half]}}
        ends = sorted((axis - side * h, axis + side * h))
        case["constraints"][name] = {
            "body": name, "velocity": [0.0, -0.5 * side * SPEED],
            "region": motion.box([0.0, ends[0]], [size[0], ends[1]]),
        }  # fmt: skip
    simulation = pgimp.Simulation(case)
    force = 0.0
    while force < FORCE:
        simulation.step(LOOK)
        grid = active_grid(simulation.core.rank, simulation.time, simulation.dt)
        force = -grid.contact[:, 1].sum()
    columns, index = np.unique(np.round(grid.position[:, 0] / h), return_inverse=True)
    pressure = np.bincount(index, -grid.contact[:, 1]) / h
    x = columns * h - middle
    a = sqrt(4.0 * force * RADIUS / (pi * STIFFNESS))
    p0 = 0.5 * STIFFNESS * a / RADIUS
    centre = (pressure @ x) / pressure.sum()
    equal = 2.0 * sqrt((pressure @ (x - centre) ** 2) / pressure.sum())
    return equal / a, pressure.max() / (p0 * _smoothed(x, a, h).max())


def _smoothed(x, a, h):
    """Hertz's pressure over its greatest, as the weights of vertices at x see it."""
    s = (np.arange(400) + 0.5) / 400.0 * 2.0 * h - h
    near = np.abs(x[:, None] + s)
    p = np.sqrt(np.maximum(1.0 - (near / a) ** 2, 0.0))
    return (p * (1.0 - np.abs(s) / h)).sum(axis=1) * (s[1] - s[0]) / h
