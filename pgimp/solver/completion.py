"""Completion of a step: particles updated and migrated, outflow, faults, canonical order."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from pgimp.kernels.data.arguments import Forcing, Order
from pgimp.kernels.data.particles import OUTFLOW
from pgimp.kernels.sums.sums import layer_sums
from pgimp.solver.particle_groups import ParticleGroup
from pgimp.solver.rank import MOST_LISTED, Rank
from pgimp.solver.transfers import RangeReport, update_particles


def advance_particles(
    rank: Rank, groups: Sequence[ParticleGroup], forcing: Forcing, lap: Callable[[str], None]
) -> list[RangeReport]:
    """Update the particles by ranges of layers, and send those that leave the slab.

    Parameters
    ----------
    groups : sequence of ParticleGroup
        The rank's particles.
    forcing : Forcing
        From `particle_forcing`.
    lap : callable
        From `stopwatch`.

    Returns
    -------
    list of RangeReport
        One for each range; the neighbours wait for the first.
    """
    reports: list[RangeReport] = []
    for layers in rank.halo.halves(rank.population.start):
        report = update_particles(rank, groups, forcing, layers, reports)
        reports.append(report)
        lap("G2P")
        if len(report.changed) or rank.migrates:
            rank.migration.proceed(rank.population, report.changed)
        lap("migrate")
    return reports


def complete_step(rank: Rank, reports: list[RangeReport], lap: Callable[[str], None]) -> None:
    """Complete a step: counts, outflow, particles of other ranks, and the canonical order.

    Parameters
    ----------
    reports : list of RangeReport
        Reports of all layers.
    lap : callable
        From `stopwatch`.
    """
    population = rank.population
    rank.particle_steps += rank.count
    found, outflow, failed = 0, 0, list[int]()
    for report in reports:
        rank.clamped += report.clamped
        rank.held += report.held
        failed += report.failed
        found, outflow = found + len(report.changed), outflow + report.outflow
    if sum(failed):
        _list_errors(rank, failed)
    changed = population.changed[:found]
    if len(reports) > 1:
        changed.sort()
    if outflow:
        _remove_outflow(rank, changed)
    arrived = changed
    if found or rank.migrates:
        arrived = rank.migration.receive(population)
    lap("migrate")
    if found or len(arrived):
        population.restore_order(changed, arrived)


def _remove_outflow(rank: Rank, left: np.ndarray) -> None:
    """Book the particles that have left the domain, and free their rows.

    Their mass, momentum and energy are added to the sums of their last layer, in canonical
    order. So the ledger has the same bits on any number of ranks.

    Parameters
    ----------
    left : (k,) int32
        Offsets in the order of the particles that left or changed their layer, ascending.
    """
    scene, population = rank.scene, rank.population
    rows = population.order[left]
    gone = rank.up_to_date().layer[rows] == OUTFLOW
    leaving = rows[gone]
    order = Order(leaving, np.searchsorted(left[gone], population.start))
    escaped = rank.ledger.escaped[: rank.slab.layers]
    layer_sums(scene.setting.without_shape(), rank.up_to_date(), order, escaped)
    population.free_later(leaving)


def _list_errors(rank: Rank, numbers: list[int]) -> None:
    """List the particles at fault in this step in canonical order, at most `MOST_LISTED`.

    Parameters
    ----------
    numbers : list of int
        Number found by each call; the first ones are in `error_buffer`.
    """
    found = np.concatenate(
        [buffer[:n] for buffer, n in zip(rank.error_buffer, numbers, strict=False)]
    )
    rank_in_order = np.empty(rank.up_to_date().capacity, np.int64)
    rank_in_order[rank.population.order] = np.arange(rank.count)
    rank.failed = sum(numbers)
    rank.errors = found[np.argsort(rank_in_order[found[:, 0]])][:MOST_LISTED]
