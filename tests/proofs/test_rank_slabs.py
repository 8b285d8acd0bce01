"""Slabs of the scenes that run on several ranks: of all kinds that there are."""

import numpy as np
from rank_scenes import SCENES
from scenes import start as simulation

from pgimp.decomposition.slabs import cut


def slabs(name):
    """Layers and particles of the slabs of 5 ranks at the start of a scene."""
    sim = simulation(SCENES[name])
    counts, vertices = np.diff(sim.population.start), sim.scene.settings.vertices
    cuts = cut(counts, 5, vertices - 1, sim.scene.ends)
    return np.diff(cuts), np.add.reduceat(counts, cuts[:-1])


def test_the_slabs_of_five_ranks_are_of_all_kinds():
    layers, particles = slabs("plane_leaves")  # three of the thinnest side by side, all in use
    assert (layers[1:4] == 2).all() and particles.all()
    layers, particles = slabs("affine")  # at an end and between others none is used
    assert (layers[2:4] == 2).all()
    assert list(particles > 0) == [False, True, True, False, True]
    layers, particles = slabs("line_gimp")  # thick ones, also between others
    assert layers[3] > 10 and particles.all()
    layers, particles = slabs("plane_fuzzy")  # next to mirrors
    assert layers[0] == 8 and layers[1] == layers[2] == 3
