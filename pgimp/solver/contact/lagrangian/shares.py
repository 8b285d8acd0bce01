"""Partition of contact vertices among the ranks, independent of the particles' slabs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pgimp.mpi.communicator import Communicator
from pgimp.solver.contact.lagrangian.messages import total

#: Greater than all numbers of vertices.
FAR = 1 << 40


class Shares(NamedTuple):
    """The rank that finds the pairs of each vertex: a run of vertices along one axis for each.

    No bit of the results depends on it.
    """

    axis: int
    #: (ranks + 1,) int64: The first vertex of each rank, and the end of the last: all vertices have
    #: a rank.
    ends: np.ndarray

    def within(self, rank: int) -> np.ndarray:
        """Axis, least and greatest vertex of a rank, (3,) int64."""
        return np.array([self.axis, self.ends[rank], self.ends[rank + 1] - 1])

    def reached(self, first: np.ndarray, last: np.ndarray, rank: int) -> np.ndarray:
        """Whether particles have vertices of a rank, (n,) bool.

        Parameters
        ----------
        first, last : (n, 3) float64
            The first and the last vertex of each by direction.
        """
        begin, end = first[:, self.axis], last[:, self.axis]
        return (begin < self.ends[rank + 1]) & (end >= self.ends[rank])


def undivided(ranks: int) -> Shares:
    """Return a partition with all vertices on the first of some ranks."""
    return Shares(0, np.array([-FAR, *[FAR] * ranks]))


def divide(comm: Communicator, first: np.ndarray, vertices: int, most: np.ndarray) -> Shares:
    """Divide the particles of all ranks evenly, along the axis with the fewest copies.

    Collective; equal on all ranks.

    Parameters
    ----------
    first : (n, 3) float64
        The first vertex of each particle of this rank, with `vertices` in each direction.
    most : (D,) int64
        Number of vertices along each axis; vertices beyond count as at the end.
    """
    counts = [
        np.bincount(np.clip(first[:, d], 0, many - 1).astype(np.int64), minlength=many)
        for d, many in enumerate(most)
    ]
    every = np.split(total(comm, np.concatenate(counts)), np.cumsum(most)[:-1])
    best, shares = np.inf, undivided(comm.size)
    for axis, count in enumerate(every):
        sums = np.concatenate([[0], np.cumsum(count)])
        cuts = np.searchsorted(sums, sums[-1] * np.arange(1, comm.size) / comm.size)
        least = np.maximum(np.concatenate([[0], cuts]) - vertices + 1, 0)
        cost = (sums[np.append(cuts, len(count))] - sums[least]).max()
        if cost < best:
            best, shares = cost, Shares(axis, np.concatenate([[-FAR], cuts, [FAR]]))
    return shares
