"""Measures scenes in plane stress against exact results, and their cost; see scripts/plates."""

from time import process_time

import numpy as np
from studies.harness import origin, table
from studies.scenes import box, by_turns, case_of

import pgimp

#: Young's modulus, Poisson's ratio and the speed of waves in a plate, sqrt(E/(rho (1 - nu^2))).
YOUNG, POISSON = 1.0, 0.3
SPEED = (YOUNG / (1.0 - POISSON**2)) ** 0.5
#: Length of a bar, and its weight.
LENGTH, GRAVITY = 10.0, 1e-6
#: Rounds and steps of the comparison by turns.
ROUNDS, STEPS = 15, 20


def bar(cells, configuration):
    """Way of a bar's centre after half a period, over the exact one, and seconds.

    It hangs between slip walls, and its weight sets in at once. When the wave has come back, after
    2 L/c, its centre has gone 2 g L^2/(3 c^2), twice what it does at rest.
    """
    cell = LENGTH / cells
    high = 4.0 * cell
    case = case_of(
        [LENGTH + 2.0 * cell, high], cell,
        {"m": {"model": "hooke", "young": YOUNG, "poisson": POISSON, "density": 1.0}},
        {"b": {"material": "m", "formulation": configuration,
               "region": box([0.0, 0.0], [LENGTH, high])}},
        2.0 * LENGTH / SPEED, geometry="plane-stress", gravity=[GRAVITY, 0.0],
        boundaries={"x-min": "slip", "y-min": "slip", "y-max": "slip"},
        method={"affine": configuration == "current"},
    )  # fmt: skip
    sim = pgimp.Simulation(case)
    sim.step()
    began = process_time()
    sim.advance()
    seconds = process_time() - began
    way = (sim.diagnostics() or {})["body.b.centre-x"] - 0.5 * LENGTH
    return way / (2.0 * GRAVITY * LENGTH**2 / (3.0 * SPEED**2)), seconds


def block(geometry, law):
    """A plate of 25,600 particles that turns."""
    materials = {"m": {"young": 1.0, "poisson": 0.3, "density": 1.0} | law}
    body = {"material": "m", "velocity": {"rotation": {"about": [45.0, 45.0], "rate": 1e-4}},
            "region": {"box": {"min": [5.0, 5.0], "max": [85.0, 85.0]}}}  # fmt: skip
    return pgimp.Simulation(case_of([90.0, 90.0], 1.0, materials, {"b": body}, 1e6,
                                    geometry=geometry))  # fmt: skip


def cost(law):
    """Time of a step over that of plane strain, by turns."""
    sims = [block(geometry, law) for geometry in ("plane-strain", "plane-stress")]
    for sim in sims:
        sim.step(STEPS)
    strain, stress = by_turns(sims, ROUNDS, STEPS).T
    return np.median(stress / strain)


def main():
    """Print all figures."""
    print(f"Measured on one core of {origin()}.\n")
    rows = [
        [f"{cells} cells, `{configuration}`", f"{way - 1.0:+.2%}", f"{seconds:.2f} s"]
        for configuration in ("current", "initial")
        for cells in (10, 20, 40)
        for way, seconds in [bar(cells, configuration)]
    ]
    print(table(["bar whose weight sets in", "way of its centre when it turns", "time"], rows))
    laws = {
        "hooke": {"model": "hooke"},
        "neo-hookean": {"model": "neo-hookean"},
        "von-mises": {"model": "von-mises", "yield-stress": 0.01},
    }
    for name, law in laws.items():
        print(f"{name}: {cost(law):.2f} of plane strain")
