"""How bodies that meet move: against exact solutions, on cells of one size and of half of it."""

from math import cos, radians, sin
from statistics import median
from time import perf_counter

import numpy as np

import pgimp

SOLID = {"model": "neo-hookean", "young": 100.0, "poisson": 0.3, "density": 1.0}


def _case(bodies, size, cell, end, **parts):
    """A case of soft bodies."""
    D = len(size)
    return {
        "format": 1,
        "dimensions": D,
        "grid": {"size": size, "cell": [cell] * D},
        "method": {"shape": "gimp", "particles_per_cell": [2] * D},
        "time": {"end": end, "step": {"courant": 0.3}},
        "materials": {"solid": SOLID},
        "bodies": {
            name: {"material": "solid", "region": region, "velocity": velocity}
            for name, (region, velocity) in bodies.items()
        },
    } | parts


def _box(low, high):
    return {"box": {"min": low, "max": high}}


def _run(case):
    """First and last line of the history."""
    simulation = pgimp.Simulation(case)
    first = simulation.diagnostics()
    simulation.advance()
    return first, simulation.diagnostics()


def _energy(line):
    return line["kinetic-energy"] + line["strain-energy"]


def bars(cell):
    """Two bars meet head on: the rebound over the speed before, and the energy lost."""
    bodies = {
        "a": (_box([2.0], [12.0]), [0.05]),
        "b": (_box([12.0 + cell], [22.0 + cell]), [-0.05]),
    }
    case = _case(bodies, [25.0], cell, 4.0, contact=[{"bodies": "all"}])
    case["materials"]["solid"] = {"model": "linear-1d", "young": 100.0, "density": 1.0}
    first, last = _run(case)
    return (
        -last["body.a.momentum-x"] / first["body.a.momentum-x"],
        1.0 - _energy(last) / _energy(first),
    )


def disks(cell):
    """Sulsky's disks: energy lost when they have parted."""
    with open(ROOT / "cases" / "disks.yaml", encoding="utf-8") as file:
        case = pgimp.load(file.name, {"contact": [{"bodies": "all"}], "grid.cell": [cell, cell]})
    first, last = _run(case)
    return 1.0 - _energy(last) / _energy(first)


def edges(cell):
    """Blocks pressed together slide past each other without friction: change of their momentum."""
    bodies = {
        "a": (_box([2.0, 2.0], [5.0, 5.0]), [0.5, 1.0]),
        "b": (_box([5.0, 2.0], [8.0, 5.0]), [-0.5, -1.0]),
    }
    first, last = _run(_case(bodies, [14.0, 8.0], cell, 1.2, contact=[{"bodies": "all"}]))
    return abs(last["body.a.momentum-y"] / first["body.a.momentum-y"] - 1.0)
