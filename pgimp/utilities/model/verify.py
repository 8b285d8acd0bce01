"""Comparison of measured and predicted times of the same steps."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple, cast

from pgimp.mpi.comm import Serial
from pgimp.mpi.communicator import Communicator
from pgimp.solver.simulation import Simulation
from pgimp.utilities.model.costs import Costs, Network
from pgimp.utilities.model.layout import layout_now
from pgimp.utilities.model.measure import busy_of, costs_of, messages_of, run_in_turn
from pgimp.utilities.model.predict import predict
from pgimp.utilities.model.sample import Sample


class Comparison(NamedTuple):
    """Measured and predicted time of a step, in seconds."""

    name: str
    particles: int
    ranks: int
    measured: float
    predicted: float

    @property
    def deviation(self) -> float:
        """Relative deviation of the prediction from the measurement."""
        return self.predicted / self.measured - 1.0


def compare(
    comm: Communicator,
    samples: Callable[[], Iterable[Sample]],
    small: Callable[[Communicator], Simulation],
    large: Callable[[Communicator], Simulation],
    targets: dict[str, Callable[[Communicator], Simulation]],
    network: Network,
    seconds: float,
    fewest: int,
    whole: bool = False,
) -> tuple[Costs, list[Comparison]]:
    """Measure costs from samples, and compare predicted with measured times of targets.

    All are timed in turn. Targets run on one rank and on all; collective.

    Parameters
    ----------
    samples : callable
        Makes the samples of one rank, ascending by size; they run while the others wait.
    small, large, targets : callable
        Make a simulation on a communicator. In the small one messages dominate, in the large one
        work; the targets are compared.
    seconds, fewest : float, int
        See `run_in_turn`.
    whole : bool
        Whether whole targets are timed, see `Sample`.
    """
    mine = list(samples()) if comm.rank == 0 else []
    number = comm.bcast(len(mine))
    alone: list[Sample | None] = [*mine] if mine else [None] * number
    pair = Sample(lambda: small(comm), comm) if comm.size > 1 else None
    crowd = Sample(lambda: large(comm), comm) if comm.size > 1 else None
    compared: list[tuple[str, int, Sample | None]] = []
    for name, make in targets.items():
        one = Sample(lambda make=make: make(Serial()), Serial(), whole) if comm.rank == 0 else None  # type: ignore[misc]
        compared.append((name, 1, one))
        if comm.size > 1:
            many = Sample(lambda make=make: make(comm), comm, whole)  # type: ignore[misc]
            compared.append((name, comm.size, many))
    turns = [*alone, pair, crowd, *(sample for _, _, sample in compared)]
    run_in_turn(turns, comm, seconds, fewest)
    while not all(comm.allgather(all(sample.done for _, _, sample in compared if sample))):
        run_in_turn(turns, comm, 0.0, fewest)
    costs = cast(Costs, comm.bcast(costs_of(mine) if mine else None))
    if pair and crowd:
        costs = costs._replace(messages=messages_of(pair, costs, comm))
        costs = costs._replace(busy=busy_of(crowd, costs, comm))
    found = []
    for name, ranks, sample in compared:
        if sample is None:
            continue
        layout = layout_now(sample.sim)
        step = predict(layout, costs, network, ranks)
        measured = sample.seconds() + sample.seconds("sort")
        found.append(Comparison(name, layout.particles, ranks, measured, step.seconds))
    return costs, found
