"""The cantilever of cases/hard/bending.yaml at several places of its lattice on the grid."""

from studies.hard.rows import deflection
from studies.hard.runs import begin, watch
from studies.harness import table

from pgimp.solver.decomposition import open_window

#: Heights of the lattice above its place in the case, in cells; 1 less them mirror these.
OFFSETS = (0.0, 0.13, 0.29, 0.5)
#: Poisson's ratio and cells over the height.
KINDS = ((0.3, 8), (0.499, 4), (0.499, 8), (0.4999, 8))
_MEAN = {"method.volumetric": "b-bar"}
_INITIAL = {"bodies.beam.formulation": "initial"}
METHODS = {
    "gimp": {"method.shape": "gimp"},
    "gimp, mean": {"method.shape": "gimp"} | _MEAN,
    "gimp, mean, affine": {"method.shape": "gimp", "method.affine": True} | _MEAN,
    "finite-gimp, mean": {"method.shape": "finite-gimp"} | _MEAN,
    "gimp, initial": {"method.shape": "gimp"} | _INITIAL,
    "gimp, mean, initial": {"method.shape": "gimp"} | _MEAN | _INITIAL,
}


def locked(method, poisson, cells, offset):
    """Record of one run: its deflection over that of finite elements, less 1; None if it failed."""
    cell = 1.0 / cells
    changes = {"materials.rubber.poisson": poisson, "grid.cell": [cell, cell]}
    sim = begin("bending", METHODS[method] | changes | {"time.step.courant": 0.3})
    p, rows = sim.particles, sim.live()
    for place in (p.x, p.origin):
        place[rows, 1] += offset * cell
    sim.population.sort()
    open_window(sim.rank, sim.reduction)  # in the initial configuration it has no room to spare
    run = watch(sim)
    found, exact = deflection(run, 1.0 + offset * cell)
    return {
        "method": method, "poisson": poisson, "cells": cells, "offset": offset,
        "error": found / exact - 1.0 if run.stable else None, "growth": run.growth,
        "fault": run.fault, "steps": run.sim.step, "seconds": run.seconds,
    }  # fmt: skip


def locking_table(records):
    """Least and greatest error over the offsets, by method; columns are materials and cells."""
    titles = [f"{poisson:g}, {cells} cells" for poisson, cells in KINDS]
    lines = []
    for method in METHODS:
        cells = []
        for kind in KINDS:
            found = [
                record["error"] for record in records
                if (record["method"], record["poisson"], record["cells"]) == (method, *kind)
            ]  # fmt: skip
            text = ""
            if None in found:
                text = "**unstable**"
            elif found:
                text = f"{100.0 * min(found):+.1f} to {100.0 * max(found):+.1f}"
            cells.append(text)
        lines.append((method, *cells))
    return table(("method", *titles), lines)
