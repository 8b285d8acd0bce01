"""The body forces of `random_functions.py`, and of water in the ground, once more, by NumPy."""

import numpy as np


def forces_by_hand(sim, rows):
    """Force per mass of a function of one's own, and of water, on some particles, (n, D)."""
    found = _own(sim, rows)
    if sim.case.water:
        water, p = sim.scene.interaction.loads.water, sim.particles
        lift = water.lift(p, rows.max(initial=-1) + 1, sim.time)[rows] / p.m[rows]
        found[:, water.axis] -= np.sign(sim.scene.domain.gravity(sim.time)[water.axis]) * lift
    return found


def _own(sim, rows):
    p, entry, t = sim.particles, sim.case.body_force, sim.time
    if entry is None:
        return np.zeros_like(p.x[rows])
    x, v, given = p.x[rows], p.v[rows], entry.arguments
    if entry.function == "pulling":
        return -given["strength"] * np.cos(given["rate"] * t) * x
    X = p.origin[rows]
    sway = given["strength"] * np.sin(given["wave"] * X[:, :1] + given["rate"] * t)
    return 0.3 * sway * X - given["drag"] * v
