"""Creation of a rank's particles at the start of a run."""

import numpy as np

from pgimp.decomposition.slabs import Slab
from pgimp.kernels.data.particles import Particles
from pgimp.scene.bodies.lattice import Lattice
from pgimp.scene.bodies.populate import populate
from pgimp.scene.scene import Scene
from pgimp.solver.decomposition import slab_predicate

#: A vertex lighter than this part of the lightest initial particle is not accelerated.
LIGHT = 1e-12


class Creation:
    """Particles from a case; other sources override the methods.

    Parameters
    ----------
    scene : Scene
        The scene of the first stage.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene

    def layer_counts(self, counts: np.ndarray) -> np.ndarray:
        """Particles of each layer, given the lattice particles there."""
        return counts

    def create(
        self, slab: Slab, lattice: Lattice, counts: np.ndarray, layer: np.ndarray
    ) -> tuple[Particles, int]:
        """Particles of a slab's layers, and their number; `layer` has the layer of each plane."""
        own = np.searchsorted(layer, (slab.first, slab.first + slab.layers))
        begin, end = int(own[0]), int(own[1])
        particles = populate(
            self.scene, lattice, counts, (begin, end), slab_predicate(self.scene, slab)
        )
        return particles, int(np.count_nonzero(particles.m))
