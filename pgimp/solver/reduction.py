"""Reductions: sums over planes, and the one after a step (speed, requests, window).

The latter begins after a rank's step and ends when the next step needs it, after the sums of the
grid. So a rank need not wait at a step's end for ranks that are behind by less than its work until
then. Actions due between two steps complete it first.
"""

from __future__ import annotations

import weakref
from enum import IntEnum

import numpy as np

from pgimp.mpi import communicator
from pgimp.mpi.communicator import Communicator


class Request(IntEnum):
    """Request of a rank after a step; the greatest of all ranks counts, on all of them."""

    NONE = 0
    #: The rank still waits for the disk, see `pgimp.running.frames`.
    PENDING = 1
    CHECKPOINT = 2
    STOP = 3
    #: Particles of the rank are at fault.
    ERROR = 4


def place_planes(comm: Communicator, own: np.ndarray, first: int, planes: int) -> np.ndarray:
    """Return the values of all planes, each of one rank; collective.

    Parameters
    ----------
    own : (n, ...) float64
        Values of this rank's planes.
    first : int
        Place of the first of them.
    planes : int
        Number of all planes; those of no rank get zeros.

    Returns
    -------
    (planes, ...) float64
    """
    every = np.zeros((planes, *own.shape[1:]))
    every[first : first + len(own)] = own
    if comm.size > 1:
        found = np.empty_like(every)
        comm.Allreduce(every, found)  # a plane has but one owner: no sum is rounded
        every = found
    return every


def sum_planes(comm: Communicator, own: np.ndarray, first: int, planes: int) -> np.ndarray:
    """Sum over planes, each of one rank, in their order; parameters as of `place_planes`.

    Collective; all ranks get the same bits, on any number of ranks.
    """
    every = own if comm.size == 1 else place_planes(comm, own, first, planes)
    total: np.ndarray = np.add.reduce(every, axis=0)
    return total


def _complete(requests: list[communicator.Request]) -> None:
    """Wait for the requests: MPI writes to its arrays until then."""
    while requests:
        requests.pop().Wait()


class StepReduction:
    """The reduction of a step; on one rank it gives that rank's own values.

    All ranks make the same calls at the same points of their steps. A reduction that is open when
    the object is dropped, or at the process's end, is completed. All ranks have begun it, or will,
    before their next communication.

    Attributes
    ----------
    open : bool
        Whether it has begun and is not complete.
    rate : float
        Largest (c_p + |v_p|)/L.
    request : Request
        The greatest of all ranks.
    rebalance_requested : bool
        Whether any rank requests another decomposition.
    vertex_bounds : (2, 2) int64
        First vertices (least, greatest; y, z) that all ranks together have reported.
    moved : float
        The greatest `pgimp.solver.contact.base.NoContact.excursion` of all ranks.
    """

    def __init__(self, comm: Communicator) -> None:
        self.rate, self.request, self.rebalance_requested = 0.0, Request.NONE, False
        self.vertex_bounds, self.moved = np.zeros((2, 2), np.int64), 0.0
        self._comm = comm
        self._mine, self._every = np.zeros((2, 8))
        self._begun: list[communicator.Request] = []
        self.close = weakref.finalize(self, _complete, self._begun)
        self.open = False
        if comm.size > 1:
            from mpi4py import MPI

            self._greatest = MPI.MAX

    def begin(
        self, rate: float, request: Request, rebalance_requested: bool, bounds: np.ndarray,
        moved: float,
    ) -> None:  # fmt: skip
        """Start the reduction of a step with this rank's values; collective."""
        self.open = True
        if self._comm.size == 1:
            self.rate, self.request, self.vertex_bounds, self.moved = rate, request, bounds, moved
            return
        mine = self._mine
        mine[0], mine[5:] = rate, (request, rebalance_requested, moved)
        np.negative(bounds[0], out=mine[1:3])
        mine[3:5] = bounds[1]
        self._begun.append(self._comm.Iallreduce(mine, self._every, self._greatest))

    def end(self) -> bool:
        """Complete the reduction; whether one was open."""
        was_open, self.open = self.open, False
        if self._begun:
            _complete(self._begun)
            every = self._every
            self.rate, self.rebalance_requested = float(every[0]), bool(every[6])
            self.request = Request(int(every[5]))
            np.negative(every[1:3], out=self.vertex_bounds[0], casting="unsafe")
            self.vertex_bounds[1], self.moved = every[3:5], float(every[7])
        return was_open
