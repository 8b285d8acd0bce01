"""P2G and G2P of a rank's particles: the kernels' calls by configuration and range of layers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pgimp.jit.bound import Bound
from pgimp.kernels.data.arguments import Forcing, Report
from pgimp.kernels.grid.constrained_vertices import mark_constrained_vertices, release_light
from pgimp.kernels.grid.seam import join_seam
from pgimp.kernels.lagrangian.advance import advance_cells
from pgimp.kernels.lagrangian.cells import Cells
from pgimp.kernels.lagrangian.keep import recall_masses
from pgimp.kernels.loads.loads import Loads
from pgimp.kernels.transfer.g2p import grid_to_particles
from pgimp.kernels.transfer.p2g import Others, particles_to_grid
from pgimp.kernels.update.turns import turn_particles
from pgimp.solver.configurations import ConfigurationGroup
from pgimp.solver.lagrangian.cells import cleared, no_cells, report_cells
from pgimp.solver.rank_state import RankState
from pgimp.solver.vertices import VertexUpdate


class RangeReport(NamedTuple):
    """Outcome of G2P for a range of layers.

    Attributes
    ----------
    changed : (n,) int32
        Offsets in the order of the particles that changed their layer or left.
    rate : float
        Largest (c_p + |v_p|)/L.
    outflow, clamped, held : int
        Particles that left the domain, with a half-width clamped to one cell, and held in by a
        wall.
    failed : tuple of int
        Particles at fault, by configuration.
    """

    changed: np.ndarray
    rate: float
    outflow: int
    clamped: int
    held: int
    failed: tuple[int, ...]


def sum_particles(
    rank: RankState,
    groups: Sequence[ConfigurationGroup],
    loads: Loads,
    marked: bool,
    by_cells: bool = False,
    call: Bound | None = None,
) -> None:
    """Sum a rank's particles into its planes; `Halo.finish` adds the neighbours' sums.

    Parameters
    ----------
    rank : RankState
        The rank.
    groups : sequence of ConfigurationGroup
        Its particles.
    loads : Loads
        The loads on them.
    marked : bool
        Whether constrained vertices are marked.
    by_cells : bool
        Whether lattice particles may be summed cell by cell, without their masses.
    call : Bound, optional
        For loads of other types than the steps have.
    """
    call = call or rank.call
    by_cells &= rank.scene.by_cells and not rank.failed
    grid, population, every = rank.grid, rank.population, []
    particles = population.stored if by_cells else population.particles
    for group in groups:
        order = group.order
        if rank.failed:  # other ranks are not notified yet; such particles may be anywhere
            order = order._replace(start=np.zeros_like(order.start))
        every.append((group.setting.without_materials(), group.loaded(loads.summed()), order))
    if marked:
        for values in grid.marks:
            values.fill(0)
        for each, group, (setting, _, order) in zip(rank.calls, groups, every, strict=True):
            weighs = grid.weighs and (group.lagrangian or not rank.scene.settings.mixed)
            marks = grid.marks if weighs else grid.marks[:1]
            units = _unit(rank) * rank.scene.interaction.loads.least_parts if weighs else ()
            each(mark_constrained_vertices, setting, grid.window, particles, order, marks, units)
    setting, summed, order = every[0]
    others: Others | Cells | tuple[()] = Others(*every[1]) if len(every) > 1 else ()
    if by_cells:
        order, others = rank.lattice.others, cleared(rank.lattice.cells)
    elif rank.scene.by_cells:
        others = no_cells(rank.scene, rank.grid.slab.layers)
    grid.active.fill(0)
    for runs in rank.halo.parts(rank.population.start):  # first the layers neighbours wait for
        call(  # (16, 17, 18, 21, 22)
            particles_to_grid, setting, grid.field, particles, summed, order, runs, others
        )
        rank.halo.proceed(grid, marked)


def finish_sums(rank: RankState, marked: bool = False) -> None:
    """Add the neighbours' sums, and set the masses of vertices that keep them; collective."""
    rank.halo.finish(rank.grid)
    if rank.scene.by_cells:
        _recall_masses(rank)
    join_seams(rank, marked)


def _recall_masses(rank: RankState) -> None:
    """Set the masses of vertices that keep them, where sums have not begun with them."""
    field, known = rank.grid.field, (0, 0)
    if not len(rank.lattice.others.rows) and isinstance(field.used, tuple):
        known = (rank.grid.shared_lower, rank.slab.layers)
    rank.call(recall_masses, field, known)


def join_seams(rank: RankState, marked: bool) -> None:
    """Make one of both copies of the vertices at seams, see `pgimp.kernels.grid.seam`.

    Then all sums are complete, and constraints may release vertices.
    """
    for seam in rank.scene.domain.seams:
        rank.call(join_seam, rank.scene.domain.frame, rank.grid.field, seam)
        if marked:
            rank.grid.join_marks(seam.axis)
    if marked and rank.grid.weighs:
        rank.call(release_light, rank.grid.field, rank.grid.marks, _unit(rank))


def _unit(rank: RankState) -> float:
    """Mass that counts as 1 at constrained vertices: 1e-5 of the least particle's."""
    return 1e7 * rank.mass_cutoff or 1.0


def particle_forcing(
    rank: RankState,
    groups: Sequence[ConfigurationGroup],
    update: VertexUpdate,
    loads: Loads,
    controlled: bool | float,
) -> Forcing:
    """Forcing of the particles in a step, without vertex-only loads; see `vertex_update`."""
    t, constraints = update.t, update.forcing.marked[0] if update.forcing.marked else ()
    if loads.approached:
        loads = loads._replace(approached=())
    return Forcing(
        t.dt, update.forcing.gravity, rank.mass_cutoff, loads, constraints, (),
        update.forcing.position_limits, controlled, (),
        rank.flows.find(rank, groups[0].order, t) if rank.flows else (),
        rank.keeping.at(t, rank.population.stored, rank.population.order),
    )  # fmt: skip


def update_particles(
    rank: RankState,
    groups: Sequence[ConfigurationGroup],
    forcing: Forcing,
    layers: np.ndarray,
    found: Sequence[RangeReport],
) -> RangeReport:
    """Update the particles of some layers from the grid: (26, 27, 29, 30).

    Parameters
    ----------
    rank : RankState
        The rank.
    groups : sequence of ConfigurationGroup
        Its particles.
    forcing : Forcing
        From `particle_forcing`.
    layers : (n,) int64
        The layers.
    found : sequence of RangeReport
        Reports of the earlier ranges; this one writes behind them.
    """
    first = 0
    for report in found:
        first += len(report.changed)
    buffers = rank.error_buffer[len(groups) * len(found) :]
    moved, rate, outflow, clamped, held = 0, 0.0, 0, 0, 0
    failed: list[int] = []
    for group, call, errors in zip(groups, rank.calls, buffers, strict=False):
        mine = rank.population.changed[first + moved :]
        order = rank.lattice.others if rank.scene.by_cells else group.order
        wrong, left, away, fastest, narrow, kept = call(
            grid_to_particles, group.setting, group.bounded(rank.scene, rank.grid.field),
            rank.population.stored, order, layers, group.forced(forcing),
            Report(rank.vertex_bounds, mine, errors), rank.ledger,
        )  # fmt: skip
        if rank.scene.by_cells and not found:
            if rank.scene.cell_loads:
                cells, field = rank.lattice.cells, rank.grid.field
                rank.call(advance_cells, cells, field, rank.population.stored, forcing.dt)
            wrong, fastest = report_cells(rank, errors, wrong, fastest)
        if away and group.rank_in_order is not None:
            mine[:away] = group.rank_in_order[mine[:away]]
        failed.append(wrong)
        rate, moved, outflow = max(rate, fastest), moved + away, outflow + left
        clamped, held = clamped + narrow, held + kept
    changed = rank.population.changed[first : first + moved]
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
        scene.domain.frame,
        scene.domain.exits,
        population.stored,
        rows,
    )
