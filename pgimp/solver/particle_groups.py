"""Groups of a rank's particles: kernels take each with a setting of its own.

Most scenes have one. In cases with both configurations the bodies in the initial one are a second
group, with velocity fields of their own on shared vertices. Where all bodies are in the initial
configuration, particles on the lattice are summed and updated cell by cell.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from pgimp.decomposition.population import Population
from pgimp.jit.bound import Bound
from pgimp.kernels.data.arguments import Field, Forcing, KernelScene, Order, Report
from pgimp.kernels.data.particles import Particles
from pgimp.kernels.grid.constrained_vertices import mark_constrained_vertices
from pgimp.kernels.lagrangian.advance import advance_cells
from pgimp.kernels.lagrangian.cells import Cells
from pgimp.kernels.lagrangian.keep import recall_masses
from pgimp.kernels.loads.loads import Loads
from pgimp.kernels.order.split import split_order
from pgimp.kernels.step.g2p import grid_to_particles
from pgimp.kernels.step.p2g import SecondGroup
from pgimp.kernels.sums.sums import fastest_rate
from pgimp.scene.scene import Scene
from pgimp.solver.lagrangian.cells import LatticeCells, cleared, no_cells, report_cells
from pgimp.solver.rank_state import RankState


class GroupReport(NamedTuple):
    """Outcome of G2P for a group, in a range of layers."""

    #: failed, outflow, changed: Particles at fault; that left the domain; that changed their layer
    #: or left.
    failed: int
    outflow: int
    changed: int
    rate: float  #: Largest (c_p + |v_p|)/L.
    #: clamped, held: Particles with a half-width clamped to one cell, and held in by a wall.
    clamped: int
    held: int


@dataclass
class ParticleGroup:
    """Particles of one setting: all, or those in the current configuration beside others."""

    setting: KernelScene  #: The scene for kernels.
    order: Order  #: The particles; all groups have the same layers.
    #: (n,) int32 or None: Their offsets in the order of all particles; None if they are all.
    rank_in_order: np.ndarray | None = None

    #: Whether they are those in the initial configuration beside others.
    lagrangian: ClassVar[bool] = False

    def loaded(self, loads: Loads) -> Loads:
        """The loads on these particles."""
        return loads

    def field(self, rank: RankState) -> Field:
        """The rank's planes, with bounds on the coordinates of these particles."""
        return rank.phases.field if rank.phases else rank.grid.field

    def forced(self, forcing: Forcing) -> Forcing:
        """The forcing of these particles."""
        return forcing

    def columns(self, population: Population) -> Particles:
        """The columns that sums take, of all groups from the first one."""
        return population.up_to_date()

    def second_group(
        self, rank: RankState, more: Sequence[ParticleGroup], loads: Loads
    ) -> SecondGroup | Cells | tuple[()]:
        """What is summed in each layer after these particles: the groups after this one."""
        return SecondGroup(*more[0].summands(loads)) if more else ()

    @property
    def single(self) -> Order:
        """The particles that kernels take one by one."""
        return self.order

    def summands(self, loads: Loads) -> tuple[KernelScene, Loads, Order]:
        """Setting, loads and particles of the sums: (16, 17, 18, 21, 22)."""
        return self.setting.without_materials(), self.loaded(loads.summed()), self.single

    def mark(self, call: Bound, rank: RankState, particles: Particles) -> None:
        """Mark the vertices that constrained particles reach."""
        setting, grid = self.setting.without_materials(), rank.grid
        weighs = grid.weighs and (self.lagrangian or not rank.scene.settings.mixed)
        marks = grid.marks if weighs else grid.marks[:1]
        units = mass_unit(rank) * rank.scene.interaction.loads.least_parts if weighs else ()
        args = setting, grid.window, particles, self.order, marks, units
        call(mark_constrained_vertices, *args)

    def finish_sums(self, rank: RankState) -> None:
        """Complete the sums at the vertices, when those of the neighbours are added."""

    def advance(
        self,
        call: Bound,
        rank: RankState,
        forcing: Forcing,
        layers: np.ndarray,
        report: Report,
        first: bool,
    ) -> GroupReport:
        """Update the particles of some layers from the grid: (26, 27, 29, 30).

        Parameters
        ----------
        call : Bound
            Calls the kernels of the group.
        forcing : Forcing
            The forcing of all particles.
        layers : (n,) int64
        report : Report
            What the kernels fill.
        first : bool
            Whether no other layers have been updated in this step.
        """
        found = GroupReport(
            *call(
                grid_to_particles, self.setting, self.field(rank), rank.population.columns,
                self.single, layers, self.forced(forcing), report, rank.ledger,
            )
        )  # fmt: skip
        if found.changed and self.rank_in_order is not None:
            changed = report.changed[: found.changed]
            changed[:] = self.rank_in_order[changed]
        return found


@dataclass
class InitialGroup(ParticleGroup):
    """Particles in the initial configuration, beside others."""

    lagrangian = True
    mean: float | tuple[()] = ()  #: See `Loads.mean_lagrangian`.

    def loaded(self, loads: Loads) -> Loads:
        """See `ParticleGroup.loaded`."""
        return loads._replace(mean=(), mean_lagrangian=self.mean, affine=(), relaxation=())

    def field(self, rank: RankState) -> Field:
        """See `ParticleGroup.field`."""
        bounds, field = rank.scene.domain.bounds, rank.grid.field
        return field if bounds is None else field._replace(bounds=bounds)

    def forced(self, forcing: Forcing) -> Forcing:
        """See `ParticleGroup.forced`."""
        return forcing._replace(loads=self.loaded(forcing.loads), limits=())


@dataclass
class CellGroup(ParticleGroup):
    """Particles in the initial configuration, of which those on the lattice go cell by cell."""

    #: The cells; None to sum all particles one by one, with their masses.
    lattice: LatticeCells | None = None

    def columns(self, population: Population) -> Particles:
        """See `ParticleGroup.columns`; cells need none that may be out of date."""
        return population.columns if self.lattice else population.up_to_date()

    def second_group(
        self, rank: RankState, more: Sequence[ParticleGroup], loads: Loads
    ) -> SecondGroup | Cells | tuple[()]:
        """See `ParticleGroup.second_group`: the cells."""
        if self.lattice:
            return cleared(self.lattice.cells)
        return no_cells(rank.scene, rank.grid.slab.layers)

    @property
    def single(self) -> Order:
        """See `ParticleGroup.single`: those that are in no cell."""
        return self.lattice.off_lattice if self.lattice else self.order

    def finish_sums(self, rank: RankState) -> None:
        """Set the masses of vertices that keep them, where sums have not begun with them."""
        field, known = rank.grid.field, (0, 0)
        if not len(rank.lattice_cells().off_lattice.rows) and isinstance(field.used, tuple):
            known = (rank.grid.shared_lower, rank.slab.layers)
        rank.call(recall_masses, field, known)

    def advance(
        self,
        call: Bound,
        rank: RankState,
        forcing: Forcing,
        layers: np.ndarray,
        report: Report,
        first: bool,
    ) -> GroupReport:
        """See `ParticleGroup.advance`; cells of all layers go with the first ones."""
        found = super().advance(call, rank, forcing, layers, report, first)
        if not first:
            return found
        if rank.scene.cell_loads:
            cells, p = rank.lattice_cells().cells, rank.population.columns
            rank.call(advance_cells, cells, rank.grid.field, p, forcing.dt)
        failed, rate = report_cells(rank, report.errors, found.failed, found.rate)
        return found._replace(failed=failed, rate=rate)


def groups_of(rank: RankState, by_cells: bool = False) -> tuple[ParticleGroup, ...]:
    """Return the groups of a rank's particles, one or two; valid until their order changes.

    Parameters
    ----------
    by_cells : bool
        Whether lattice particles may be taken cell by cell, without their masses.
    """
    scene, population = rank.scene, rank.population
    order = population.ordered
    if rank.failed:  # other ranks are not notified yet; such particles may be anywhere
        order = order._replace(start=np.zeros_like(order.start))
    if scene.by_cells:
        lattice = rank.lattice_cells() if by_cells and not rank.failed else None
        return (CellGroup(scene.setting, order, lattice=lattice),)
    if not scene.settings.mixed:
        return (ParticleGroup(scene.setting, order),)
    loads = scene.interaction.loads
    rank_in_order = np.empty((2, len(order.rows)), np.int32)
    ends = np.zeros((2, len(order.start)), np.int64)  # as long as the kernel is only noted
    body = population.up_to_date().body
    split_order(scene.settings.lagrangian, body, *order, rank_in_order, ends)
    found = [rank_in_order[i, : ends[i, -1]] for i in range(2)]
    orders = [Order(order.rows[found[i]], ends[i]) for i in range(2)]
    return (
        ParticleGroup(scene.setting, orders[0], found[0]),
        InitialGroup(scene.setting_lagrangian, orders[1], found[1], loads.mean_lagrangian),
    )


def fastest(
    scene: Scene, particles: Particles, rows: np.ndarray, controlled: bool | float
) -> float:
    """`fastest_rate` of the particles in `rows`, in any configuration."""
    return max(
        fastest_rate(setting, particles, those, controlled)
        for setting, those in _by_setting(scene, particles, rows)
    )


def _by_setting(
    scene: Scene, particles: Particles, rows: np.ndarray
) -> Iterator[tuple[KernelScene, np.ndarray]]:
    if not scene.settings.mixed:
        yield scene.setting.without_shape(), rows
        return
    lagrangian = scene.settings.lagrangian[particles.body[rows]]
    yield scene.setting.without_shape(), rows[~lagrangian]
    yield scene.setting_lagrangian.without_shape(), rows[lagrangian]


def mass_unit(rank: RankState) -> float:
    """Mass that counts as 1 at constrained vertices: 1e-5 of the least particle's."""
    return 1e7 * rank.mass_cutoff or 1.0
