"""Loads of random scenes once more, by NumPy: those of `random_functions.py`, water, tractions."""

import contextlib
from unittest import mock

import numpy as np

from pgimp.solver import step as stepping


@contextlib.contextmanager
def pulls_of_step(sim, gravity):
    """Gravity's and body forces' force on each particle, by id, in the one step done meanwhile.

    Seen where particles are summed: damping may have stopped them since the step before.
    """
    found, sums = {}, stepping.sum_particles

    def summed(*words, **keys):
        rows, p = sim.live(), sim.particles
        pull = p.m[rows, None] * (gravity + forces_by_hand(sim, rows))
        found.update(zip(p.id[rows].tolist(), pull, strict=True))
        sums(*words, **keys)

    with mock.patch.object(stepping, "sum_particles", summed):
        yield found


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


def patch_forces(sim):
    """Force of all tractions, from the particles' deformation and areas by Nanson's formula."""
    D, rows, p = sim.scene.dimension, sim.live(), sim.particles
    total = np.zeros(3)
    loads = sim.scene.interaction.loads.at(sim.time)
    for load in loads.tractions:
        area = p.patch[rows, load.column]
        F = np.tile(np.eye(3), (len(rows), 1, 1))
        F[:, :D, :D] = p.F[rows, : D * D].reshape(-1, D, D)
        if sim.case.axisymmetric:
            F[:, 2, 2] = p.F[rows, D * D]
        normal = np.zeros(3)
        normal[load.axis] = load.side
        cofactor = np.linalg.det(F)[:, None, None] * np.linalg.inv(F).transpose(0, 2, 1)
        n = (cofactor @ normal) * area[:, None]
        size = np.linalg.norm(n, axis=1).sum()
        total += np.array(load.traction) * size - load.pressure * n.sum(axis=0)
    return total[:D]
