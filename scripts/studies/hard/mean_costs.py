"""What mean dilatation costs, in both configurations: particle-steps a second, in one run.

Run as ``scripts/hard mean-costs``: a block that rings, by every way in turn, and
that over again; medians. Writes the table of docs/hard-cases.md,
scripts/pages/tables/mean-costs.md.
"""

import statistics
import time
from itertools import product
from pathlib import Path

from pgimp.case.schema import Case
from pgimp.mpi.comm import Serial
from pgimp.solver.simulation import Simulation

ROOT = Path(__file__).resolve().parents[3]
CELLS, STEPS, REPEATS = {2: 100, 3: 24}, 40, 9
WAYS = tuple(product(("current", "initial"), ("pointwise", "mean")))


def block(dimensions, configuration, volumetric):
    """Simulation of a free block of `CELLS` cells a side, with two particles a cell and side."""
    n = CELLS[dimensions]
    case = {
        "format": 1,
        "dimensions": dimensions,
        "grid": {"size": [n + 4.0] * dimensions, "cell": [1.0] * dimensions},
        "method": {
            "shape": "gimp", "particles_per_cell": [2] * dimensions, "volumetric": volumetric
        },
        "time": {"end": 1e6, "step": 0.1},
        "materials": {"rubber": {"model": "neo-hookean", "young": 1.0, "poisson": 0.4,
                                 "density": 1.0}},
        "bodies": {"block": {
            "material": "rubber", "configuration": configuration,
            "region": {"box": {"min": [2.3] * dimensions, "max": [2.3 + n] * dimensions}},
            "velocity": [1e-3] + [0.0] * (dimensions - 1),
        }},
    }  # fmt: skip
    return Simulation(Case.model_validate(case), Serial())


def rates(dimensions):
    """Median of the particle-steps a second, by way."""
    every = {way: block(dimensions, *way) for way in WAYS}
    found = {way: [] for way in WAYS}
    for sim in every.values():
        sim.advance()
    for _ in range(REPEATS):
        for way, sim in every.items():
            begin = time.perf_counter()
            for _ in range(STEPS):
                sim.advance()
            seconds = time.perf_counter() - begin
            found[way].append(STEPS * len(sim.live()) / seconds)
    return {way: statistics.median(values) for way, values in found.items()}


def main():
    """Measure, and write the table."""
    lines = [
        "| `volumetric`, `configuration` | 2D, million particle-steps/s | of pointwise "
        "| 3D, million particle-steps/s | of pointwise |",
        "|---|---|---|---|---|",
    ]
    both = [rates(dimensions) for dimensions in (2, 3)]
    for configuration, volumetric in WAYS:
        cells = []
        for found in both:
            rate = found[configuration, volumetric]
            cells += [f"{rate / 1e6:.1f}", f"{rate / found[configuration, 'pointwise']:.2f}"]
        lines.append(f"| {volumetric}, {configuration} | {' | '.join(cells)} |")
    table = ROOT / "scripts" / "pages" / "tables" / "mean-costs.md"
    table.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(table.read_text(encoding="utf-8"), end="")
