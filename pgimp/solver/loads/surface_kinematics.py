"""Displacements summed every few steps, which loads on surfaces follow.

See `pgimp.kernels.loads.following`.
"""

from __future__ import annotations

import numpy as np

from pgimp.jit.bound import Bound
from pgimp.kernels.data.arguments import Order
from pgimp.kernels.loads.following import (
    DisplacementSums,
    find_displacements,
    find_surface_corrections,
)
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.rank_state import RankState
from pgimp.solver.vertex_sums import VertexSums
from pgimp.solver.vertices import StepPart

#: Steps from one sum to the next, as each costs as much as the half of a step.
EVERY = 8


class SurfaceKinematics(StepPart):
    """The displacements at a rank's vertices.

    Parameters
    ----------
    scene : Scene
        The scene, in which loads follow surfaces in the current configuration.

    Attributes
    ----------
    fallbacks : int
        Steps times particles of this rank in which a surface follows F alone.
    """

    def __init__(self, scene: Scene, comm: Communicator) -> None:
        self.fallbacks = 0
        self.scene, self.call = scene, Bound()
        self.bodies = scene.interaction.loads.surfaces.following
        self._sums = VertexSums(scene, comm, DisplacementSums())

    def begin(self, rank: RankState, order: Order, done: int) -> None:
        """Find how far F has drifted, when it is due; collective."""
        if done % EVERY:
            return
        particles, setting = rank.up_to_date(), self.scene.setting.without_materials()
        if rank.failed:  # other ranks are not notified yet; such particles may be anywhere
            order = order._replace(start=np.zeros_like(order.start))
        if len(order.rows) and not self.bodies.all():
            mine = self.bodies[particles.body[order.rows]]
            before = np.concatenate([[0], np.cumsum(mine)])
            order = Order(order.rows[mine], before[order.start])
        self._sums.fit(rank.grid, rank.grid.fields)
        self._sums.add(particles, order, np.arange(rank.grid.planes))
        field = self._sums.grid.field
        self._sums.join()
        self.call(find_displacements, field)
        args = setting, field, particles, order, self.scene.setting.identity
        self.fallbacks += EVERY * self.call(find_surface_corrections, *args)


def surface_kinematics_of(
    scene: Scene, comm: Communicator, before: SurfaceKinematics | None = None
) -> SurfaceKinematics | None:
    """The displacements of a scene whose loads follow surfaces; None without any."""
    if not scene.carried.follows_surfaces:
        return None
    found = SurfaceKinematics(scene, comm)
    found.fallbacks = before.fallbacks if before else 0
    return found
