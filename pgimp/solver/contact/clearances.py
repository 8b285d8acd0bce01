"""Clearances of a rank's vertices from unilateral walls."""

from typing import Any

import numpy as np

from pgimp.decomposition.grid import Grid
from pgimp.jit.bound import Bound
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.loads.wall_gap import find_clearances
from pgimp.scene.scene import Scene


class Clearances:
    """Clearances of bodies from the walls, step by step; nothing where no wall needs them."""

    def __init__(self, scene: Scene) -> None:
        self.scene, self.call = scene, Bound()
        self.joint = scene.interaction.pairs is not None and scene.interaction.pairs.ties(
            len(scene.body_names)
        )
        self.values: Any = np.empty((0, 0)) if scene.domain.approached else ()

    def stored(self, grid: Grid) -> Any:
        """Return storage for `Forcing.clearances` in the grid's size, still to be filled."""
        shape = (len(self.scene.domain.faces), len(grid.G) // RECORD)
        if self.scene.domain.approached and self.values.shape != shape:
            self.values = np.empty(shape)
        return self.values

    def find(self, grid: Grid) -> None:
        """Compute them, after the halo exchange and the reflection at faces that hold."""
        scene = self.scene
        for wall in scene.domain.approached:
            self.call(
                find_clearances, scene.domain.frame, grid.field, wall, self.joint, self.values
            )
