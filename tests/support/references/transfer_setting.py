"""A step's kernels beside plain NumPy: random particles near faces, and conditions on these."""

import numpy as np
from kernel_driver import SEED, Rank, entry, make_frame, random_particles, random_positions
from reference import Reference

from pgimp.kernels.data.particles import Particles
from pgimp.physics.boundaries import BOUNDARIES

ORIGIN, CELL, CELLS = (-1.1, 0.3, 2.0), (0.7, 1.3, 0.9), (5, 4, 3)
PER_CELL = (2, 1, 3)
COUNT = (20, 40, 40)
DT, GRAVITY = 0.002, (1.5, -9.0, 4.0)
#: Lighter vertices stand still: their v and a carry the rounding errors of tiny weights.
LIGHTEST = 0.01


def setting(name, D, seed=SEED, mean=False):
    """Rank with random particles and the reference with the same, both before a step.

    With `mean` the particles carry what mean dilatation wants of them.
    """
    rng = np.random.default_rng(seed)
    shape = entry(name, PER_CELL[:D])
    frame = make_frame(shape, ORIGIN[:D], CELL[:D], CELLS[:D])
    x = random_positions(rng, frame, COUNT[D - 1])
    for d in range(D):  # some next to the faces, so that ghost vertices take contributions
        x[2 * d, d] = ORIGIN[d] + CELL[d] * 0.03
        x[2 * d + 1, d] = ORIGIN[d] + CELL[d] * (CELLS[d] - 0.03)
    # ... and some next to where the layer changes, on either side.
    p = random_particles(rng, x, mean)
    reference = Reference(name, PER_CELL[:D], frame)
    for k in range(6, 14):
        half = reference.half_widths(p.F[k])[0][0]
        p.x[k, 0] = ORIGIN[0] + half + CELL[0] * (2.0 + (-1e-5, 1e-5)[k % 2])
    rank = Rank(shape, frame, p)
    return rank, reference, copied(rank)


def copied(rank):
    """Copies of a rank's particles, in their canonical order."""
    return Particles(*(array[rank.population.order].copy() for array in rank.up_to_date()))


def close(a, b, tolerance=1e-12):
    """Whether two arrays agree, in terms of the largest entry."""
    a, b = np.asarray(a), np.asarray(b)
    assert a.shape == b.shape
    return np.abs(a - b).max() <= tolerance * max(np.abs(b).max(), 1e-300)


def faces_of(kind, D):
    """Condition on each face: what the kernel takes, what the reference takes."""
    made = []
    for axis in range(D):
        for side in (-1, 1):
            velocity, rate = (None,) * 3, (0.0,) * 3
            entries = {}
            if kind == "velocity":
                # One component free, at the high end the normal one by a table: 1 + 2 t.
                velocity = [0.3 + axis, -0.7, 0.9]
                velocity[(axis + (1 if side < 0 else 2)) % 3] = None
                values = [*velocity]
                if side > 0:
                    values[axis] = {"table": [[0.0, 1.0], [2.0, 5.0]]}
                    velocity[axis], rate = 1 + 2 * (0.5 + DT), [2.0 * (d == axis) for d in range(3)]
                entries = {"velocity": values[:D]}
            condition = BOUNDARIES[kind].model_validate(entries)
            kernel = condition.parameters(axis, side, 0.5, 0.5 + DT)
            made.append((kernel, (kind, axis, side, velocity, rate)))
    return made
