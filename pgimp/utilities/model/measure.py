"""Measurement of the costs of a step's parts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import ceil, log2
from statistics import median
from time import perf_counter

import numpy as np

from pgimp.decomposition.migrate import pack, unpack
from pgimp.errors import RunError
from pgimp.mpi.communicator import Communicator
from pgimp.solver.simulation import Simulation
from pgimp.utilities.model.costs import Costs, Messages, Network
from pgimp.utilities.model.layout import layout_now
from pgimp.utilities.model.predict import predict
from pgimp.utilities.model.sample import Sample

_SMALL, _LARGE = 2**13, 2**18
_REPEATS = 20


def run_in_turn(
    samples: Sequence[Sample | None], comm: Communicator, seconds: float, fewest: int = 3
) -> None:
    """Time blocks of all samples in turn, so that disturbances affect all equally; collective.

    On a rank without a part in a sample, the sample is None.

    Parameters
    ----------
    seconds : float
        Duration of the timing.
    fewest : int
        Least number of blocks of each sample.
    """
    begin, turns = perf_counter(), 0
    while comm.bcast(turns < fewest or perf_counter() - begin < seconds):
        for sample in samples:
            comm.Barrier()
            if sample:
                sample.run()
        turns += 1


def costs_of(samples: Sequence[Sample]) -> Costs:
    """Costs from at least two samples of different sizes, ascending, on one rank.

    Raises
    ------
    RunError
        If no step of a sample could be timed.
    """
    for sample in samples:
        if not sample.timed:
            raise RunError(f"no step of a sample could be timed: {sample.failure}")
    counts = [float(sample.sim.rank.count) for sample in samples]
    planes = [float(sample.sim.rank.grid.active.sum()) for sample in samples]
    vertices = [
        n * float(np.prod(sample.sim.rank.grid.window.extent[1:]))
        for n, sample in zip(planes, samples, strict=True)
    ]
    grid = [sample.seconds("momentum") for sample in samples]
    vertex = max(0.0, (grid[-1] - grid[0]) / max(vertices[-1] - vertices[0], 1.0))
    rest = [sample.seconds() - vertex * n for sample, n in zip(samples, vertices, strict=True)]
    # The smallest sample gives the fixed cost, the others the cost per particle.
    each = max(0.0, (rest[1] - rest[0]) / max(counts[1] - counts[0], 1.0))
    fixed = max(rest[0] - each * counts[0], 0.05 * rest[0])
    particles = tuple(
        (n, (max(seconds - fixed, 0.05 * seconds) + sample.seconds("sort")) / n)
        for n, seconds, sample in zip(counts[1:], rest[1:], samples[1:], strict=True)
    )
    last = samples[-1]
    return Costs(fixed, particles, vertex, last.seconds("P2G") / max(last.seconds(), 1e-9))


def messages_of(pair: Sample, costs: Costs, comm: Communicator) -> Messages:
    """Costs of messages, from a small sample on all ranks, at least two; collective."""
    reduction = _reduction(comm) / ceil(log2(comm.size))
    bandwidth = _bandwidth(comm)
    migrant = _migrant(pair.sim)
    free = Messages(0.0, bandwidth, reduction, migrant, True)
    step = predict(layout_now(pair.sim), costs._replace(messages=free), Network(), comm.size)
    neighbours = min(2, step.slabs - 1)
    neighbour = (pair.seconds() - step.seconds) / max(1, neighbours)
    return free._replace(neighbour=comm.bcast(max(neighbour, 0.0)))


def busy_of(crowd: Sample, costs: Costs, comm: Communicator) -> float:
    """Factor of work on all ranks at once, from a large sample on all ranks; collective."""
    step = predict(layout_now(crowd.sim), costs, Network(), comm.size)
    work = step.mean + step.excess
    measured = crowd.seconds() + crowd.seconds("sort")
    return float(comm.bcast(max(1.0, 1.0 + (measured - step.seconds) / work)))


def _timed(comm: Communicator, act: Callable[[], object]) -> float:
    """Median seconds of an action on all ranks; the same on every rank."""
    seconds = []
    for _ in range(_REPEATS):
        comm.Barrier()
        begin = perf_counter()
        for _ in range(_REPEATS):
            act()
        seconds.append((perf_counter() - begin) / _REPEATS)
    return float(max(comm.allgather(median(seconds))))


def _reduction(comm: Communicator) -> float:
    from mpi4py import MPI

    mine, every = np.zeros(8), np.zeros(8)
    return _timed(comm, lambda: comm.Iallreduce(mine, every, MPI.MAX).Wait())


def _bandwidth(comm: Communicator) -> float:
    """Bytes per second between the first two ranks, in both directions at once."""
    other = 1 - comm.rank

    def seconds(size: int) -> float:
        sent, received = np.zeros(size), np.zeros(size)

        def exchange() -> None:
            if other in (0, 1):
                request = comm.Irecv(received, other)
                comm.Send(sent, other)
                request.Wait()

        return _timed(comm, exchange)

    return 8.0 * (_LARGE - _SMALL) / max(seconds(_LARGE) - seconds(_SMALL), 1e-9)


def _migrant(sim: Simulation) -> float:
    """Seconds to pack and unpack a particle."""
    rows = sim.live()[:500]
    if len(rows) == 0:
        return 0.0
    unpack(pack(sim.particles, rows), sim.particles, rows)  # compiles
    begin = perf_counter()
    for _ in range(_REPEATS):
        unpack(pack(sim.particles, rows), sim.particles, rows)
    return (perf_counter() - begin) / _REPEATS / len(rows)
