"""Migration: particles whose layer has become a neighbour's move there, with all they carry."""

from typing import Any

import numpy as np

from pgimp.parallel.slabs import Slab
from pgimp.solver.particles import Particles
from pgimp.solver.population import Population

_TAG = 3


def pack(particles: Particles, rows: np.ndarray) -> np.ndarray:
    """All that the particles in `rows` carry, (n, width) float64; whole numbers bit by bit."""
    n = len(rows)
    columns = []
    for array in particles:
        taken = array[rows].reshape(n, array[0].size)
        if taken.dtype.kind == "i":
            taken = taken.astype(np.int64).view(np.float64)
        columns.append(taken)
    return np.concatenate(columns, axis=1)


def unpack(records: np.ndarray, particles: Particles, rows: np.ndarray) -> None:
    """Set `rows` of the particles from records made by `pack`."""
    column = 0
    for array in particles:
        width = array[0].size
        taken = np.ascontiguousarray(records[:, column : column + width])
        if array.dtype.kind == "i":
            taken = taken.view(np.int64)
        array[rows] = taken.reshape(len(rows), *array.shape[1:])
        column += width


def width(particles: Particles) -> int:
    """Number of float64 in a particle's record."""
    return sum(array[0].size for array in particles)


def migrate(comm: Any, slab: Slab, population: Population, movers: np.ndarray) -> np.ndarray:
    """Send away the movers that have left the slab, and take in those that come.

    Parameters
    ----------
    movers : (k,) int32
        Rows of this rank's particles whose layer has changed.

    Returns
    -------
    (n,) int32
        Rows of the particles that are new in a layer of this rank.
    """
    if slab.below is None and slab.above is None:
        return movers
    layer = population.particles.layer[movers]
    down, up = layer < slab.first, layer >= slab.first + slab.layers
    arrivals = [movers[~(down | up)]]
    sends, messages = [], []
    for neighbour, leaving in ((slab.below, movers[down]), (slab.above, movers[up])):
        if neighbour is not None:
            messages.append(pack(population.particles, leaving))
            sends.append(comm.Isend(messages[-1], neighbour, _TAG))
            population.release(leaving)
    for neighbour in (slab.below, slab.above):
        if neighbour is not None:
            arrivals.append(_receive(comm, neighbour, population))
    for send in sends:
        send.Wait()
    return np.concatenate(arrivals)


def _receive(comm: Any, neighbour: int, population: Population) -> np.ndarray:
    """Rows of the particles that come from a neighbour."""
    from mpi4py import MPI

    status = MPI.Status()
    message = comm.Mprobe(neighbour, _TAG, status)
    columns = width(population.particles)
    records = np.empty((status.Get_count(MPI.DOUBLE) // columns, columns))
    message.Recv(records)
    rows = population.admit(len(records))
    unpack(records, population.particles, rows)
    return rows
