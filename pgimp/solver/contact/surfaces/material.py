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
from pgimp.kernels.contact.surfaces.data import Surface, SurfaceCells, no_facets
from pgimp.kernels.contact.surfaces.levels import NEAR
from pgimp.kernels.contact.surfaces.material import (
    STEP,
    SUMS,
    TRIES,
    choose_cells,
    copy_material,
    find_material_gaps,
    greatest_speed,
    mark_cells,
    mark_vertices,
    no_material,
    sum_material,
)
from pgimp.kernels.contact.surfaces.motion import move_facets
from pgimp.kernels.contact.surfaces.search import keys_of_vertices
from pgimp.kernels.data.motion import KEPT_VELOCITY
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.grid.conditions import Holding
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.contact.grown import grown
from pgimp.solver.contact.impulses.messages import greatest, united
from pgimp.solver.contact.surfaces.proximity import LONGEST, TRAVEL, Proximity
from pgimp.solver.contact.surfaces.shares import Near, select
from pgimp.solver.contact.surfaces.table import Table, bits_of, records_of
from pgimp.solver.rank_state import RankState

#: Farther than any bin or vertex.
FAR = 1 << 40

#: Cells from a facet within which particles count, and how far vertices that move a place are.
_WITHIN, _AWAY = 2.0, 2 + int(STEP * TRIES)


class Met(NamedTuple):
    """Material before facets, on the root."""

    every: np.ndarray  #: (n,) NEAR_FACET: The facets, by patch and body, with their gaps.
    surface: Surface  #: All facets, and for each of these one in the cell that moves its place.
    cells: SurfaceCells  #: The cells of facets, and these.
    vertices: ReferenceVertices  #: The vertices of both.
    speed: float  #: Greatest component of a velocity: of all vertices of surfaces, and of material.


class NearMaterial(Proximity):
    """Finds the facets near material in the current configuration, for several steps.

    Parameters
    ----------
    acts : (bodies and rigid bodies, bodies) bool
        Whether the facets of a body meet another, which is in the current configuration.
    groups, fields : (bodies,) int64
        Groups of bonded bodies, and velocity fields.
    """

    def __init__(
        self, scene: Scene, comm: Communicator, walls: SeparatingWalls, acts: np.ndarray,
        groups: np.ndarray, fields: tuple[int, ...],
    ) -> None:  # fmt: skip
        super().__init__(scene, comm, walls)
        self._met = np.flatnonzero(acts.any(axis=1))
        self._taken = acts.any(axis=0).astype(np.uint8)
        self._groups = np.where(self._taken, groups, -1)
        self._fields = np.array(fields, np.int64)
        self._plain = scene.setting.without_materials()._replace(
            frame=scene.domain.frame, shape=scene.settings.uncut
        )
        self._low, self._marks = np.zeros(3, np.int64), np.zeros((0, 0, 0), np.uint8)
        self._surface: Surface | None = None
        self.near: Near | None = None

    def look(self, rank: RankState, table: Table, rigid: Any, dt: float, rate: float) -> None:
        """Search, if any facets may have come near material since; collective."""
        if self._window is not rank.grid.window:
            self._locate(rank, table)
        self._pause -= 1
        if self._pause >= 0:
            return
        p, order = rank.population.up_to_date(), rank.population.order
        frame = self.scene.domain.frame
        fastest = greatest(self.comm, float(self.call(greatest_speed, frame, p, order)))
        travel = max(fastest, self._speed(rank) / min(frame.cell), rate) * dt
        self._pause = int(max(1.0, min(LONGEST, TRAVEL / travel if travel > 0.0 else LONGEST))) - 1
        self._find_root(rank)
        near = self._near_clusters(rank, table, *self.boxes(rank, table, rigid))
        surface = table.surface
        # Facets far from others are beyond reach in the surface that they look for.
        self._surface = surface._replace(now=surface.now.copy(), turned=surface.turned.copy())
        facets = table.facets(near)
        facets = facets[np.argsort(surface.patch[facets], kind="stable")]
        self.near = select(self.comm, table, facets, self._records)

    def _locate(self, rank: RankState, table: Table) -> None:
        """See `Proximity._locate`; the root has all pairs."""
        self._window, self._records = rank.grid.window, records_of(rank, table.numbers)
        self._find_root(rank)
        if self.near is not None:
            self.near = select(self.comm, table, self.near.facets, self._records)

    def _speed(self, rank: RankState) -> float:
        """Greatest component of a velocity of the surfaces' vertices; collective."""
        own = rank.grid.kept.values.reshape(-1, RECORD)[self._records[self._records >= 0]]
        v = own[:, KEPT_VELOCITY : KEPT_VELOCITY + self.scene.dimension]
        return greatest(self.comm, float(np.abs(v).max(initial=0.0)))

    def _near_clusters(
        self, rank: RankState, table: Table, low: np.ndarray, high: np.ndarray
    ) -> np.ndarray:
        """Clusters of facets that may meet material; marks the cells around them; collective."""
        frame, D = self.scene.domain.frame, self.scene.dimension
        some = np.flatnonzero(np.isin(table.body, self._met))
        origin, inverse = np.array(frame.origin), np.array(frame.inverse)
        away = _WITHIN + 2.0 * TRAVEL
        ends = np.zeros((2, len(some), 3))
        ends[0, :, :D] = np.floor((low[some] - origin) * inverse - away)
        ends[1, :, :D] = np.floor((high[some] - origin) * inverse + away)
        most = np.ones(3)
        most[:D] = frame.cells
        first, last = np.clip(ends, -1.0, most).astype(np.int64)
        inside = np.flatnonzero((ends[0] <= most).all(axis=1) & (ends[1] >= -1.0).all(axis=1))
        some, first, last = some[inside], first[inside], last[inside]
        self._low = first.min(axis=0) if len(some) else np.zeros(3, np.int64)
        extent = last.max(axis=0, initial=-1) - self._low + 1
        marks = np.zeros(extent, np.uint8)
        p, order = rank.population.up_to_date(), rank.population.order
        self.call(mark_cells, frame, p, order, self._taken, self._low, marks)
        marks = united(self.comm, marks)
        counts = np.zeros(extent + 1, np.int64)
        counts[1:, 1:, 1:] = marks.cumsum(axis=0).cumsum(axis=1).cumsum(axis=2)
        a, b = (first - self._low).T, (last - self._low + 1).T
        inside_of = np.zeros(len(some), np.int64)
        for corner in range(8):
            upper = [corner >> d & 1 for d in range(3)]
            at = tuple(b[d] if upper[d] else a[d] for d in range(3))
            inside_of += (-1) ** (3 - sum(upper)) * counts[at]
        near = inside_of > 0
        self._marks = np.zeros(extent, np.uint8)
        for begin, end in zip(a.T[near].tolist(), b.T[near].tolist(), strict=True):
            self._marks[tuple(slice(i, j) for i, j in zip(begin, end, strict=True))] = 1
        return some[near]

    def meet(self, rank: RankState, rigid: Any, holding: Holding) -> Met | None:
        """The material before facets, on the root, None on others and without any; collective."""
        near, call, frame = self.near, self.call, self.scene.domain.frame
        assert near is not None and self._surface is not None
        surface, p, order = self._surface, rank.population.up_to_date(), rank.population.order
        cells = self._low, self._marks
        table, count = grown(
            1024, no_material,
            lambda room: call(copy_material, self._plain, p, order, self._taken, cells, room),
        )  # fmt: skip
        parts = [table[:count]]
        if self.comm.size > 1:
            parts = self.comm.gather(table[:count], self.root)
        mine = np.empty(len(near.own), REFERENCE_VERTEX)
        call(read_reference_vertices, holding, rank.grid.field, near.keys[near.own], mine)
        u, values = near.displacements(rank, self.root), near.on_root(self.comm, self.root, mine)
        every, into, marks, low = no_facets(0), np.zeros((0, 3)), np.zeros((0, 0, 0, 0)), self._low
        if u is not None:
            call(move_facets, frame, rigid, surface, near.cells, u, near.facets, self.scratch)
            every, into = self._gaps(surface, near.facets, np.concatenate(parts))
            low, marks = self._marked_vertices(every, into)
        numbers = np.ascontiguousarray(np.argwhere(marks) + np.append(low, 0))
        if self.comm.size > 1:
            numbers = self.comm.bcast(numbers, self.root)
        if not needed(len(numbers)):
            return None
        found, speed = self._read(rank, holding, numbers), self._speed(rank)
        if values is None or found is None:
            return None
        corners = np.zeros((len(every), 2 ** len(frame.cell)), np.int64)
        marks[marks > 0] = np.arange(len(numbers))
        call(choose_cells, frame, every, into, self._fields, (low, marks),
             np.ascontiguousarray(found.values["mass"]), corners)  # fmt: skip
        speed = max(speed, float(np.abs(found.values["velocity"]).max(initial=0.0)))
        known = ReferenceVertices(near.keys, values)
        return Met(every, *_joined(surface, near, known, every, corners, found), speed)

    def _gaps(
        self, surface: Surface, facets: np.ndarray, table: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """The gaps of facets, by patch and body, and the directions into the other body."""
        frame, D, call = self.scene.domain.frame, self.scene.dimension, self.call
        side = np.ones(3)
        side[:D] = (1.0 + table["half"][:, :D].max(axis=0, initial=0.5)) * frame.cell
        bins = np.floor(table["position"] / side).astype(np.int64)
        low = bins.min(axis=0, initial=FAR) - 1
        end = bins.max(axis=0, initial=-FAR) + 2
        x = np.floor(surface.now[facets] / side)
        facets = facets[((x >= low) & (x < end)).all(axis=1)]
        many = [int(each) for each in np.maximum(end - low, 1)]
        strides = np.array([(many[1] * many[2], many[2], 1), (many[1], 1, 0), (1, 0, 0)][3 - D])
        key = (bins - low) @ strides
        order = np.lexsort((table["id"], key))
        sums = np.zeros((len(facets), len(self._groups), SUMS))
        keys = key[order], strides, low, side
        call(sum_material, frame, surface, facets, table[order], keys, sums)

        def fill(room: tuple[np.ndarray, np.ndarray]) -> int:
            return int(call(find_material_gaps, frame, surface, facets, sums, self._groups,
                            max(NEAR, self.far / min(frame.cell)), *room))  # fmt: skip

        (every, into), found = grown(
            len(facets), lambda room: (no_facets(room), np.empty((room, 3))), fill
        )
        every, into = every[:found], into[:found]
        order = np.lexsort((every["facet"], every["body"], surface.patch[every["facet"]]))
        return every[order], np.ascontiguousarray(into[order])

    def _marked_vertices(
        self, every: np.ndarray, into: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """The least vertex, and marks of those that may move places in other bodies."""
        frame, D = self.scene.domain.frame, self.scene.dimension
        low, extent, last = np.zeros(3, np.int64), np.ones(3, np.int64), np.array(frame.cells) - 1
        at = (every["place"][:, :D] - np.array(frame.origin)) * np.array(frame.inverse)
        cell = np.clip(np.floor(at), 0, last).astype(np.int64)
        low[:D] = np.clip(cell.min(axis=0, initial=FAR) - _AWAY, 0, last) + frame.ghost
        end = np.clip(cell.max(axis=0, initial=-FAR) + _AWAY, 0, last) + frame.ghost
        extent[:D] = np.maximum(end - low[:D] + 2, 0)
        marks = np.zeros((*extent, 1 + int(self._fields.max())), np.int64)
        self.call(mark_vertices, frame, every, into, self._fields, low, marks)
        return low, marks

    def _read(
        self, rank: RankState, holding: Holding, numbers: np.ndarray
    ) -> ReferenceVertices | None:
        """Vertices by their numbers and fields, on the root; collective."""
        keys = np.empty(len(numbers), np.int64)
        self.call(keys_of_vertices, bits_of(rank.grid.frame, 1 + int(self._fields.max())),
                  numbers, keys)  # fmt: skip
        own = np.flatnonzero(records_of(rank, numbers) >= 0)
        mine = np.empty(len(own), REFERENCE_VERTEX)
        self.call(read_reference_vertices, holding, rank.grid.field, keys[own], mine)
        parts = [(own, mine)]
        if self.comm.size > 1:
            parts = self.comm.gather((own, mine), self.root)
            if parts is None:
                return None
        values = np.zeros(len(keys), REFERENCE_VERTEX)
        for some, each in parts:
            values[some] = each
        return ReferenceVertices(keys, values)


def _joined(
    surface: Surface, near: Near, known: ReferenceVertices, every: np.ndarray,
    corners: np.ndarray, found: ReferenceVertices,
) -> tuple[Surface, SurfaceCells, ReferenceVertices]:  # fmt: skip
    """Facets, cells and vertices with those of the other bodies behind them."""
    n, size = corners.shape
    last, cells = len(surface.cell), near.cells
    every["other"] = last + np.arange(n)
    both = surface._replace(
        cell=np.concatenate([surface.cell, len(cells.low) + np.arange(n)]),
        normal=np.concatenate([surface.normal, np.zeros((n, 3))]),
    )
    more = cells._replace(
        start=np.concatenate([cells.start, cells.start[-1] + size * np.arange(1, n + 1)]),
        column=np.concatenate([cells.column, len(known.keys) + corners.reshape(-1)]),
        weight=np.concatenate([cells.weight, np.tile(np.eye(size), (n, 1))]),
    )
    vertices = ReferenceVertices(
        np.concatenate([known.keys, found.keys]), np.concatenate([known.values, found.values])
    )
    return both, more, vertices
