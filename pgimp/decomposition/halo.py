"""The halo exchange: neighbours end with the same bits in shared planes.

A slab boundary cuts the sums of ``shared = s - 1`` planes. The lower rank sends up its running
sums, one prefix a plane. The upper rank sends down its first layers' contributions, each layer by
itself, s(s-1)/2 partial planes. Then both add prefix and partials in layer order.

Only a slab's first and last layers contribute to these messages. They are summed first, and the
inner layers while the messages are in transit, if that saves more than the further kernel calls
cost. An MPI library may progress a long message only while it is called. Therefore the inner layers
are summed in pieces, with calls of MPI between them.
"""

import weakref
from itertools import pairwise

import numpy as np

from pgimp.decomposition.grid import UNITE, Grid, aligned
from pgimp.decomposition.slabs import Slab
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.step.p2g import complete
from pgimp.mpi.communicator import Communicator, Request
from pgimp.mpi.switches import switched_on

_UP, _DOWN = 1, 2
_MARKS_UP, _MARKS_DOWN = (4, 7), (9, 8)

#: Environment variable that turns overlap off: "0" sums all layers first, with the same bits.
SWITCH = "PGIMP_OVERLAP"
_MEANING = "lets ranks wait for each other's messages", "lets them work meanwhile"

#: Least number of particles in a piece of the inner layers, and greatest number of pieces.
PIECE, PIECES = 2000, 4


def _free(requests: list[Request]) -> None:
    for request in requests:
        request.Free()
    requests.clear()


class Halo:
    """Exchange between a rank and its two neighbours, by persistent requests.

    Requests belong to a grid's arrays and are recreated when these change, as with the window. A
    halo is cheap to make; when slabs change, make another and `close` the old one. An open one is
    closed at the process's end, before MPI.

    In a step, call `proceed` after each of the `parts` of the layers, then `finish`.

    Parameters
    ----------
    slab : Slab
        This rank's slab.
    shared : int
        Planes shared at a slab boundary, s - 1.

    Attributes
    ----------
    overlap : bool
        Whether inner layers may be summed while messages are in transit.
    piece : int
        Least number of particles in a piece of the inner layers.
    messages, bytes : int
        Sent so far by this rank.
    """

    def __init__(self, comm: Communicator, slab: Slab, shared: int) -> None:
        self.comm, self.slab, self.shared = comm, slab, shared
        self.overlap, self.piece = switched_on(SWITCH, *_MEANING), PIECE
        self._alone = not slab.neighbours
        #: Whether this rank is its own neighbour, on a ring.
        self._own = slab.neighbours and slab.lower == slab.upper == comm.rank
        self.messages = self.bytes = 0
        layers = slab.layers
        self._first = shared if slab.lower is not None else 0
        self._last = layers - (shared if slab.upper is not None else 0)
        self._parts: list[tuple[np.ndarray, ...]] = [(np.array([[0, layers, 0]]),)]
        if not self._alone and self._last > self._first:
            edges = np.array([[self._last, layers, 1], [0, self._first, 0]])
            inside = self._last - self._first
            for pieces in range(1, min(PIECES, inside) + 1):
                cuts = [self._first + inside * i // pieces for i in range(pieces + 1)]
                inner = [np.array([[a, b, 0]]) for a, b in pairwise(cuts)]
                self._parts.append((edges, *inner))
        every = np.arange(layers)
        begin, end = int(slab.lower is not None), layers - (slab.upper is not None)
        self._halves: list[tuple[np.ndarray, ...]] = [(every,)]
        if not self._alone and end > begin:
            outer = np.concatenate([every[:begin], every[end:]])
            self._halves.append((outer, every[begin:end]))
        self._kept = self._ready = self._marked = False
        self._grid: np.ndarray | None = None
        self._marks: tuple[np.ndarray, ...] | None = None
        self._received = aligned(0)
        self._sizes = [0, 0]  # bytes sent in a step, without marks and with them
        self._others: list[tuple[np.ndarray, np.ndarray, np.ufunc]] = []
        self._requests: list[Request] = []
        self._mark_requests: list[Request] = []
        self._every: list[Request] = []
        self._started: list[Request] = []
        self.close = weakref.finalize(self, _free, self._every)

    def parts(self, start: np.ndarray) -> tuple[np.ndarray, ...]:
        """Parts of the rank's layers, each some runs for `particles_to_grid`, in turn.

        Parameters
        ----------
        start : (layers + 1,) int64
            Beginning of each layer in the order of the particles.
        """
        parts = self._parts[0]
        if self.overlap and len(self._parts) > 1:
            inner = int(start[self._last] - start[self._first])
            parts = self._parts[min(inner // self.piece, len(self._parts) - 1)]
        self._kept = len(parts) > 1 and self.slab.upper is not None
        return parts

    def halves(self, start: np.ndarray) -> tuple[np.ndarray, ...]:
        """Layers from which particles may leave the slab, then the others; all, if these are few.

        Advancing them separately lets ranks lag by the time of the other layers, but costs a call.

        Parameters
        ----------
        start : (layers + 1,) int64
            As in `parts`.
        """
        ends, *others = self._halves[-1]
        if not self.overlap or not others:
            return self._halves[0]
        inner = start[-1] - sum(start[i + 1] - start[i] for i in ends)
        return self._halves[-1 if inner >= PIECES * self.piece else 0]

    def proceed(self, grid: Grid, marked: bool = False) -> None:
        """Send the neighbours' data, at the first call in a step; then progress the messages.

        Parameters
        ----------
        marked : bool
            Whether the exchange includes ``grid.marks``, which must be complete.
        """
        if self._alone:
            return
        if self._own:
            self._ready, self._marked = True, marked
            return
        if self._started:
            for request in self._started:
                request.Test()
            return
        if self._grid is not grid.G:
            self._connect(grid)
        if marked and self._marks is not grid.marks:
            self._connect_marks(grid)
        self._activate(grid)
        self._started += self._requests
        if marked:
            self._started += self._mark_requests
        for request in self._started:
            request.Start()
        self.messages += len(self._started) // 2
        self.bytes += self._sizes[marked]

    def finish(self, grid: Grid) -> None:
        """Complete the sums of the shared planes, and unite the marks there."""
        if self._ready:
            self._close_ring(grid)
        if not self._started:
            return
        for request in self._started:
            request.Wait()
        complete(grid.field, self.shared, self.slab.layers, self._kept, self._received)
        if len(self._started) > len(self._requests):
            for planes, others, unite in self._others:
                unite(planes, others, out=planes)
        self._started.clear()

    def _activate(self, grid: Grid) -> None:
        """Let the planes take part that are shared."""
        if self.slab.upper is not None:
            top = self.slab.layers
            for i in range(top, top + self.shared):
                if not grid.active[i]:
                    grid.active[i] = 1
                    grid.clear(i)
        if self.slab.lower is not None:
            grid.active[: self.shared] = 1

    def _close_ring(self, grid: Grid) -> None:
        """Exchange the sums with this rank itself, as with a neighbour."""
        self._ready = False
        self._activate(grid)
        plane, top, shared = grid.window.stride[0], self.slab.layers, self.shared
        grid.G[: shared * plane] = grid.G[top * plane :][: shared * plane]
        complete(grid.field, shared, top, self._kept, grid.partial)
        if self._marked:
            plane //= RECORD
            for marks, unite in zip(grid.marks, UNITE, strict=False):
                low, high = marks[: shared * plane], marks[top * plane :][: shared * plane]
                unite(low, high, out=low)
                high[:] = low

    def _connect(self, grid: Grid) -> None:
        """Make the requests for the arrays of `grid`."""
        _free(self._every)
        self._mark_requests.clear()
        self._sizes = [0, 0]
        self._grid, self._marks = grid.G, None
        plane = grid.window.stride[0]
        lower, upper = self.slab.lower, self.slab.upper
        requests = []
        if upper is not None:
            self._received = aligned(self.shared * (self.shared + 1) // 2 * plane)
            prefix = grid.G[self.slab.layers * plane :][: self.shared * plane]
            requests.append(self.comm.Recv_init(self._received, upper, _DOWN))
            requests.append(self.comm.Send_init(prefix, upper, _UP))
            self._sizes[0] += prefix.nbytes
        if lower is not None:
            prefix = grid.G[: self.shared * plane]
            requests.append(self.comm.Recv_init(prefix, lower, _UP))
            requests.append(self.comm.Send_init(grid.partial, lower, _DOWN))
            self._sizes[0] += grid.partial.nbytes
        self._requests = requests
        self._every += requests

    def _connect_marks(self, grid: Grid) -> None:
        """Make the requests for the constraints' marks in the shared planes."""
        self._marks = grid.marks
        plane = grid.window.stride[0] // RECORD
        self._others, self._sizes[1] = [], self._sizes[0]
        lower, upper = self.slab.lower, self.slab.upper
        for neighbour, first, sends, receives in (
            (lower, 0, _MARKS_DOWN, _MARKS_UP),
            (upper, self.slab.layers, _MARKS_UP, _MARKS_DOWN),
        ):
            for n, marks in enumerate(grid.marks if neighbour is not None else ()):
                planes = marks[first * plane : (first + self.shared) * plane]
                others = np.empty_like(planes)
                self._others.append((planes, others, UNITE[n]))
                self._mark_requests.append(self.comm.Recv_init(others, neighbour, receives[n]))
                self._mark_requests.append(self.comm.Send_init(planes, neighbour, sends[n]))
                self._sizes[1] += planes.nbytes
        self._every += self._mark_requests
