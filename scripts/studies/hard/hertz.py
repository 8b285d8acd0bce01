"""Presses an elastic half-cylinder onto a unilateral wall, and compares the contact with Hertz's.

    scripts/hard hertz [--cells 2 4 8] [--shape gimp] [--per-cell 2 4] [--docs]

In 2D the upper face of a half-cylinder of radius R moves slowly towards the wall until the force
per thickness is P = pi E* a^2/(4 R), for which Hertz's line contact has the half-width a and the
greatest pressure p0 = E* a/(2 R), with E* = E/(1 - nu^2) on a rigid wall. Here a = R/10; --cells
gives the cells in a, --per-cell the particles in a cell along each direction. The pressure at a
vertex of the wall is the force that the material exerts on it and on those beyond it, over the
cell. With --docs the table goes into docs/hard-cases.md. 2, 4 and 8 cells take about four minutes
on one core.
"""

import argparse
from math import pi, sqrt
from time import perf_counter

import numpy as np
from studies.harness import origin, put, table
from studies.scenes import ball, box, case_of, core

from pgimp.solver.state.grid_state import active_grid

YOUNG, POISSON, RADIUS = 1.0, 0.3, 1.0
STIFFNESS = YOUNG / (1.0 - POISSON**2)
WIDTH = 0.1 * RADIUS
FORCE = 0.25 * pi * STIFFNESS * WIDTH**2 / RADIUS
#: Of the upper face, in speeds of waves.
SPEED = 1e-3
#: Steps between two looks at the force.
LOOK = 20
#: What counts as contact, of Hertz's greatest pressure.
LEAST = 0.01


def scene(cells, shape, per_cell):
    """The case: R has ten times `cells`, and the lowest point is 1.5 cells above the wall."""
    h = WIDTH / cells
    across = round(RADIUS / h)
    middle, height = (across + 4) * h, 1.5 * h + RADIUS
    top = height - 1.0 * h
    wide = 2.0 * middle
    half = {"intersection": [ball([middle, height], RADIUS), box([0.0, 0.0], [wide, height])]}
    upper = box([0.0, top], [wide, height + h])
    rubber = {"model": "neo-hookean", "young": YOUNG, "poisson": POISSON, "density": 1.0}
    return case_of(
        [wide, (across + 6) * h], h, {"rubber": rubber},
        {"half": {"material": "rubber", "region": half, "surface": "cut-particles"}}, 1.0 / SPEED,
        courant=0.4, per_cell=per_cell, method={"shape": shape},
        boundaries={"y-min": "unilateral"},
        constraints={"top": {"body": "half", "region": upper, "velocity": [0.0, -SPEED]}},
        output={"fields": ["velocity"]},
    )  # fmt: skip


def pressures(sim):
    """Coordinates along the wall, from the middle of the body, and the pressure there."""
    h = sim.scene.domain.frame.cell[0]
    found = active_grid(sim.rank, sim.time)
    wall = found.position[:, 1] < 0.5 * h
    columns, index = np.unique(found.position[wall, 0], return_inverse=True)
    force = np.bincount(index, -found.force[wall, 1])
    return columns - 0.5 * sim.scene.case.grid.size[0], force / h


def pressed(cells, shape, per_cell):
    """Row of the table for a half-width of `cells`."""
    began = perf_counter()
    sim = core(scene(cells, shape, per_cell))
    h = sim.scene.domain.frame.cell[0]
    x, p = pressures(sim)
    while p.sum() * h < FORCE:
        for _ in range(LOOK):
            sim.advance()
        x, p = pressures(sim)
    force = p.sum() * h
    a = sqrt(4.0 * force * RADIUS / (pi * STIFFNESS))
    p0 = 0.5 * STIFFNESS * a / RADIUS
    half = np.abs(x[p > LEAST * p0]).max()
    equal = 2.0 * sqrt((p * x * x).sum() / p.sum())
    print(f"hertz: a = {a / h:.2f} cells, {sim.count} particles, {sim.step} steps, "
          f"{perf_counter() - began:.0f} s; p/p0 from the middle on: "
          + " ".join(f"{v:.2f}" for v in p[x >= -1e-9 * h] / p0), flush=True)  # fmt: skip
    middle = p[np.abs(x).argmin()] / p0
    top = p.argmax()
    return (
        cells, f"{per_cell} x {per_cell}", f"{sim.count:,}", f"{half / a:.2f}", f"{equal / a:.2f}",
        f"{middle:.2f}", f"{p[top] / p0:.2f} at {abs(x[top]) / a:.2f} a",
    )  # fmt: skip


def main():
    parser = argparse.ArgumentParser(
        prog="scripts/hard hertz", description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    parser.add_argument("--cells", type=int, nargs="+", default=[2, 4, 8], help="across a")
    parser.add_argument("--shape", default="gimp")
    parser.add_argument(
        "--per-cell", type=int, nargs="+", default=[2, 4], help="particles, by direction"
    )
    parser.add_argument("--docs", action="store_true", help="write the page too")
    options = parser.parse_args()
    titles = (
        "cells in a", "particles a cell", "particles", "half-width, over a",
        "from the moment, over a", "pressure in the middle, over p0",
        "greatest pressure, over p0",
    )  # fmt: skip
    rows = [
        pressed(cells, options.shape, per_cell)
        for per_cell in options.per_cell
        for cells in options.cells
    ]
    text = table(titles, rows, f"Measured with `{options.shape}` on one core of {origin()}.")
    print(text)
    put({"hertz": text}, page=options.docs)
