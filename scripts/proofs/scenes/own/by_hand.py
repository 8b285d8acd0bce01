"""The body forces of `random_functions.py` once more, by NumPy."""

import numpy as np


def forces_by_hand(sim, rows):
    """Force per mass of a function of one's own on some particles, (n, D)."""
    p, entry, t = sim.particles, sim.case.body_force, sim.time
    if entry is None:
        return np.zeros_like(p.x[rows])
    x, v, given = p.x[rows], p.v[rows], entry.arguments
    if entry.function == "pulling":
        return -given["strength"] * np.cos(given["rate"] * t) * x
    X = p.origin[rows]
    sway = given["strength"] * np.sin(given["wave"] * X[:, :1] + given["rate"] * t)
    return 0.3 * sway * X - given["drag"] * v
