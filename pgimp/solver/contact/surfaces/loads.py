"""Loads of contact on the facets of all bodies: since the last frame, and since the start."""

from __future__ import annotations

import numpy as np

from pgimp.kernels.contact.surfaces.data import Surface
from pgimp.kernels.contact.surfaces.loads import LOADS, SLIP
from pgimp.mpi.communicator import Communicator

#: Columns of the loads that last from step to step, which checkpoints have.
LASTING = 6


class SurfaceLoads:
    """Impulses on facets since the last frame; slip and heat of friction since the start.

    The rank that solves for impulses has them. They are state, of which a step uses nothing.

    Attributes
    ----------
    values : (facets, LOADS) float64
        See `pgimp.kernels.contact.surfaces.loads`; on the rank that solves.
    time : float
        Time since the last frame.
    """

    def __init__(self, comm: Communicator) -> None:
        self.comm, self.time = comm, 0.0
        self.values = np.zeros((0, LOADS))
        self._root = 0
        self._of: Surface | None = None
        self._restored = np.empty((0, LASTING))

    def begin(self, surface: Surface, root: int, dt: float = 0.0) -> None:
        """Begin a step on a surface, with the loads on rank `root`; collective.

        A surface that is another one keeps the loads of the bodies that are the same.
        """
        self.time += dt
        if self._of is not surface:
            self._renew(surface)
        if root != self._root:
            self.values = np.array(self.comm.bcast(self.values, self._root))
            self._root = root

    def _renew(self, surface: Surface) -> None:
        before, had = self._of, self.values
        self._of, self.values = surface, np.zeros((len(surface.x), LOADS))
        if before is None:
            if len(self._restored) == len(surface.x):
                self.values[:, :LASTING] = self._restored
            return
        for body in np.unique(surface.body):
            own, old = surface.body == body, before.body == body
            if np.array_equal(surface.x[own], before.x[old]):
                self.values[own] = had[old]

    def written(self) -> None:
        """Start the loads of the next frame."""
        self.values[:, :SLIP] = 0.0
        self.time = 0.0

    @property
    def stored(self) -> np.ndarray:
        """What a checkpoint has of them, (1 + facets, LASTING) float64; first the time."""
        if self.comm.rank != self._root or self._of is None:
            return np.empty((0, LASTING))
        first = np.zeros((1, LASTING))
        first[0, 0] = self.time
        return np.concatenate([first, self.values[:, :LASTING]])

    def restore(self, stored: np.ndarray) -> None:
        """Continue with those of a checkpoint, on every rank."""
        self.time, self._restored = float(stored[0, 0]), stored[1:]
