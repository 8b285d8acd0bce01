"""The force of a steady jet on a plate, cases/jet.yaml, by the size of cells."""

from time import process_time

import numpy as np
from studies.harness import CASES
from studies.scenes import a_line

import pgimp

#: Density, area, and velocity squared, of half the jet; the flow is steady from `STEADY` on.
FORCE, STEADY, EVERY = 1000.0 * 0.05 * 2.0**2, 0.3, 0.005


def plate(cell):
    """Cells of the table: mean force, its standard deviation, steps, particles, time."""
    sim = pgimp.Simulation(CASES / "jet.yaml", overrides={"grid.cell": [cell, cell]})
    sim.step()
    began, found = process_time(), []
    for i in range(1, round(1.0 / EVERY) + 1):
        sim.advance(i * EVERY)
        line = a_line(sim)  # its force is the mean since the line before
        if i * EVERY > STEADY:
            found.append(line["reaction.y-min-y"])
    seconds, mean = process_time() - began, abs(np.mean(found))
    return (
        f"{mean:.1f} N ({mean / FORCE - 1.0:+.2%})", f"{np.std(found):.0f} N", f"{sim.steps:,}",
        f"{len(sim.particles['id']):,}", f"{seconds:.0f} s",
    )  # fmt: skip
