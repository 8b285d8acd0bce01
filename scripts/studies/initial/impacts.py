"""Impacts in both configurations, with and without artificial viscosity, against exact waves."""

from time import process_time

import numpy as np
from studies.harness import table
from studies.scenes import case_of, core, filled, finished

#: Speed at which a bar of length 1 hits, over its speed of waves, which is 1.
SPEED = 0.01
#: Linear and quadratic coefficients of artificial viscosity.
VISCOSITIES = ((0.0, 0.0), (0.1, 0.0), (0.2, 0.0), (0.2, 2.0), (0.5, 0.0))
#: Cells of the bar.
CELLS = (50, 100, 200)
#: Times a wave's way through a bar: of the wave that is looked at, and until bars have parted.
FRONT, PARTED = 0.7, 2.5
CONFIGURATIONS = ("current", "initial")


def _bars(starts, configuration, viscosity, cells, end, **parts):
    """Bars of length 1 at some places, each with its velocity."""
    law = {"model": "linear-1d", "young": 1.0, "density": 1.0}
    if any(viscosity):
        law["viscosity"] = dict(zip(("linear", "quadratic"), viscosity, strict=True))
    bodies = {
        f"bar{n}": {"material": "bar", "formulation": configuration, "velocity": [v]}
        | filled([a], [a + 1.0])
        for n, (a, v) in enumerate(starts)
    }
    return core(case_of([3.0], 1.0 / cells, {"bar": law}, bodies, end, **parts))


def front(configuration, viscosity, cells):
    """Stress behind the front of a wave from a wall, over its exact height: error and overshoot.

    The error is a mean over the bar. It comes with the CPU seconds of the run.
    """
    sim = _bars([(0.0, -SPEED)], configuration, viscosity, cells, FRONT,
                boundaries={"x-min": "fixed"})  # fmt: skip
    began = process_time()
    finished(sim)
    spent = process_time() - began
    p, rows = sim.particles, sim.live()
    stress = p.sigma[rows, 0] / SPEED
    error = np.abs(stress + (p.x[rows, 0] < sim.time)).mean()
    return {"error": float(error), "overshoot": float(-stress.min() - 1.0), "seconds": spent}


def rebound(configuration, viscosity, cells):
    """Speed at which two equal bars part over the speed at which they met; energy lost."""
    sim = _bars([(0.5, SPEED), (1.5, -SPEED)], configuration, viscosity, cells, PARTED,
                contact=[{"bodies": "all"}])  # fmt: skip
    before = sim.diagnostics()["kinetic-energy"]
    finished(sim)
    p, rows = sim.particles, sim.live()
    first = p.body[rows] == 0
    v = p.v[rows, 0]
    line = sim.diagnostics()
    return {
        "restitution": float((v[~first].mean() - v[first].mean()) / (2.0 * SPEED)),
        "lost": 1.0 - (line["kinetic-energy"] + line["strain-energy"]) / before,
    }


def impact(configuration, linear, quadratic):
    """Both, for all sizes of cells."""
    return {
        str(cells): front(configuration, (linear, quadratic), cells)
        | rebound(configuration, (linear, quadratic), cells)
        for cells in CELLS
    }


def text(of, note):
    """The table; ``of(configuration, linear, quadratic)`` are the figures, if there are any."""
    rows = []
    for one in CONFIGURATIONS:
        for viscosity in VISCOSITIES:
            if not (found := of(one, *viscosity)):
                continue
            sizes = [found[str(cells)] for cells in CELLS]
            rows.append((
                one, ", ".join(f"{c:g}" for c in viscosity) if any(viscosity) else "none",
                ", ".join(f"{f['error']:.3f}" for f in sizes),
                ", ".join(f"{round(100.0 * f['overshoot'], 1) + 0.0:.1f}" for f in sizes),
                ", ".join(f"{f['restitution']:.3f}" for f in sizes),
                ", ".join(f"{100.0 * f['lost']:.1f}" for f in sizes),
                ", ".join(f"{1e3 * f['seconds']:.0f}" for f in sizes),
            ))  # fmt: skip
    heads = ("configuration", "viscosity", "error of the wave", "overshoot, %",
             "restitution", "energy lost, %", "time of the wave, ms")  # fmt: skip
    return table(heads, rows, note)
