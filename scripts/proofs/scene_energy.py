"""Energy that a step is known to make or to lose, from what it does at the vertices."""

import contextlib

import numpy as np

from pgimp.kernels.record import RECORD
from pgimp.solver import step as stepping

#: Of a free vertex's velocity; what differs by more is held.
ROUNDING = 1e-9


@contextlib.contextmanager
def vertex_sums(found):
    """Append the vertices' sums of each step, before the momentum update, and gravity to a list."""
    usual = stepping.update_momentum

    def update(frame, field, faces, forcing, ledger):
        sums = field.G.reshape(-1, RECORD).copy()
        found.append((sums, forcing.gravity, forcing.lightest))
        usual(frame, field, faces, forcing, ledger)

    stepping.update_momentum = update
    try:
        yield
    finally:
        stepping.update_momentum = usual


def accelerated(sim, sums, gravity, lightest):
    """Energy that particles gain from vertices held at a rate, above the work that is booked.

    Held is what the update of a free vertex would give another velocity or acceleration: the slot
    `HELD` has one code for all vertices with several such components.
    """
    G = sim.rank.grid.G.reshape(-1, RECORD)
    active = np.repeat(sim.rank.grid.active != 0, sim.rank.grid.window.stride[0] // RECORD)
    some = active & (sums[:, 0] > 0.0) & (G[:, 0] > 0.0)
    G, sums = G[some], sums[some]
    m = sums[:, :1]
    own, V, A = sums[:, 1:4] / m, G[:, 1:4], G[:, 5:8]
    free = np.where(m > lightest, sums[:, 5:8] / m + gravity, 0.0)
    off = np.abs(V - own - sim.dt * free) + sim.dt * np.abs(A - free)
    held = off > ROUNDING * (np.abs(own) + sim.dt * np.abs(free))
    return sim.dt * float((m * A * (own - V))[held].sum())


@contextlib.contextmanager
def carried_momentum(found):
    """Append to a list, each step, what vertices get of the variation that particles carry."""
    usual = stepping.sum_particles

    def summed(rank, loads, marked):
        v = rank.particles.v.copy()
        rank.particles.v[:] = 0.0
        usual(rank, loads, False)
        found.append(rank.grid.G.reshape(-1, RECORD).copy())
        rank.particles.v[:] = v
        usual(rank, loads, marked)

    stepping.sum_particles = summed
    try:
        yield
    finally:
        stepping.sum_particles = usual


def unbalanced(sim, carried):
    """Energy that the step's accelerations give to what particles carry, and that they never get.

    With carried momenta q_v the grid's energy grows by (p_v + q_v) A_v dt, the particles' by p_v
    A_v dt.
    """
    G = sim.rank.grid.G.reshape(-1, RECORD)
    active = np.repeat(sim.rank.grid.active != 0, sim.rank.grid.window.stride[0] // RECORD)
    some = active & (carried[:, 0] > 0.0) & (G[:, 0] > 0.0)
    return sim.dt * float((carried[some, 1:4] * G[some, 5:8]).sum())
