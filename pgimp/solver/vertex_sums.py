"""Further sums over particles at the vertices, besides mass, momentum and force.

There are volumes for contact, the filling of flows, and displacements for loads on surfaces. They
are layered sums with the exchange of the masses (docs/the-sum.md), so that all ranks get
the same bits.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pgimp.decomposition.grid import Grid
from pgimp.decomposition.halo import Halo
from pgimp.jit.bound import Bound
from pgimp.jit.rehearsal import needed
from pgimp.kernels.data.arguments import Field, Order
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.grid.image_values import ALL, copy_values, fold_values
from pgimp.kernels.step.p2g import complete, particles_to_grid
from pgimp.kernels.transfer.quantity import Quantity
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene


class VertexSums:
    """Sums of particles at a rank's vertices, in a separate grid with its own messages.

    Parameters
    ----------
    quantity : Quantity
        What is summed.
    """

    grid: Grid  #: The sums; it has the planes and the window of the rank's own grid.

    def __init__(self, scene: Scene, comm: Communicator, quantity: Quantity) -> None:
        self.scene, self.comm, self.quantity, self.call = scene, comm, quantity, Bound()
        self._known: Field | None = None
        self._planes, self._runs = np.empty(0, np.int64), np.empty((0, 3), np.int64)
        self._halos: dict[tuple[bool, bool], Halo] = {}

    def fit(self, grid: Grid, fields: Sequence[int]) -> bool:
        """Allocate for the planes of a rank's grid, and velocity fields; return whether anew."""
        if self._known is grid.field:
            return False
        if self._known is not None and self._is_like(grid):
            self._known = grid.field
            if self.grid.fields == tuple(fields):
                return False
            self.grid.regroup(fields)
            return True
        for halo in self._halos.values():
            halo.close()
        self._halos.clear()
        self._known, self._planes = grid.field, np.empty(0, np.int64)
        self.grid = Grid(
            self.scene.domain.frame,
            self.scene.settings.vertices,
            grid.slab,
            grid.lag,
            fields,
            periodic=self.scene.domain.periodic,
        )
        self.grid.store(grid.base)
        return True

    def _is_like(self, grid: Grid) -> bool:
        """Whether a rank's grid has the planes and the window of this one."""
        own = self.grid
        same = own.slab == grid.slab and np.array_equal(own.base, grid.base)
        return same and own.window.extent == grid.window.extent

    def add(self, particles: Particles, order: Order, planes: np.ndarray) -> None:
        """Sum particles into some of the planes.

        A neighbour takes part if it shares one of them, on which both sides have to agree.

        Parameters
        ----------
        particles, order
            The particles; all that have weight in these planes.
        planes : (n,) int64
            The planes, ascending.
        """
        own, slab, shared = self.grid, self.grid.slab, self.grid.vertices - 1
        if not np.array_equal(planes, self._planes):  # they stay equal for many steps
            self._planes, self._runs = planes, _runs(planes, slab.layers, shared)
        own.active.fill(0)
        self.call(
            particles_to_grid, self.scene.setting.without_materials(), own.field, particles,
            self.quantity, order, self._runs, (),
        )  # fmt: skip
        lower = slab.lower is not None and bool(planes[0] < shared)
        upper = slab.upper is not None and bool(planes[-1] >= slab.layers)
        if lower or upper:
            halo = self._halo(lower, upper)
            halo.proceed(own)
            halo.finish(own)
        elif needed(0):
            complete(own.field, 0, 1, False, np.empty(0))

    def join(self) -> None:
        """Give all copies of the vertices at seams across y or z the sum of both."""
        frame, field = self.scene.domain.frame, self.grid.field
        for seam in self.scene.domain.seams:
            self.call(fold_values, frame, field, seam, ALL, False)
            self.call(copy_values, frame, field, seam, ALL)

    def _halo(self, lower: bool, upper: bool) -> Halo:
        """Return the messages to the neighbours that share a plane."""
        halo = self._halos.get((lower, upper))
        if halo is None:
            slab = self.grid.slab
            part = slab._replace(
                lower=slab.lower if lower else None, upper=slab.upper if upper else None
            )
            halo = self._halos[lower, upper] = Halo(self.comm, part, self.grid.vertices - 1)
        return halo


def _runs(planes: np.ndarray, layers: int, shared: int) -> np.ndarray:
    """Find the layers that add to some of the planes, as runs for `particles_to_grid`."""
    near = np.zeros(layers + shared, bool)
    for i in range(shared + 1):
        near[np.maximum(planes - i, 0)] = True
    edges = np.flatnonzero(np.diff(near[:layers], prepend=False, append=False)).reshape(-1, 2)
    return np.concatenate([edges, np.zeros((len(edges), 1), np.int64)], axis=1)
