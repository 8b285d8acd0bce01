"""A body of particles from a file, the counterpart of `LatticeBody` for bodies on the lattice."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from pgimp.geometry.points.block import Block
from pgimp.geometry.regions.points import Points
from pgimp.scene.bodies.volume_fractions import Ranges

Reals = NDArray[np.float64]
Mask = NDArray[np.bool_]


class Cloud:
    """Particles of a file, counted by the lattice's planes.

    Parameters
    ----------
    region : Points
        The body's.
    edges : list of (n + 1,) float64
        Coordinates of the lattice's boxes by direction.
    """

    def __init__(self, region: Points, edges: list[Reals]) -> None:
        self.region, self.edges = region, edges
        #: Lattice boxes that contain particles; no box is filled.
        self.box: Ranges = [(0, 0)] * len(edges)

    def _planes(self, x: Reals) -> NDArray[np.int64]:
        """Plane of each coordinate; the domain's far face belongs to the last plane."""
        edges = self.edges[0]
        return np.clip(np.searchsorted(edges, x, "right") - 1, 0, len(edges) - 2)

    def count(self, planes: tuple[int, int]) -> NDArray[np.int64]:
        """Particle counts in each plane of a range."""
        if planes[0] >= planes[1]:
            return np.zeros(0, np.int64)
        total = np.zeros(len(self.edges[0]) - 1, np.int64)
        for _, block in self.region.chosen(lambda block: self.within(block, planes)):
            total += np.bincount(self._planes(block.position[:, 0]), minlength=len(total))
        return total[planes[0] : planes[1]]

    def within(self, block: Block, planes: tuple[int, int]) -> Mask:
        """Mask of the particles of a block within a range of planes."""
        return self.between(np.ascontiguousarray(block.position[:, 0]), planes)

    def between(self, x: Reals, planes: tuple[int, int]) -> Mask:
        """Mask of the coordinates within a range of planes."""
        plane = self._planes(x)
        return (planes[0] <= plane) & (plane < planes[1])

    def make(
        self, planes: tuple[int, int], own: Callable[[Block], Mask] | None
    ) -> Iterator[tuple[NDArray[np.int64], Block]]:
        """Yield rows and particles of a range of planes, or those in `own`."""
        return self.region.chosen(own or (lambda block: self.within(block, planes)))
