"""Mean dilatation of bodies that are exact to their surface: means over what cells hold.

A cell that a surface cuts has one dilatation: the mean over all that it holds of a body, and not
that at its centre. So with V_p the volumes of its particles, G = sum V_p F_p/sum V_p and the mean
stress p = sum V_p p_p/sum V_p, and the force on a vertex is

    -sum_p V_p (r_p (s_p - p_p 1) cof(r_p F_p) + p cof(G)) grad0 S_vp.

Under uniform stress that is the integral over the surface, and the energy of r_p F_p is its
potential. By Jensen's inequality no frequency is above that without means.

A cell with a slave (`pgimp.solver.lagrangian.slaves`) moves, there, as the cell of its masters
says: it has hardly any motion of its own, and a volume of its own would lock it. So it shares the
dilatation of that cell: means are over both, as pressures of aggregated unfitted elements are.

Whole cells that share it with none stay lattice cells, see `pgimp.solver.lagrangian.cells`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from pgimp.kernels.data.arguments import Field, Forcing, Order
from pgimp.kernels.lagrangian.displace import place_particles
from pgimp.kernels.lagrangian.group_means import CellGroups, set_means, sum_cells
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.lagrangian.masters import Vertices
from pgimp.solver.rank_state import RankState
from pgimp.solver.vertices import StepPart


class _Shared(NamedTuple):
    """Which sums over cells ranks exchange, until their planes change."""

    cells: np.ndarray  #: (n,) int64: The cells of all ranks that others need, by rank.
    counts: np.ndarray  #: (ranks,) int64: How many of them each rank has.


class MeanDilatation(StepPart):
    """Mean dilatation over what cells hold, on one rank.

    Attributes
    ----------
    cells, roots : (n,) int64
        Cells with slaves, ascending, and the cells with which they share their dilatation. Numbers
        are those of their first vertices, see `Vertices.key`.
    """

    def __init__(
        self, scene: Scene, comm: Communicator, before: MeanDilatation | None = None
    ) -> None:
        self.scene, self.comm = scene, comm
        self.cells = self.roots = np.zeros(0, np.int64)
        self._rows = np.zeros(0, np.int32)
        self._order: Order  # of the step's particles
        #: Those of the stage before, until the stage has its own.
        self._before = (before.cells, before.roots) if before else None
        self._field: Field | None = None
        self._shared: _Shared
        self._groups: CellGroups
        #: Places of the exchanged cells among the rank's, -1 for those of groups that it lacks.
        self._places = np.zeros(0, np.int64)
        self._apart = np.empty(0)  # where positions go that nobody needs

    def find(self, rank: RankState) -> None:
        """Find the cells with slaves, and their roots: with most of their slaves as masters.

        Particles that are with others than in the stage before keep their dilatation over that of
        their displacements: from here on they are alone, see `Particles.isolation`.
        """
        self._find_roots(rank)
        if self._before is None:
            return
        cells, were = _labels(self._before, self.cells)
        _, are = _labels((self.cells, self.roots), self._before[0])
        self._before, changed = None, np.unique(np.stack([were, are])[:, were != are])
        p, rows = rank.population.columns, rank.population.ordered.rows
        under = Vertices.cells_under(rank, rows)
        at = np.minimum(np.searchsorted(cells, under), max(len(cells) - 1, 0))
        known = cells[at] == under if len(cells) else np.zeros(len(rows), bool)
        for labels in (were, are):
            label = np.where(known, labels[at], under) if len(cells) else under
            p.isolation[rows[np.isin(label, changed)], 0] = 1.0

    def _find_roots(self, rank: RankState) -> None:
        """Set the cells with slaves, and their roots."""
        slaves = rank.slaves
        self._field = None
        self.cells = self.roots = np.zeros(0, np.int64)
        if not len(slaves.keys):
            return
        cells = Vertices.cells_round(rank, slaves.keys)
        roots = np.broadcast_to(slaves.masters[slaves.of[:, 0]], cells.shape)
        both = np.stack([cells, roots]).reshape(2, -1)
        # Of equally many the one of the first corner, so that cells at seams choose alike.
        pairs, corner, counts = np.unique(
            both[:, both[0] >= 0], axis=1, return_index=True, return_counts=True
        )
        pairs = pairs[:, np.lexsort((corner, -counts, pairs[0]))]
        self.cells, first = np.unique(pairs[0], return_index=True)
        self.roots = pairs[1, first]

    def shares(self, cells: np.ndarray) -> np.ndarray:
        """Whether cells share their dilatation with others."""
        return np.isin(cells, self.cells) | np.isin(cells, self.roots)

    def begin(self, rank: RankState, order: Order, done: int) -> None:
        """Find the mean stresses that the forces take; collective."""
        self._order = self._particles(rank)
        groups, p = self._located(rank), rank.population.columns
        rows, normal = groups.rows, 3 if p.F.shape[1] > 4 else 2
        mean = p.sigma[rows, 0] + p.sigma[rows, 1]
        if normal == 3:
            mean += p.sigma[rows, 2]
        mean /= normal
        if p.q.shape[1]:
            mean -= p.q[rows, 0]
        p.mean_stress[rows, 0] = (1.0 - p.isolation[rows, 0]) * mean
        self._average(rank, p.mean_stress)

    def force_particles(self, rank: RankState, order: Order, t: Any, forcing: Forcing) -> Forcing:
        """Find the deformation gradients of the groups after the step; collective."""
        self._located(rank)
        p, scene = rank.population.columns, self.scene
        if self._apart.shape != p.x.shape:
            self._apart = np.empty_like(p.x)
        found = p._replace(x=self._apart, F=p.cell_F)
        setting = scene.setting_lagrangian if scene.settings.mixed else scene.setting
        args = setting, scene.domain.frame, rank.grid.motion_field, found
        rank.call(place_particles, *args, self._order)
        self._average(rank, p.cell_F)
        return forcing

    def _average(self, rank: RankState, values: np.ndarray) -> None:
        """Set a column of the particles in groups to their means; collective."""
        groups, shared = self._groups, self._shared
        sums = np.zeros((len(groups.start) - 1, 1 + values.shape[1]))
        rank.call(sum_cells, groups, rank.population.columns.V0, values, sums)
        if len(shared.cells):
            begin = int(shared.counts[: self.comm.rank].sum())
            mine = self._places[begin : begin + shared.counts[self.comm.rank]]
            sent = np.zeros((int(shared.counts.max()), sums.shape[1]))
            sent[: len(mine)] = sums[mine]
            found = np.empty((self.comm.size, *sent.shape))
            self.comm.Allgather(sent, found)
            known = found[np.arange(len(sent))[None] < shared.counts[:, None]]
            here = self._places >= 0
            sums[self._places[here]] = known[here]
        rank.call(set_means, groups, sums, values)

    def _located(self, rank: RankState) -> CellGroups:
        """The rank's groups; collective when planes or window have changed."""
        moved, rows = self._field is not rank.grid.field, self._order.rows
        if not moved and (self._rows is rows or np.array_equal(self._rows, rows)):
            return self._groups
        cells = self._numbers(rank, rows)
        own = np.unique(cells)
        if moved:
            self._find_shared(own)
        self._field, self._rows = rank.grid.field, rows
        # All cells of the rank's groups, by group.
        every = np.unique(np.concatenate([own, self._shared.cells]))
        every = every[np.isin(self._group_of(every), self._group_of(own))]
        of = self._group_of(every)
        sorting = np.lexsort((every, of))
        place = np.empty(len(every), np.int64)
        place[sorting] = np.arange(len(every))
        mine = place[np.searchsorted(every, cells)]
        start = np.concatenate([[0], np.cumsum(np.bincount(mine, minlength=len(every)))])
        first = np.searchsorted(of[sorting], np.append(np.unique(of), np.iinfo(np.int64).max))
        sorted_rows = rows[np.argsort(mine, kind="stable")].astype(np.int64)
        self._groups = CellGroups(first, start, sorted_rows)
        shared = self._shared.cells
        known = np.isin(shared, every)
        self._places = np.full(len(shared), -1)
        self._places[known] = place[np.searchsorted(every, shared[known])]
        return self._groups

    def _particles(self, rank: RankState) -> Order:
        """The particles with means over what their cells hold."""
        if not self.scene.settings.mixed:
            return rank.lattice_cells().off_lattice  # type: ignore[no-any-return]
        order = rank.population.ordered
        mine = self.scene.settings.lagrangian[rank.population.columns.body[order.rows]]
        return Order(order.rows[mine], np.concatenate([[0], np.cumsum(mine)])[order.start])

    def _find_shared(self, own: np.ndarray) -> None:
        """Find the cells whose sums other ranks need, given the rank's cells; collective."""
        bodies = len(self.scene.body_names)
        parts = self.comm.allgather(own[self.shares(own // bodies)])
        groups = [np.unique(self._group_of(part)) for part in parts]
        found, ranks = np.unique(np.concatenate(groups), return_counts=True)
        wide = found[ranks > 1]
        parts = [part[np.isin(self._group_of(part), wide)] for part in parts]
        self._shared = _Shared(np.concatenate(parts), np.array([len(part) for part in parts]))

    def _numbers(self, rank: RankState, rows: np.ndarray) -> np.ndarray:
        """Numbers of the cells of particles, one for each body."""
        body = rank.population.columns.body[rows]
        return Vertices.cells_under(rank, rows) * len(self.scene.body_names) + body

    def _group_of(self, cells: np.ndarray) -> np.ndarray:
        """Numbers of the groups of cells, by their `_numbers`."""
        bodies = len(self.scene.body_names)
        keys, body = np.divmod(cells, bodies)
        if not len(self.cells):
            return cells
        at = np.minimum(np.searchsorted(self.cells, keys), len(self.cells) - 1)
        return np.where(self.cells[at] == keys, self.roots[at], keys) * bodies + body


def mean_dilatation_of(
    scene: Scene, comm: Communicator, before: MeanDilatation | None = None
) -> MeanDilatation | None:
    """The mean dilatation of a scene with bodies exact to their surface; None for others."""
    averages = scene.interaction.loads.mean_lagrangian
    if isinstance(averages, tuple) or not scene.settings.exact_surfaces.any():
        return None
    return MeanDilatation(scene, comm, before)


def _labels(
    table: tuple[np.ndarray, np.ndarray], others: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Cells of a table and others, ascending, with the roots of all; of others themselves."""
    cells = np.union1d(table[0], others)
    roots = cells.copy()
    roots[np.searchsorted(cells, table[0])] = table[1]
    return cells, roots
