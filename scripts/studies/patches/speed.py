"""Time of a step in contact over that of the same blocks in free fall."""

from time import process_time

import numpy as np
from studies.harness import CASES
from studies.scenes import box, by_turns, case_of, core

import pgimp

CELL = 0.08
RUBBER = {"model": "neo-hookean", "young": 3.0e5, "poisson": 0.3, "density": 1000.0}


def _block(low, cells):
    """A block, exact to its surface, given in cells."""
    low = np.array(low, float)
    return {"material": "solid", "formulation": "total-lagrangian", "surface": "exact",
            "region": box(CELL * low, CELL * (low + cells))}  # fmt: skip


def scene(kind, cells, gap=0.0):
    """A block that is damped, so many cells wide, `gap` cells above a floor, or what bears it."""
    cells, more = np.array(cells), {}
    low = np.array([3.0, 3.0, 2.0 if kind == "rigid" else 0.0])
    size = [*(cells[:2] + 6), 2 * cells[2] + 12]
    bodies = {"block": _block(np.add(low, (0.0, 0.0, gap)), cells)}
    if kind != "rigid":
        more["boundaries"] = {"z-min": {"unilateral": {"friction": 0.3}}}
    else:
        below = box([0.5 * CELL] * 3, CELL * np.array([*(cells[:2] + 5.5), 2.0]))
        bodies["floor"] = {"rigid": {}, "region": below}
    if kind == "two":
        shift = np.array([0.37, 0.21, 2.0 * gap + cells[2]])
        bodies["floor"] = _block(low + shift, cells)
    if "floor" in bodies:
        more["contact"] = [{"bodies": ["block", "floor"], "friction": 0.3}]
    case = case_of(CELL * np.array(size), CELL, {"solid": RUBBER}, bodies, 100.0,
                   gravity=[0.0, 0.0, -9.81], damping={"mass": 5.0}, **more)  # fmt: skip
    return core(case)


def speed(kind, cells, settle=200, rounds=10, steps=20):
    """Ratio, million particle-steps/s, mean sweeps of a step."""
    sims = [scene(kind, cells), scene(kind, cells, 3.0)]
    for _ in range(settle):
        sims[0].advance()
    for _ in range(5):
        sims[1].advance()
    spent = by_turns(sims, rounds, steps)
    touching, free = np.median(spent, axis=0)
    sweeps = 0
    for _ in range(steps):
        sims[0].advance()
        sweeps += sims[0].rank.contact.sweeps
    count = len(sims[0].live())
    return {
        "ratio": touching / free, "million": 1e-6 * count / touching, "sweeps": sweeps / steps,
        "particles": count,
    }  # fmt: skip


def bounce(runs=3):
    """As `speed` of `block3d`, which falls and bounces: means of steps, with searches."""
    found = []
    for _ in range(runs):
        sim, spent = pgimp.Simulation(CASES / "block3d.yaml"), []
        for start, end in ((0.1, 0.26), (0.287, 0.36)):
            sim.advance(start)
            began, steps = process_time(), sim.steps
            sim.advance(end)
            spent.append((process_time() - began) / (sim.steps - steps))
        found.append(spent)
    free, touching = np.median(found, axis=0)
    count = len(sim.particles["id"])
    return {"ratio": touching / free, "million": 1e-6 * count / touching, "particles": count}
