"""Facets near material in the current configuration, what it fills there, and how it moves."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from pgimp.jit.rehearsal import needed
from pgimp.kernels.contact.impulses.pairs import SeparatingWalls
from pgimp.kernels.contact.impulses.reference_grid import (
    REFERENCE_VERTEX,
    ReferenceVertices,
    read_reference_vertices,
)
from pgimp.kernels.contact.material.filled import SUMS, find_material_gaps
from pgimp.kernels.contact.material.movers import choose_cells
from pgimp.kernels.contact.material.particles import (
    copy_material,
    greatest_speed,
    no_material,
    sort_material,
)
from pgimp.kernels.contact.surfaces.data import Surface, SurfaceCells, no_facets
from pgimp.kernels.contact.surfaces.motion import move_facets
from pgimp.kernels.contact.surfaces.patches.levels import NEAR
from pgimp.kernels.contact.surfaces.search import keys_of_vertices
from pgimp.kernels.grid.conditions import Holding
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.contact.impulses.messages import greatest, swap
from pgimp.solver.contact.material.region import NearRegion
from pgimp.solver.contact.surfaces.proximity import TRAVEL, Proximity
from pgimp.solver.contact.surfaces.shares import Near, select
from pgimp.solver.contact.surfaces.table import Table, bits_of, records_of
from pgimp.solver.rank_state import RankState


class Met(NamedTuple):
    """Material before facets, on the root."""

    every: np.ndarray  #: (n,) NEAR_FACET: The facets, by patch and body, with their gaps.
    surface: Surface  #: All facets, and for each of these one in the cell that moves its place.
    cells: SurfaceCells  #: The cells of facets, and these.
    vertices: ReferenceVertices  #: The vertices of both, by their keys.
    speed: float  #: Greatest component of a velocity of these vertices.


class NearMaterial(Proximity):
    """Finds the facets near material in the current configuration, for several steps.

    Parameters
    ----------
    table : Table
        The surfaces.
    acts : (bodies and rigid bodies, bodies) bool
        Whether the facets of a body meet another, which is in the current configuration.
    groups, fields : (bodies,) int64
        Groups of bonded bodies, and velocity fields.

    Attributes
    ----------
    surface : Surface
        The facets, which are where this found them last.
    """

    def __init__(
        self, scene: Scene, comm: Communicator, walls: SeparatingWalls, table: Table,
        acts: np.ndarray, groups: np.ndarray, fields: tuple[int, ...],
    ) -> None:  # fmt: skip
        super().__init__(scene, comm, walls)
        self.near: Near | None = None
        self._met, taken = np.flatnonzero(acts.any(axis=1)), acts.any(axis=0)
        self._groups, own = np.where(taken, groups, -1), np.array(fields, np.int64)
        self._slots = np.unique(own[taken])
        slot = np.where(taken, np.searchsorted(self._slots, own), -1)
        self._region, self._fields = NearRegion(scene, comm, slot), 1 + int(own.max(initial=0))
        self._plain = scene.setting.without_materials()._replace(shape=scene.settings.uncut)
        # Facets far from others are beyond reach in the surface that they look for.
        now, turned = table.surface.now.copy(), table.surface.turned.copy()
        self.surface = table.surface._replace(now=now, turned=turned)
        self._buffer, self._order = no_material(0), np.empty(0, np.int64)
        self._start = np.empty(1, np.int64)
        self._sums = np.empty((len(groups), SUMS)), np.empty(len(groups), np.int64)
        self._room = no_facets(0), np.empty((0, 3))
        #: Keys and values of all vertices; those of a rank, of all ranks, and how many each has.
        self._keys, self._values = np.empty(0, np.int64), np.empty(0, REFERENCE_VERTEX)
        self._own, self._every, self._counts = np.empty((3, 0), np.int64)
        self._column = np.empty(0, np.int64)  # of the facets' cells among these
        self._extended: tuple[Surface, SurfaceCells] | None = None

    def look(self, rank: RankState, table: Table, rigid: Any, dt: float, rate: float) -> None:
        """Search, if any facets may have come near material since; collective."""
        self.locate(rank, table)
        p, order = rank.population.up_to_date(), rank.population.order
        fastest = float(self.call(greatest_speed, self.scene.domain.frame, p, order)) * dt
        travel = greatest(self.comm, max(fastest, self.way(rank, dt), rate * dt))
        self._moved += travel
        if self.near is not None and self._moved <= TRAVEL:
            return
        self._moved = travel
        self._find_root(rank)
        some = np.flatnonzero(np.isin(table.body, self._met))
        low, high = self.boxes(rank, table, rigid)
        some = some[self._region.find(rank, low[some], high[some], order)]
        facets = table.facets(some)
        facets = facets[np.argsort(table.surface.patch[facets], kind="stable")]
        self.near = select(self.comm, table, facets, self._records)
        self._number(rank)
        self._know_owners(rank)

    def locate(self, rank: RankState, table: Table) -> None:
        """See `Proximity._locate`, if vertices may have changed ranks; the root has all pairs."""
        if self._window is rank.grid.window:
            return
        self._window, self._records = rank.grid.window, records_of(rank, table.numbers)
        self._find_root(rank)
        if self.near is not None:
            self.near = select(self.comm, table, self.near.facets, self._records)
            self._know_owners(rank)

    def _number(self, rank: RankState) -> None:
        """Number the vertices of facets and of material together, by their keys."""
        near, number = self.near, self._region.region.number
        assert near is not None
        numbers = self._region.numbers
        self._numbers = np.column_stack([numbers[:, :3], self._slots[numbers[:, 3]]])
        keys = np.empty(len(numbers), np.int64)
        bits = bits_of(rank.grid.frame, self._fields)
        self.call(keys_of_vertices, bits, self._numbers, keys)
        both = np.concatenate([near.keys, keys])
        order = np.argsort(both, kind="stable")
        self._place = np.empty(len(both), np.int64)
        self._place[order] = np.arange(len(both))
        self._keys, self._values = both[order], np.empty(len(both), REFERENCE_VERTEX)
        known = len(near.keys)
        marked = number >= 0
        number[marked] = self._place[known + number[marked]]
        # Columns of other cells are numbers of no vertex here: they are not looked at.
        column = np.clip(near.cells.column, 0, max(known - 1, 0))
        self._column = self._place[column] if known else column
        self._start = np.empty(self._region.cells + 1, np.int64)
        self._extended = None

    def _know_owners(self, rank: RankState) -> None:
        """Find which of these vertices are on which rank; collective."""
        near = self.near
        assert near is not None
        own = np.flatnonzero(records_of(rank, self._numbers) >= 0)
        self._own = self._place[np.concatenate([near.own, len(near.keys) + own])]
        every = self.comm.allgather(self._own)
        self._every, self._counts = np.concatenate(every), np.array([len(each) for each in every])

    def meet(self, rank: RankState, rigid: Any, holding: Holding) -> Met | None:
        """The material before facets, on the root, None on others and without any; collective."""
        near, call, frame = self.near, self.call, self.scene.domain.frame
        assert near is not None
        material, there = self._copies(rank), self._read(rank, holding)
        u = near.displacements(rank, self.root)
        if material is None or u is None or not there:
            return None
        call(move_facets, frame, rigid, self.surface, near.cells, u, near.facets, self.scratch)
        every, into = self._gaps(near.facets, material)
        if not needed(len(every)):
            return None
        surface, cells = self._with_room(len(every))
        first = len(surface.cell) - (len(cells.start) - 1 - len(cells.low))
        every["other"] = first + np.arange(len(every))
        columns = cells.column[len(self._column) :].reshape(-1, 2**self.scene.dimension)
        region = self._region.region
        speed = call(choose_cells, frame, region, every, into, self._values, columns[: len(every)])
        return Met(every, surface, cells, ReferenceVertices(self._keys, self._values), float(speed))

    def gaps(self, rank: RankState, rigid: Any) -> tuple[np.ndarray, np.ndarray]:
        """Facets, and their gaps to material as everything is now, on all ranks; collective."""
        found = np.empty(0, np.int64), np.empty(0)
        if self.near is None or not self.near.any:
            return found
        near, material = self.near, self._copies(rank)
        u = near.displacements(rank, self.root)
        if material is not None and u is not None:
            of = self.surface, near.cells, u, near.facets, self.scratch
            self.call(move_facets, self.scene.domain.frame, rigid, *of)
            every, _ = self._gaps(near.facets, material)
            found = every["facet"].copy(), every["gap"].copy()
        return found if self.comm.size == 1 else self.comm.bcast(found, self.root)

    def _copies(self, rank: RankState) -> tuple[Any, ...] | None:
        """The particles near facets by cells, on the root, None on others; collective."""
        p, order, region = rank.population.up_to_date(), rank.population.order, self._region.region
        of = self._plain, region, p, order
        while (count := self.call(copy_material, *of, self._buffer)) > len(self._buffer):
            self._buffer = no_material(count + count // 4)
        table = self._buffer[:count]
        if self.comm.size > 1:
            parts = self.comm.gather(table, self.root)
            if parts is None:
                return None
            table = np.concatenate(parts)
        if len(self._order) < len(table):
            self._order = np.empty(len(table) + len(table) // 4, np.int64)
        reach = float(self.call(sort_material, table, self._start, self._order))
        return table, self._order, self._start, reach, region

    def _gaps(self, facets: np.ndarray, material: tuple[Any, ...]) -> tuple[np.ndarray, np.ndarray]:
        """The gaps of facets, by patch and body, and the directions into the other body."""
        far = max(NEAR, self.far / min(self.scene.domain.frame.cell))
        frame, sums = self.scene.domain.frame, self._sums
        of = frame, self.surface, facets, material, self._groups, far, sums
        while (found := self.call(find_material_gaps, *of, self._room)) > len(self._room[0]):
            self._room = no_facets(2 * found), np.empty((2 * found, 3))
        every, into = self._room[0][:found], self._room[1][:found]
        if len(self._slots) > 1:
            patch = self.surface.patch[every["facet"]]
            order = np.lexsort((every["facet"], every["body"], patch))
            every, into = every[order], np.ascontiguousarray(into[order])
        return every, into

    def _with_room(self, count: int) -> tuple[Surface, SurfaceCells]:
        """Facets and cells, with so many of the other bodies' behind them, at least."""
        near, size = self.near, 2**self.scene.dimension
        assert near is not None
        last, cells = len(self.surface.cell), near.cells
        if self._extended and len(self._extended[0].cell) >= last + count:
            return self._extended
        n, entries = 2 * count, cells.start[-1]
        surface = self.surface._replace(
            cell=np.concatenate([self.surface.cell, len(cells.low) + np.arange(n)]),
            normal=np.concatenate([self.surface.normal, np.zeros((n, 3))]),
            tip=np.concatenate([self.surface.tip, np.zeros(n, np.uint8)]),
        )
        more = cells._replace(
            corners=cells.corners[:0],  # vertices have other numbers here
            start=np.concatenate([cells.start, entries + size * np.arange(1, n + 1)]),
            column=np.concatenate([self._column, np.zeros(n * size, np.int64)]),
            weight=np.concatenate([cells.weight, np.tile(np.eye(size), (n, 1))]),
            plain=np.concatenate([cells.plain, np.ones(n, np.bool_)]),
        )
        self._extended = surface, more
        return self._extended

    def _read(self, rank: RankState, holding: Holding) -> bool:
        """Read all vertices' values, on the root; whether this is it; collective."""
        field, values = rank.grid.field, self._values
        if self.comm.size == 1:
            self.call(read_reference_vertices, holding, field, self._keys, values)
            return True
        mine = np.empty(len(self._own), REFERENCE_VERTEX)
        self.call(read_reference_vertices, holding, field, self._keys[self._own], mine)
        sent, received = np.zeros((2, self.comm.size), np.int64)
        sent[self.root] = len(mine)
        if self.comm.rank == self.root:
            received[:] = self._counts
        arrived = swap(self.comm, mine, sent, received)
        if self.comm.rank != self.root:
            return False
        values.view(np.uint8)[:] = 0
        values[self._every] = arrived
        return True
