"""Particles that leave through faces that let them go: out of the population, into the ledger."""

from typing import TYPE_CHECKING

import numpy as np

from pgimp.kernels.g2p import GONE
from pgimp.kernels.sums import layer_sums

if TYPE_CHECKING:
    from pgimp.solver.simulation import Simulation


def let_go(sim: "Simulation", left: np.ndarray) -> None:
    """Book the particles that have left, and give up their rows.

    What they take with them is added to the sums of the layer in which they were, in canonical
    order, so that the ledger has the same bits on any number of ranks.

    Parameters
    ----------
    sim : Simulation
        Its `escaped` grows.
    left : (k,) int32
        Places in the order of the particles that left or changed their layer, ascending.
    """
    scene, population = sim.scene, sim.population
    particles = population.particles
    rows = population.order[left]
    gone = particles.layer[rows] == GONE
    leaving = rows[gone]
    layer_sums(
        scene.frame, sim.identity, scene.materials, particles, leaving,
        np.searchsorted(left[gone], population.start), scene.material_of,
        sim.escaped[: sim.slab.layers],
    )  # fmt: skip
    population.release(leaving)
