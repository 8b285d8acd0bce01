"""P2G and G2P of a rank's particles: the kernels' calls by configuration and range of layers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pgimp.jit.bound import Bound
from pgimp.kernels.data.arguments import Forcing, Report
from pgimp.kernels.grid.constrained_vertices import release_light
from pgimp.kernels.grid.image_values import ALL, fold_values
from pgimp.kernels.loads.loads import Loads
from pgimp.kernels.step.p2g import particles_to_grid
from pgimp.kernels.update.turns import turn_particles
from pgimp.solver.particle_groups import ParticleGroup, mass_unit
from pgimp.solver.rank_state import RankState
from pgimp.solver.vertices import VertexUpdate


class RangeReport(NamedTuple):
    """Outcome of G2P for a range of layers."""

    #: (n,) int32: Offsets in the order of the particles that changed their layer or left.
    changed: np.ndarray
    rate: float  #: Largest (c_p + |v_p|)/L.
    #: outflow, clamped, held: Particles that left the domain, with a half-width clamped to one
    #: cell, and held in by a wall.
    outflow: int
    clamped: int
    held: int
    failed: tuple[int, ...]  #: Particles at fault, by configuration.


def sum_particles(
    rank: RankState,
    groups: Sequence[ParticleGroup],
    loads: Loads,
    marked: bool,
    call: Bound | None = None,
) -> None:
    """Sum a rank's particles into its planes; `Halo.finish` adds the neighbours' sums.

    Parameters
    ----------
    groups : sequence of ParticleGroup
        Its particles.
    loads : Loads
        The loads on them.
    marked : bool
        Whether constrained vertices are marked.
    call : Bound, optional
        For loads of other types than the steps have.
    """
    call, grid = call or rank.call, rank.grid
    first, *more = groups
    particles = first.columns(rank.population)
    if marked:
        for values in grid.marks:
            values.fill(0)
        for each, group in zip(rank.calls, groups, strict=True):
            group.mark(each, rank, particles)
    setting, summed, order = first.summands(loads)
    second = first.second_group(rank, more, loads)
    grid.active.fill(0)
    for runs in rank.halo.parts(rank.population.start):  # first the layers neighbours wait for
        call(particles_to_grid, setting, grid.field, particles, summed, order, runs, second)
        rank.halo.proceed(grid, marked)


def finish_sums(rank: RankState, groups: Sequence[ParticleGroup], marked: bool = False) -> None:
    """Add the neighbours' sums, and set the masses of vertices that keep them; collective."""
    rank.halo.finish(rank.grid)
    for group in groups:
        group.finish_sums(rank)
    join_seams(rank, marked)


def join_seams(rank: RankState, marked: bool) -> None:
    """Make one of both copies of the vertices at seams, see `pgimp.kernels.grid.image_values`.

    Then all sums are complete, and constraints may release vertices.
    """
    for seam in rank.scene.domain.seams:
        rank.call(fold_values, rank.scene.domain.frame, rank.grid.field, seam, ALL, True)
        if marked:
            rank.grid.join_marks(seam.axis)
    if marked and rank.grid.weighs:
        rank.call(release_light, rank.grid.field, rank.grid.marks, mass_unit(rank))


def particle_forcing(
    rank: RankState, update: VertexUpdate, loads: Loads, controlled: bool | float
) -> Forcing:
    """Forcing of the particles in a step, without vertex-only loads; see `vertex_update`."""
    t, constraints = update.t, update.forcing.marked[0] if update.forcing.marked else ()
    if loads.approached:
        loads = loads._replace(approached=())
    return Forcing(
        t.dt, update.forcing.gravity, rank.mass_cutoff, loads, constraints, (),
        update.forcing.position_limits, controlled,
    )  # fmt: skip


def update_particles(
    rank: RankState,
    groups: Sequence[ParticleGroup],
    forcing: Forcing,
    layers: np.ndarray,
    found: Sequence[RangeReport],
) -> RangeReport:
    """Update the particles of some layers from the grid: (26, 27, 29, 30).

    Parameters
    ----------
    groups : sequence of ParticleGroup
        Its particles.
    forcing : Forcing
        From `particle_forcing`.
    layers : (n,) int64
    found : sequence of RangeReport
        Reports of the earlier ranges; this one writes behind them.
    """
    first = 0
    for earlier in found:
        first += len(earlier.changed)
    buffers = rank.error_buffer[len(groups) * len(found) :]
    end, rate, outflow, clamped, held = first, 0.0, 0, 0, 0
    failed: list[int] = []
    for group, call, errors in zip(groups, rank.calls, buffers, strict=False):
        report = Report(rank.vertex_bounds, rank.population.changed[end:], errors)
        own = group.advance(call, rank, forcing, layers, report, not found)
        failed.append(own.failed)
        end, rate, outflow = end + own.changed, max(rate, own.rate), outflow + own.outflow
        clamped, held = clamped + own.clamped, held + own.held
    changed = rank.population.changed[first:end]
    if any(rank.scene.domain.periodic) and not rank.scene.settings.initial:
        _turn(rank, changed)
    return RangeReport(changed, rate, outflow, clamped, held, tuple(failed))


def _turn(rank: RankState, changed: np.ndarray) -> None:
    """Move particles by a period that are beyond a seam: along x of those that `changed` layer."""
    scene, grid, population = rank.scene, rank.grid, rank.population
    rows = population.order[changed]
    for d, joined in enumerate(scene.domain.periodic[1:]):
        bounds, within = rank.vertex_bounds[:, d], grid.inner_bounds[:, d]
        if joined and (bounds[0] < within[0] or bounds[1] > within[1]):
            rows, bounds[:] = population.order, within
    rank.call(
        turn_particles,
        scene.settings.shape,
        scene.order_frame,
        scene.domain.exits,
        population.columns,
        rows,
    )
