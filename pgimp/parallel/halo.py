"""The halo exchange: neighbours end with the same bits in the planes they share.

A slab boundary cuts the sums of ``shared = s - 1`` planes. The rank below sends up its running
sums of them, one prefix a plane; the rank above sends down what its first layers add, each layer
by itself, s(s-1)/2 partial planes. Then both add prefix and partials in layer order.
"""

from typing import Any

import numpy as np

from pgimp.kernels.p2g import add_partials
from pgimp.parallel.slabs import Slab
from pgimp.solver.grid import Grid, aligned

_UP, _DOWN = 1, 2
_MARKS = 4


class Halo:
    """Exchange between a rank and its two neighbours.

    Parameters
    ----------
    comm : communicator
        Of all ranks.
    slab : Slab
        This rank's.
    shared : int
        Planes shared at a slab boundary, s - 1.
    """

    def __init__(self, comm: Any, slab: Slab, shared: int) -> None:
        self.comm = comm
        self.slab = slab
        self.shared = shared
        self._received = aligned(0)

    def exchange(self, grid: Grid) -> None:
        """Complete the sums of the shared planes; not collective beyond the neighbours."""
        below, above = self.slab.below, self.slab.above
        if below is None and above is None:
            return
        plane = grid.window.stride[0]
        doubles = self.shared * plane
        requests = []
        if above is not None:
            top = self.slab.layers
            size = self.shared * (self.shared + 1) // 2 * plane
            if len(self._received) != size:
                self._received = aligned(size)
            requests.append(self.comm.Irecv(self._received, above, _DOWN))
            for i in range(top, top + self.shared):
                if not grid.active[i]:
                    grid.active[i] = 1
                    grid.G[i * plane : (i + 1) * plane] = 0.0
            prefix = grid.G[top * plane : top * plane + doubles]
            requests.append(self.comm.Isend(prefix, above, _UP))
        if below is not None:
            grid.active[: self.shared] = 1
            requests.append(self.comm.Irecv(grid.G[:doubles], below, _UP))
            requests.append(self.comm.Isend(grid.partial, below, _DOWN))
        for request in requests:
            request.Wait()
        if below is not None:
            add_partials(grid.G, 0, grid.partial, self.shared, plane)
        if above is not None:
            add_partials(grid.G, self.slab.layers, self._received, self.shared, plane)

    def unite(self, grid: Grid) -> None:
        """Unite what this rank and its neighbours have marked in the planes that they share."""
        size = self.shared * (grid.window.stride[0] // 8)
        marks, first = grid.marks, self.slab.layers * (grid.window.stride[0] // 8)
        ends = ((self.slab.below, marks[:size]), (self.slab.above, marks[first : first + size]))
        pairs = [
            (neighbour, planes, np.empty_like(planes))
            for neighbour, planes in ends
            if neighbour is not None
        ]
        requests = []
        for neighbour, planes, others in pairs:
            requests.append(self.comm.Irecv(others, neighbour, _MARKS))
            requests.append(self.comm.Isend(planes.copy(), neighbour, _MARKS))
        for request in requests:
            request.Wait()
        for _, planes, others in pairs:
            planes |= others
