"""Contact of bodies in the initial configuration by their own surfaces.

Of bodies that are exact to their surface, with each other, rigid bodies and unilateral walls.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pgimp.geometry.sweep import close_pairs
from pgimp.jit.rehearsal import needed
from pgimp.kernels.contact.lagrangian.books import book_held
from pgimp.kernels.contact.lagrangian.coupling import Coupling
from pgimp.kernels.contact.lagrangian.pairs import ContactPairs
from pgimp.kernels.contact.lagrangian.reference_grid import (
    REFERENCE_VERTEX,
    ReferenceVertices,
    change_velocities,
    read_reference_vertices,
)
from pgimp.kernels.contact.surfaces.data import SurfaceCells, no_facets
from pgimp.kernels.contact.surfaces.gaps import find_gaps
from pgimp.kernels.contact.surfaces.motion import move_facets
from pgimp.kernels.contact.surfaces.rows import find_patch_pairs
from pgimp.kernels.contact.surfaces.search import bound_clusters, find_meeting
from pgimp.kernels.data.ledger import CONTACT_AREA
from pgimp.kernels.data.motion import DISPLACEMENT, KEPT_VELOCITY
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.grid.conditions import Holding
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.contact.grown import grown
from pgimp.solver.contact.lagrangian.joint import Joint, share
from pgimp.solver.contact.lagrangian.lagrangian import LagrangianContact, nothing_held
from pgimp.solver.contact.lagrangian.messages import greatest, swap
from pgimp.solver.contact.lagrangian.selected import flat
from pgimp.solver.contact.surfaces.table import Table, records_of, table_of
from pgimp.solver.rank_state import RankState
from pgimp.solver.vertices import VertexUpdate

#: Cells within which facets of two bodies are known to each other, and by which each body may move
#: until the next search; the most steps until then.
REACH, TRAVEL, LONGEST = 1.0, 0.25, 16


class Near(NamedTuple):
    """Facets near other bodies, and the vertices that move them; until the next search."""

    meeting: np.ndarray  #: (k, 3) int64: See `find_meeting`.
    facets: np.ndarray  #: (n,) int64: All facets of clusters that meet.
    cells: SurfaceCells  #: Cells with the vertices' numbers among those below.
    keys: np.ndarray  #: (v,) int64: Keys of the vertices that move these facets.
    records: np.ndarray  #: (o,) int64: Records of those that the rank owns.
    own: np.ndarray  #: (o,) int64: Their numbers.
    every: np.ndarray  #: (v,) int64: Numbers of those of all ranks, one rank after the other.
    counts: np.ndarray  #: (ranks,) int64: How many each rank owns.


class SurfaceContact(LagrangianContact):
    """Contact by surfaces: patches of one body, and the nearest facets of another.

    The rank with the first layer finds the gaps, and solves for the impulses, from the vertices of
    all ranks near contact. So nothing depends on the ranks.
    """

    def __init__(self, scene: Scene, comm: Communicator) -> None:
        super().__init__(scene, comm)
        self._table: Table | None = None
        self._slaves: object = None
        self._near: Near | None = None
        self._candidates = no_facets(0)
        self._pause, self._moved = 0, 0.0
        self._before = np.empty((0, 3))
        self._records = np.empty(0, np.int64)
        self._window: object = None
        self._root = 0
        self._facets = np.empty(0, np.int64)
        self._scratch = np.zeros((3, 3)), np.zeros((2**scene.dimension, 3))

    def moved(self) -> None:
        """See `NoContact.moved`: vertices have changed ranks, perhaps."""
        self._pause, self._window = 0, None

    def exchange(self, rank: RankState, update: VertexUpdate) -> None:
        """See `NoContact.exchange`."""
        rigid_bodies, free = self.rigid_bodies, self.free
        t, _, forcing, ledger = update
        ledger.contact[:, :, CONTACT_AREA] = 0.0
        if self.scene.interaction.rigid_bodies:
            self.scene.interaction.rigid_bodies.at(t.start, t.end, free.states if free else None)
        if free:
            free.begin(rigid_bodies, t, forcing.gravity)
        self._dt = t.dt
        rate = max(self.scene.interaction.rigid_bodies.rate, free.rate if free else 0.0)
        self._moved += rate * t.dt
        table = self._known(rank)
        if self._pause <= 0:
            self._search(rank, table, rate * t.dt)
        self._pause -= 1
        near = self._near
        if near is not None and needed(len(near.meeting)):
            self._exchange_near(rank, update, table, near)
        else:
            self._warm_start.clear()
        if free:
            free.end(rigid_bodies, t.dt)

    def _known(self, rank: RankState) -> Table:
        """The surfaces of all bodies; collective when they have to be found."""
        slaves = rank.slaves.keys if rank.slaves else None
        if self._table is None or self._slaves is not slaves:
            self._table, self._slaves = table_of(rank, self.fields), slaves
            self._pause, self._window = 0, None
        return self._table

    def _search(self, rank: RankState, table: Table, rigid_travel: float) -> None:
        """Find the clusters that may meet, and the steps for which that holds; collective."""
        grid, comm, D = rank.grid, self.comm, self.scene.dimension
        frame = self.scene.domain.frame
        values = grid.kept.values.reshape(-1, RECORD)
        if self._window is not grid.window:
            self._window, self._before = grid.window, np.empty((0, 3))
            self._records = records_of(rank, table.numbers)
            self._near = None
        own = self._records >= 0
        motion = values[self._records[own]]
        u = motion[:, DISPLACEMENT : DISPLACEMENT + 3]
        inverse = np.array(frame.inverse)
        speed = np.abs(motion[:, KEPT_VELOCITY : KEPT_VELOCITY + D]) * inverse
        travel = float(speed.max(initial=0.0)) * self._dt
        moved = np.inf
        if self._near is not None and len(self._before) == len(u):
            moved = float((np.abs(u - self._before)[:, :D] * inverse).max(initial=0.0))
        moved = max(greatest(comm, moved), self._moved)
        travel = max(greatest(comm, travel), rigid_travel)
        left = TRAVEL - moved
        if self._near is not None and left > 4.0 * travel:
            self._pause = LONGEST if LONGEST * travel <= left else int(left / travel)
            return
        self._before, self._moved = u.copy(), 0.0
        self._pause = max(1, min(LONGEST, int(TRAVEL / travel) if travel > 0.0 else LONGEST))
        first_layer = grid.slab.layers and grid.slab.lower is None
        self._root = -int(greatest(comm, -comm.rank if first_layer else -comm.size))
        low, high = self._boxes(rank, table)
        self._near = self._select(rank, table, self._meeting(table, low, high))
        self._find_candidates(rank, table, self._near)

    def _boxes(self, rank: RankState, table: Table) -> tuple[np.ndarray, np.ndarray]:
        """Least and greatest coordinates of the clusters; collective."""
        frame, D = self.scene.domain.frame, self.scene.dimension
        cell, motion = np.array(frame.cell), rank.grid.kept
        ends = np.full((2, len(table.body), D), np.inf)
        self.call(
            bound_clusters, frame, table.numbers, self._records, motion,
            (table.owner, table.corner), ends,
        )  # fmt: skip
        ends = _least(self.comm, ends)
        low, high = ends[0] - 0.1 * cell, -ends[1] + 0.1 * cell
        rigid = self.rigid_bodies
        for c in np.flatnonzero(table.body >= self.bodies):
            motion = rigid.motion[table.body[c] - self.bodies]
            some = table.members[table.first[c] : table.first[c + 1]]
            x = (table.surface.x[some] - motion["reference"]) @ motion["rotation"].T
            x += motion["centre"]
            low[c], high[c] = x[:, :D].min(axis=0), x[:, :D].max(axis=0)
            low[c] -= 0.2 * cell
            high[c] += 0.2 * cell
        return low, high

    def _meeting(self, table: Table, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Clusters that may meet, see `find_meeting`."""
        frame, pairs = self.scene.domain.frame, self.pairs
        cell = np.array(frame.cell)
        some = self._beside(table.body, low, high, REACH * cell)
        close = close_pairs(low[some], high[some], REACH * cell)
        a, b = some[close].T
        met = (low[a] <= high[b] + REACH * cell).all(axis=1)
        met &= (low[b] <= high[a] + REACH * cell).all(axis=1)
        a, b = a[met], b[met]
        one, other = table.body[a], table.body[b]
        swap_them = one > other
        a, b = np.where(swap_them, b, a), np.where(swap_them, a, b)
        one, other = table.body[a], table.body[b]
        acts = (one < self.bodies) & (one != other) & (pairs.entry[one, other] != 0)
        soft = other < self.bodies
        acts[soft] &= self.groups[one[soft]] != self.groups[other[soft]]
        found = [np.column_stack([a, other, b])[acts]]
        soft_clusters = np.flatnonzero(table.body < self.bodies)
        for w, (axis, side, place, *_) in enumerate(self._walls.planes.tolist()):
            at = frame.origin[axis] + (place - frame.ghost) * cell[axis]
            end = (high if side > 0 else low)[soft_clusters, axis]
            some = soft_clusters[side * (at - end) < REACH * cell[axis]]
            found.append(np.column_stack([some, np.full(len(some), self._walls.first + w), some]))
        every = np.concatenate(found)
        return np.ascontiguousarray(every[np.lexsort(every.T[::-1])])

    def _beside(
        self, body: np.ndarray, low: np.ndarray, high: np.ndarray, reach: np.ndarray
    ) -> np.ndarray:
        """Clusters that are near the box of another body on which theirs acts."""
        bodies, first = np.unique(body, return_index=True)
        least = np.minimum.reduceat(low, first) if len(first) else low
        most = np.maximum.reduceat(high, first) if len(first) else high
        found = np.zeros(len(body), bool)
        ends = np.append(first, len(body))
        for a, b in close_pairs(least, most, reach).tolist():
            one, other = int(bodies[a]), int(bodies[b])
            if one >= self.bodies or self.pairs.entry[one, other] == 0:
                continue
            for own, its in ((a, b), (b, a)):
                mine = slice(ends[own], ends[own + 1])
                near = (low[mine] <= most[its] + reach).all(axis=1)
                found[mine] |= near & (least[its] <= high[mine] + reach).all(axis=1)
        return np.flatnonzero(found)

    def _select(self, rank: RankState, table: Table, meeting: np.ndarray) -> Near:
        """The facets, cells and vertices of clusters that may meet; collective."""
        clusters = np.unique(meeting[:, [0, 2]])
        facets = np.concatenate(
            [np.zeros(0, np.int64)]
            + [table.members[table.first[c] : table.first[c + 1]] for c in clusters]
        )
        cells = table.cells
        some = np.unique(table.surface.cell[facets])
        some = some[some >= 0]
        marks = np.zeros(len(table.keys), bool)
        marks[cells.corners[some].reshape(-1)] = True
        counts = np.diff(cells.start)
        used = np.repeat(np.isin(np.arange(len(counts)), some), counts)
        marks[cells.column[used]] = True
        number = np.cumsum(marks) - 1
        # Cells of others have vertices of any number: they are not looked at.
        mapped = cells._replace(corners=number[cells.corners], column=number[cells.column])
        own = np.flatnonzero(marks & (self._records >= 0))
        every = self.comm.allgather(number[own])
        return Near(
            meeting, facets, mapped, table.keys[marks], self._records[own], number[own],
            np.concatenate(every), np.array([len(each) for each in every]),
        )  # fmt: skip

    def _displacements(self, rank: RankState, near: Near) -> np.ndarray | None:
        """Displacements of the near vertices, on the root; collective."""
        u = rank.grid.kept.values.reshape(-1, RECORD)[near.records, DISPLACEMENT : DISPLACEMENT + 3]
        return self._on_root(near, np.ascontiguousarray(u))

    def _on_root(self, near: Near, values: np.ndarray) -> np.ndarray | None:
        """Records of the rank's own near vertices, of all ranks on the root; collective."""
        found = np.zeros((len(near.keys), *values.shape[1:]), values.dtype)
        if self.comm.size == 1:
            found[near.own] = values
            return found
        sent, received = np.zeros((2, self.comm.size), np.int64)
        sent[self._root] = len(values)
        if self.comm.rank == self._root:
            received[:] = near.counts
        arrived = swap(self.comm, values, sent, received)
        if self.comm.rank != self._root:
            return None
        found[near.every] = arrived
        return found

    def _find_candidates(self, rank: RankState, table: Table, near: Near) -> None:
        """Find facets near another body on the root, with the nearest facet there; collective."""
        u, surface, call = self._displacements(rank, near), table.surface, self.call
        self._candidates, self._facets = no_facets(0), np.empty(0, np.int64)
        if u is None or not needed(len(near.meeting)):
            return
        frame, rigid = self.scene.domain.frame, self.rigid_bodies
        call(move_facets, frame, rigid, surface, near.cells, u, near.facets, self._scratch)
        walls = near.meeting[:, 1] >= self._walls.first
        marks = np.zeros(len(surface.x), np.uint8)
        meeting = np.ascontiguousarray(near.meeting[~walls])
        clusters, reach = (table.first, table.members), (REACH * max(frame.cell), frame.cell[0])
        every, found = grown(
            2 * len(near.facets) + 16,
            no_facets,
            lambda room: call(find_meeting, surface, clusters, meeting, reach, marks, room),
        )
        parts = [every[:found]]
        for cluster, body, _ in near.meeting[walls].tolist():
            some = table.members[table.first[cluster] : table.first[cluster + 1]]
            axis, side, place, *_ = self._walls.planes[body - self._walls.first].tolist()
            at = frame.origin[axis] + (place - frame.ghost) * frame.cell[axis]
            away = side * (at - surface.now[some, axis])
            some = some[(away < REACH * frame.cell[axis]) & (side * surface.turned[some, axis] > 0)]
            one = no_facets(len(some))
            one["facet"], one["body"], one["other"] = some, body, -1
            marks[some] = 1
            parts.append(one)
        every = np.concatenate(parts)
        order = np.lexsort((every["facet"], every["body"], surface.patch[every["facet"]]))
        self._candidates, self._facets = every[order], np.flatnonzero(marks)
        surface.now[near.facets[marks[near.facets] == 0]] = np.inf  # they do not move until then

    def _exchange_near(
        self, rank: RankState, update: VertexUpdate, table: Table, near: Near
    ) -> None:
        """Find the gaps, and solve for the impulses; collective."""
        scene, contact, call, grid = self.scene, self._contact, self.call, rank.grid
        t, faces, forcing, ledger = update
        holding = Holding(
            faces, scene.domain.frame, forcing, contact.scratch_impulse, forcing.loads.relaxation
        )
        values = np.empty(len(near.own), REFERENCE_VERTEX)
        call(read_reference_vertices, holding, grid.field, near.keys[near.own], values)
        u, every = self._displacements(rank, near), self._on_root(near, values)
        joint = None
        found = np.zeros(1, np.int64)
        if u is not None:
            assert every is not None
            joint = self._pairs(table, near, u, every, t.dt)
            found[0] = len(joint.pairs.ends)
        if self.comm.size > 1:
            self.comm.Bcast(found, self._root)
        if not needed(found[0]):
            self._warm_start.clear()
            return
        self._warm_start.move_to(self._root)
        changes = None
        if joint is not None:
            changes = self._solve(joint, nothing_held(holding), ledger)
        else:
            self._warm_start.clear()
        if self.comm.size > 1:
            answers = self.rigid_bodies.responses["trial_impulse"] if self.free else np.empty(0)
            changes = share(self.comm, self._root, changes, answers)
        assert changes is not None
        call(change_velocities, scene.domain.frame, grid.field, changes, forcing, ledger.work)
        call(book_held, holding, grid.field, changes, ledger)

    def _pairs(
        self, table: Table, near: Near, u: np.ndarray, values: np.ndarray, dt: float
    ) -> Joint:
        """The pairs of patches and other bodies, with their rows of B."""
        call, frame, surface = self.call, self.scene.domain.frame, table.surface
        cells, every, rigid = near.cells, self._candidates, self.rigid_bodies
        call(move_facets, frame, rigid, surface, cells, u, self._facets, self._scratch)
        F = self._scratch[0]
        call(find_gaps, frame, rigid, self._walls, surface, cells, u, F, every)
        most = len(every)
        pairs, seen = ContactPairs.empty(most), np.empty((2, len(near.keys)), np.int64)
        counts = [0, 0]

        def fill(coupling: Coupling) -> int:
            some = every.copy()  # gaps become weights
            counts[0], counts[1], used = call(
                find_patch_pairs, self._contact, frame, surface, cells, some, dt,
                (flat(values), seen), pairs, coupling,
            )  # fmt: skip
            return int(used)

        coupling, used = grown(
            8 * most + 64,
            lambda size: Coupling(
                np.zeros(2 * most + 1, np.int64),
                np.empty(size, np.int64),
                np.empty((size, 1)),
                np.empty((2 * most, 3)),
                np.zeros((2 * most, 0, 3)),
            ),
            fill,
        )
        found, rows = counts
        coupling = Coupling(
            coupling.start[: rows + 1], coupling.column[:used], coupling.entry[:used],
            coupling.answer[:rows], coupling.beyond[:rows],
        )  # fmt: skip
        vertices = ReferenceVertices(near.keys, values)
        return Joint(pairs.chosen(slice(found)), coupling, vertices)


def _least(comm: Communicator, values: np.ndarray) -> np.ndarray:
    """The least values of all ranks; collective."""
    if comm.size == 1:
        return values
    from mpi4py import MPI

    found = np.empty_like(values)
    comm.Allreduce(values, found, MPI.MIN)
    return found
