"""What mean dilatation costs, in both configurations: particle-steps a second, in one run.

Run as ``scripts/hard mean-costs``: a block that rings, by every way in turn, and
that over again; medians. Writes the table of docs/hard-cases.md,
scripts/pages/tables/mean-costs.md.
"""

from itertools import product
from time import perf_counter

import numpy as np
from studies.harness import Table, put
from studies.scenes import by_turns, case_of, core, filled

CELLS, STEPS, REPEATS = {2: 100, 3: 24}, 40, 9
WAYS = tuple(product(("current", "initial"), ("pointwise", "mean")))


def block(dimensions, configuration, volumetric):
    """Simulation of a free block of `CELLS` cells a side, with two particles a cell and side."""
    n = CELLS[dimensions]
    rubber = {"model": "neo-hookean", "young": 1.0, "poisson": 0.4, "density": 1.0}
    body = {
        "material": "rubber", "formulation": configuration,
        "velocity": [1e-3] + [0.0] * (dimensions - 1),
    }  # fmt: skip
    body |= filled([2.3] * dimensions, [2.3 + n] * dimensions)
    return core(case_of(
        [n + 4.0] * dimensions, 1.0, {"rubber": rubber}, {"block": body}, 1e6,
        method={"volumetric": volumetric}, time={"step": 0.1},
    ))  # fmt: skip


def rates(dimensions):
    """Median of the particle-steps a second, by way."""
    every = [block(dimensions, *way) for way in WAYS]
    for sim in every:
        sim.advance()
    speeds = every[0].count / by_turns(every, REPEATS, STEPS, perf_counter)
    return dict(zip(WAYS, np.median(speeds, axis=0), strict=True))


def main():
    table = Table(
        "`volumetric`, `formulation`", "2D, million particle-steps/s", "of pointwise",
        "3D, million particle-steps/s", "of pointwise",
    )  # fmt: skip
    both = [rates(dimensions) for dimensions in (2, 3)]
    for configuration, volumetric in WAYS:
        cells = []
        for found in both:
            rate = found[configuration, volumetric]
            cells += [f"{rate / 1e6:.1f}", f"{rate / found[configuration, 'pointwise']:.2f}"]
        table.add(f"{volumetric}, {configuration}", *cells)
    put({"mean-costs": table.text()})
