"""Measurement of the costs of a step's parts."""

from __future__ import annotations

from collections.abc import Sequence
from time import perf_counter

import numpy as np

from pgimp.errors import RunError
from pgimp.utilities.model.costs import Costs
from pgimp.utilities.model.sample import Sample


def run_in_turn(samples: Sequence[Sample], seconds: float, fewest: int = 3) -> None:
    """Time blocks of all samples in turn, so that disturbances affect all equally.

    Parameters
    ----------
    seconds : float
        Duration of the timing.
    fewest : int
        Least number of blocks of each sample.
    """
    begin, turns = perf_counter(), 0
    while turns < fewest or perf_counter() - begin < seconds:
        for sample in samples:
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
    return Costs(fixed, particles, vertex)
