"""The scenes of scripts/methods: small bodies of one elastic material, on one rank.

Young's modulus, density and cells are 1. Poisson's ratio is 0 but for the bounce, so that the wave
speed is 1 and times are in cells; then beams in 2D and 3D swing alike, and therefore lie on the
grid in 2D and `OFF` it in 3D. All scenes of a dimension have walls of the same kinds, so that they
share their compiled kernels.
"""

from math import pi, sin
from typing import NamedTuple

import numpy as np
from studies.method.timoshenko import slowest
from studies.scenes import by_id, case_of, core, filled, throw

SHAPES = (
    "mpm", "gimp", "finite-gimp", "cpdi", "fuzzy-nearest", "fuzzy-constant",
    "bspline-quadratic", "bspline-cubic",
)  # fmt: skip


class Method(NamedTuple):
    """A shape, with `affine` or not, particles a cell and direction, and the configuration."""

    shape: str
    affine: bool = False
    per_cell: int = 2
    configuration: str = "current"


HEIGHT = 4  # cells across every body
OFF = 0.3  # of a cell, by direction
#: Height and weight of the column; its lowest part is compressed by 16 %, see `column`.
COLUMN, STRAIN = 10.0, 0.16
WEIGHT = 0.5 * (1.0 / (1.0 - STRAIN) - (1.0 - STRAIN))
RAMP = 480.0  # in which the weight grows: twelve times the column's slowest period


def simulation(method, size, body, end, courant=0.3, cell=1.0, poisson=0.0, **changes):
    """A body in a domain with a wall at x-min and one at y-min, from which it can come off.

    The body has its region, and velocity if any; changes are other keys of the case.
    """
    shape, affine, per_cell, configuration = Method(*method)
    body = {"material": "elastic", "formulation": configuration} | body
    elastic = {"model": "neo-hookean", "young": 1.0, "poisson": poisson, "density": 1.0}
    return core(case_of(
        size, cell, {"elastic": elastic}, {"body": body}, end, courant=courant, per_cell=per_cell,
        method={"shape": shape, "affine": affine},
        **({"boundaries": {"x-min": "fixed", "y-min": "unilateral"}} | changes),
    ))  # fmt: skip


def cantilever(method, D, courant=0.3, length=6 * HEIGHT, amplitude=0.2):
    """A beam that begins to swing in its slowest mode.

    With the deflection of the mode at each particle, by id, and its exact angular frequency.
    """
    rate, nodes, deflection, rotation = slowest(length, HEIGHT)
    low = 4.0 if D == 2 else 4.0 + OFF
    body = filled([0.0, low, low][:D], [length, low + HEIGHT, low + HEIGHT][:D])
    sim = simulation(method, [length + 4, 13, 13][:D], body, 3.6 * pi / rate, courant)
    p, rows = sim.particles, sim.live()
    x, y = p.x[rows, 0], p.x[rows, 1] - (low + 0.5 * HEIGHT)
    shape, turn = np.interp(x, nodes, deflection), np.interp(x, nodes, rotation)
    v, L = np.zeros((len(rows), D)), np.zeros((len(rows), D, D))
    v[:, 1] = amplitude * rate * shape
    v[:, 0] = -amplitude * rate * turn * y
    L[:, 1, 0] = amplitude * rate * np.interp(x, nodes, np.gradient(deflection, nodes))
    L[:, 0, 1] = -amplitude * rate * turn
    L[:, 0, 0] = -amplitude * rate * y * np.interp(x, nodes, np.gradient(rotation, nodes))
    throw(sim, v, L)
    return sim, by_id(sim, shape), rate


def wave(method, courant=0.3, cells=10, waves=2, amplitude=1e-3):
    """A standing wave between two walls, in 2D; as `cantilever`."""
    length, k = cells * waves, 2.0 * pi / cells
    walls = {"x-min": "fixed", "x-max": "fixed", "y-min": "unilateral"}
    body = filled([0, 4], [length, 4 + HEIGHT])
    sim = simulation(method, [length, 12], body, 6.0 * cells, courant, boundaries=walls)
    p, rows = sim.particles, sim.live()
    shape = np.sin(k * p.x[rows, 0])
    v, L = np.zeros((len(rows), 2)), np.zeros((len(rows), 2, 2))
    v[:, 0] = amplitude * shape
    L[:, 0, 0] = amplitude * k * np.cos(k * p.x[rows, 0])
    throw(sim, v, L)
    return sim, by_id(sim, shape), k


def bounce(method, D, speed=0.1):
    """A block with Poisson's ratio 0.3 that flies at the wall y-min from 2.5 cells above."""
    low = [4.0 + OFF, 2.5, 4.0 + OFF][:D]
    body = filled(low, [x + HEIGHT for x in low]) | {"velocity": [0.0, -speed, 0.0][:D]}
    return simulation(method, [13, 16, 13][:D], body, 300.0, poisson=0.3)


def spin(method, D, courant=0.3, edge_speed=0.05):
    """A block that turns once, in 3D about (1, 2, 3)."""
    rate = edge_speed / (0.5 * HEIGHT)
    axis = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
    turn = {"about": [6.0] * D, "rate": rate if D == 2 else (rate * axis).tolist()}
    body = filled([4.0] * D, [8.0] * D) | {"velocity": {"rotation": turn}}
    return simulation(method, [12] * D, body, 2.0 * pi / rate, courant)


def column(method, cell):
    """A column under a weight that grows smoothly and then stays, in 2D; the stress at rest, by id.

    With nominal stress (F - 1/F)/2 the stress is -WEIGHT (1 - X/COLUMN) at rest, whatever F.
    """
    rows = [[RAMP * s, [0.0, -WEIGHT / COLUMN * (s - sin(2.0 * pi * s) / (2.0 * pi))]]
            for s in np.linspace(0.0, 1.0, 41).tolist()]  # fmt: skip
    width = 2 * cell
    sim = simulation(
        method, [width, COLUMN + 2.0], filled([0, 0], [width, COLUMN]), RAMP + 40.0, cell=cell,
        gravity={"table": rows}, boundaries={wall: "slip" for wall in ("x-min", "x-max", "y-min")},
    )  # fmt: skip
    exact = -WEIGHT * (1.0 - sim.particles.x[sim.live(), 1] / COLUMN)
    return sim, by_id(sim, exact)


def large(method, D):
    """A large block that drifts, to take the time of."""
    n = 64 if D == 2 else 18
    body = filled([4.0] * D, [4.0 + n] * D) | {"velocity": [0.01] * D}
    return simulation(method, [n + 8] * D, body, 1e4)
