"""Facets that may soon meet another body, or their own: known for several steps."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from pgimp.jit.bound import Bound
from pgimp.jit.rehearsal import needed
from pgimp.kernels.contact.impulses.pairs import SeparatingWalls
from pgimp.kernels.contact.surfaces.data import Surface, SurfaceCells, no_facets
from pgimp.kernels.contact.surfaces.gaps import FARTHEST
from pgimp.kernels.contact.surfaces.motion import move_facets
from pgimp.kernels.contact.surfaces.spread import kept_of, scratch_of
from pgimp.kernels.data.motion import DISPLACEMENT, KEPT_VELOCITY
from pgimp.kernels.data.record import RECORD
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.contact.impulses.messages import greatest, swap
from pgimp.solver.contact.surfaces.candidates import (
    boxes_of,
    find_candidates,
    find_meeting_clusters,
)
from pgimp.solver.contact.surfaces.groups import Groups, find_groups
from pgimp.solver.contact.surfaces.table import Table, records_of
from pgimp.solver.contact.surfaces.wide import joined, moving_of
from pgimp.solver.rank_state import RankState

#: Cells by which each body may move until the next search, at most, and the most steps until it
#: looks how far they have moved.
TRAVEL, LONGEST = 0.25, 16

#: Cells by which it may move at least, and else the way in so many times that number of steps.
_LEAST, _AHEAD = 0.02, 2.0

#: Pieces of facets that are kept within a step, for each candidate, and more for a wide one.
PIECES, _MORE_PIECES = 3, 4

#: Cells of travel within which the facets next to others stay so.
WALK = 0.01

U = slice(DISPLACEMENT, DISPLACEMENT + 3)

#: With a number that means nothing, for kernels.
U4 = slice(DISPLACEMENT, DISPLACEMENT + 4)

#: What a checkpoint has of each candidate, and its parts: displacements, facets, moving ones,
#: these. Before them there are four numbers and the parts' lengths.
_KEPT = ("facet", "body", "other")
_PARTS, _NUMBERS = 3 + len(_KEPT), 4


class Near(NamedTuple):
    """Vertices that move facets near other bodies, until the next search."""

    any: bool  #: Whether there are any.
    facets: np.ndarray  #: (n,) int64: All facets of clusters that may meet others.
    cells: SurfaceCells  #: Cells with the vertices' numbers among those below.
    keys: np.ndarray  #: (v,) int64: Keys of the vertices that move these facets.
    records: np.ndarray  #: (o,) int64: Records of those that the rank owns.
    own: np.ndarray  #: (o,) int64: Their numbers.
    every: np.ndarray  #: (v,) int64: Numbers of those of all ranks, one rank after the other.
    counts: np.ndarray  #: (ranks,) int64: How many each rank owns.


class Share(NamedTuple):
    """What a rank has of the groups of bodies near each other, until the next search."""

    moving: np.ndarray  #: (k,) int64: Its facets near others, and those near them.
    cells: SurfaceCells  #: Cells with the vertices' numbers among those below.
    keys: np.ndarray  #: (v,) int64: Keys of the vertices that move these facets.
    #: records, sent: (o,) int64: Records of its own vertices that any rank needs, by rank; keys.
    records: np.ndarray
    sent: np.ndarray
    counts: np.ndarray  #: (2, ranks) int64: How many of these each rank needs, and it has of each.
    place: np.ndarray  #: (v,) int64: Numbers of those that it gets.
    same: bool  #: Whether these are its own, in their order.
    of: np.ndarray  #: (n, 2) int64: Bodies, and the vertices of the cells of their facets.

    def gather(self, comm: Communicator, values: np.ndarray) -> np.ndarray:
        """What all ranks have at the share's vertices, given that of `sent`; collective."""
        if self.same:
            return values
        arrived = values if comm.size == 1 else swap(comm, values, *self.counts)
        found = np.zeros((len(self.keys), *values.shape[1:]), values.dtype)
        found[self.place] = arrived
        return found


class Proximity:
    """Finds the facets near other bodies, and knows how long they are all.

    Parameters
    ----------
    walls : SeparatingWalls
        The unilateral walls.

    Attributes
    ----------
    near : Near
        What may meet.
    candidates : (n,) NEAR_FACET
        Facets near another body, by patch and body, with the nearest facet there: those of the
        rank's groups.
    groups : Groups
        Connected groups of bodies near each other, of all ranks.
    labels : (bodies,) int64
        See `labels_of`.
    share : Share
        What the rank's groups need.
    alone : bool
        Whether the root has all groups.
    root : int
        The rank with the first layer, which searches.
    reach : float
        Distance within which facets are looked at.
    met : (n, 2) int64
        Pairs of bodies with facets near each other, on all ranks.
    """

    def __init__(self, scene: Scene, comm: Communicator, walls: SeparatingWalls) -> None:
        self.scene, self.comm, self.walls, self.call = scene, comm, walls, Bound()
        self.near: Near | None = None
        self.candidates, self._moving = no_facets(0), np.empty(0, np.int64)
        self._found = self.candidates, np.empty(0, np.int64)  # of all ranks, and which are its own
        self.labels, self.root = np.empty(0, np.int64), 0
        self.groups: Groups
        self.share: Share
        self.scratch = scratch_of(scene.dimension)
        cell, pairs = np.array(scene.domain.frame.cell), scene.interaction.pairs
        adheres = pairs.adhesion[:, 2].max(initial=0.0) if pairs else 0.0
        self.alone = False
        self.far = max(FARTHEST * cell.min(), adheres)
        self._travel = TRAVEL
        self.reach = float(self._reach().max())
        self.met = np.empty((0, 2), np.int64)
        self._pause, self._moved, self._walked = 0, 0.0, 2.0 * WALK
        self._records = np.empty(0, np.int64)
        self._poses: bytes | None = None
        self._soft = 0  # facets of the share that are not rigid
        self._window: object = None
        self._before = np.empty((0, 3))  # displacements of all surface vertices at the last search
        self._restored = np.empty(0)

    def _reach(self) -> np.ndarray:
        """Distances by direction within which facets may meet before the next search."""
        return 2.0 * self._travel * np.array(self.scene.domain.frame.cell) + self.far

    def boxes(self, rank: RankState, table: Table, rigid: Any) -> tuple[np.ndarray, np.ndarray]:
        """See `boxes_of`; collective."""
        return boxes_of(self.call, self.comm, rank, table, self._records, rigid)

    def restart(self) -> None:
        """Search in the next step: the surfaces have changed."""
        self._pause, self._window, self.near = 0, None, None

    def relocate(self) -> None:
        """Note that vertices have changed ranks, perhaps. This is no reason to search."""
        self._window = None

    @property
    def state(self) -> np.ndarray:
        """What a checkpoint has of the search, (n,) float64, of the root; empty on others.

        Collective. It is state: in a concave corner the facet next to another may depend on where
        the way to it begins.
        """
        if self.near is None:
            return np.empty(0)
        every = self._everyone()
        if self.comm.rank != self.root:
            return np.empty(0)
        parts = (self._before.reshape(-1), self.near.facets, self._moving,
                 *(every[name] for name in _KEPT))  # fmt: skip
        numbers = [self._pause, self._moved, self._walked, self._travel]
        return np.concatenate([numbers, list(map(len, parts)), *parts])

    def restore(self, state: np.ndarray) -> None:
        """Continue with the `state` of a checkpoint, on every rank."""
        self._restored = state

    def _continue(self, rank: RankState, table: Table) -> None:
        """Take over the state of a checkpoint, if it is of these surfaces; collective."""
        state, self._restored = self._restored, np.empty(0)
        head = _NUMBERS + _PARTS
        sizes = state[_NUMBERS:head].astype(np.int64)
        if sizes[0] != 3 * len(table.keys) or len(state) != head + sizes.sum():
            return
        before, *parts = np.split(state[head:], np.cumsum(sizes[:-1]))
        facets, self._moving, *every = (part.astype(np.int64) for part in parts)
        self._pause = int(state[0])
        self._moved, self._walked, self._travel = state[1:_NUMBERS].tolist()
        self._before = before.reshape(-1, 3)
        found = no_facets(len(every[0]))
        for name, values in zip(_KEPT, every, strict=True):
            found[name] = values
        self._find_root(rank)
        self._locate(rank, table, facets)
        self._divide(table, found)

    def _locate(self, rank: RankState, table: Table, facets: np.ndarray | None = None) -> None:
        """Find the records of vertices, those near others on all ranks, and the root; collective.

        `facets` are those that may meet others, by default as they were.
        """
        self._window, near = rank.grid.window, self.near
        self._records = records_of(rank, table.numbers)
        if facets is not None:
            self.near = self._select(table, facets)
        elif near is not None:
            self._find_root(rank)
            self.near = self._select(table, near.facets)
            self._divide(table, self._everyone())

    def everyone(self) -> tuple[np.ndarray, np.ndarray]:
        """The candidates of all ranks, and the facets near others; collective."""
        return self._everyone(), self._moving

    def _everyone(self) -> np.ndarray:
        """The candidates of all ranks; collective."""
        every, mine = self._found
        for numbers, others in self.comm.allgather((mine, self.candidates["other"])):
            every["other"][numbers] = others
        return every

    def _find_root(self, rank: RankState) -> None:
        """Find the rank with the first layer; collective."""
        slab = rank.grid.slab
        first = slab.layers and (slab.lower is None or slab.first == self.scene.domain.ring)
        self.root = -int(greatest(self.comm, -self.comm.rank if first else -self.comm.size))

    def _everywhere(self, own: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Displacements of all surface vertices, given those of the mask `own`; collective."""
        found = np.zeros((len(own), 3))
        found[own] = u
        if self.comm.size > 1:
            for some, values in self.comm.allgather((np.flatnonzero(own), u)):
                found[some] = values
        return found

    def all_displacements(self, rank: RankState, table: Table) -> np.ndarray:
        """Displacements of all surface vertices, (v, 3) float64; collective."""
        records = records_of(rank, table.numbers)
        own, motion = records >= 0, rank.grid.kept.values.reshape(-1, RECORD)
        return self._everywhere(own, motion[records[own], U])

    def update(
        self, rank: RankState, table: Table, acts: np.ndarray, rigid: Any, dt: float, rate: float
    ) -> bool:
        """Search, if any facets may have come near others since; collective.

        Returns whether groups may be on other ranks than before.

        Parameters
        ----------
        acts : (bodies, bodies) uint8
            See `find_meeting`.
        rigid : RigidBodies or ()
            The rigid bodies at their positions.
        dt, rate : float
            The step; most cells that a point of rigid bodies crosses per unit of time.
        """
        divided = bool(len(self._restored))
        if divided:
            self._continue(rank, table)
        if self._window is not rank.grid.window:
            self._locate(rank, table)
            divided = self.near is not None
        self._moved += rate * dt
        self._pause -= 1
        if self._pause >= 0:
            return divided
        own = self._records >= 0
        motion = rank.grid.kept.values.reshape(-1, RECORD)[self._records[own]]
        inverse, D = np.array(rank.grid.frame.inverse), self.scene.dimension
        speed = np.abs(motion[:, KEPT_VELOCITY : KEPT_VELOCITY + D]) * inverse
        travel = max(greatest(self.comm, float(speed.max(initial=0.0))), rate) * dt
        moved = np.inf
        if self.near is not None:
            away = np.abs(motion[:, U] - self._before[own])[:, :D] * inverse
            moved = float(away.max(initial=0.0))
        left = self._travel - max(greatest(self.comm, moved), self._moved)
        if left > 4.0 * travel:
            self._pause = int(min(LONGEST, left / travel if travel > 0.0 else LONGEST)) - 1
            return divided
        self._before, self._moved = self._everywhere(own, motion[:, U]), 0.0
        self._walked = 2.0 * WALK
        self._travel = float(np.clip(_AHEAD * LONGEST * travel, _LEAST, TRAVEL))
        self._pause = int(max(1.0, min(LONGEST, self._travel / max(travel, 1e-300)))) - 1
        self._find_root(rank)
        boxes, reach = self.boxes(rank, table, rigid), self._reach()
        call, scene, walls = self.call, self.scene, self.walls
        meeting = find_meeting_clusters(call, scene, walls, table, acts, boxes, reach)
        facets = table.facets(np.unique(meeting.pairs))
        near = np.unique(np.concatenate([facets, *meeting.on_walls.values()]))
        self.near = self._select(table, near)
        u, found, self._moving = self.displacements(rank, self.near), no_facets(0), near[:0]
        if u is not None and needed(self.near.any):
            of = table.surface, self.near.cells, u, self.near.facets, self.scratch
            call(move_facets, scene.domain.frame, rigid, *of)
            found, self._moving = find_candidates(call, scene, walls, table, acts, meeting, reach)
            found = joined(table, found)
            travel = np.inf if scene.case.output.surface else self._travel
            self._moving = moving_of(table, found, travel, self._moving)
        found, self._moving = self.comm.bcast((found, self._moving), self.root)
        self._divide(table, found)
        return True

    def moved_facets(self, rigid: Any) -> np.ndarray:
        """The share's facets that have moved since this was last asked: all but resting rigid ones.

        Those of rigid bodies come last.
        """
        moving = self.share.moving
        if not len(rigid):
            return moving
        poses = rigid.motion["centre"].tobytes() + rigid.motion["rotation"].tobytes()
        rests, self._poses = poses == self._poses, poses
        return moving[: self._soft] if rests and not needed(0) else moving

    def walks(self, travel: float) -> bool:
        """Whether facets next to others are to be found anew, given a step's travel in cells."""
        self._walked += travel
        again = bool(self._walked > WALK)
        self._walked = 0.0 if again else self._walked
        return again

    def has(self, bodies: np.ndarray) -> np.ndarray:
        """Mask of the pairs of bodies, (n, 2), in the rank's groups; on the root those in none."""
        groups = self.groups
        found = np.full(len(bodies), self.root)
        some = groups.of[bodies].max(axis=1) >= 0
        found[some] = groups.rank[groups.number(bodies[some])]
        return found == self.comm.rank

    def _divide(self, table: Table, every: np.ndarray) -> None:
        """Find the groups of all candidates, and the rank's share; collective."""
        surface, facet = table.every, every["facet"]
        bodies = np.column_stack([surface.body[facet], every["body"]])
        count = len(self.labels)
        met, of = np.unique(bodies[:, 0] * count + bodies[:, 1], return_inverse=True)
        self.met = np.column_stack(np.divmod(met, count))
        self.groups = find_groups(self.labels, self.met, of, surface.x[facet, 0], self.comm.size)
        if self.alone:
            self.groups.rank[:] = self.root
        own = self.groups.rank[self.groups.number(self.met)] == self.comm.rank
        mine = np.flatnonzero(own[of])
        self.candidates, self._found = every[mine], (every, mine)
        group = self.groups.of[surface.body[self._moving]]
        joins, surface.now[:] = group >= 0, np.inf
        rank = np.where(joins, self.groups.rank[group], self.comm.rank)
        used = np.full(len(table.keys), -1)
        for each in range(self.comm.size):
            used[self._vertices(table, self._moving[joins & (rank == each)])[0]] = each
        own = np.flatnonzero((used >= 0) & (self._records >= 0))
        own = own[np.argsort(used[own], kind="stable")]
        parts = self.comm.allgather((own, np.bincount(used[own], minlength=self.comm.size)))
        here = self.comm.rank
        get = [each[used[each] == here] for each, _ in parts]
        marks, cells = self._vertices(table, self._moving[rank == here])
        number = np.cumsum(marks) - 1
        mapped = cells._replace(corners=number[cells.corners], column=number[cells.column])
        place, keys = number[np.concatenate(get)], table.keys[marks]
        same = self.comm.size == 1 and np.array_equal(place, np.arange(len(keys)))
        self.share = Share(
            self._moving[rank == here], mapped, keys, self._records[own], table.keys[own],
            np.array([parts[here][1], [len(each) for each in get]]), place, same,
            _vertices_of(surface, mapped, self._moving[rank == here]),
        )  # fmt: skip
        self._poses = None
        self._soft = int((surface.cell[self.share.moving] >= 0).sum())
        room = PIECES * len(mine)
        room += _MORE_PIECES * int((self.candidates["facet"] >= len(table.wide)).sum())
        if len(self.scratch[-1][0]) < room:
            kept = kept_of(self.scene.dimension, room * 5 // 4)
            self.scratch = (*self.scratch[:-1], kept)

    def _select(self, table: Table, facets: np.ndarray) -> Near:
        """The cells and vertices of facets that may meet others; collective."""
        marks, cells = self._vertices(table, facets)
        number = np.cumsum(marks) - 1
        # Cells of others have vertices of any number: they are not looked at.
        mapped = cells._replace(corners=number[cells.corners], column=number[cells.column])
        own = np.flatnonzero(marks & (self._records >= 0))
        every = self.comm.allgather(number[own])
        return Near(
            len(facets) > 0, facets, mapped, table.keys[marks], self._records[own], number[own],
            np.concatenate(every), np.array([len(each) for each in every]),
        )  # fmt: skip

    def _vertices(self, table: Table, facets: np.ndarray) -> tuple[np.ndarray, SurfaceCells]:
        """Mask of the vertices that move some facets; all cells."""
        cells = table.cells
        marks, used = np.zeros(len(table.keys), bool), np.zeros(len(cells.low), bool)
        some = table.every.cell[facets]
        used[some[some >= 0]] = True
        for _ in range(self.scene.dimension - 1):  # facets may reach into cells beside
            beside = cells.beside[used]
            used[beside[beside >= 0]] = True
        marks[cells.corners[used].reshape(-1)] = True
        marks[cells.column[np.repeat(used, np.diff(cells.start))]] = True
        return marks, cells

    def displacements(self, rank: RankState, near: Near) -> np.ndarray | None:
        """Displacements of the near vertices, (v, 4), on the root; collective."""
        values = rank.grid.kept.values.reshape(-1, RECORD)
        return self.on_root(near, np.ascontiguousarray(values[near.records, U4]))

    def on_root(self, near: Near, values: np.ndarray) -> np.ndarray | None:
        """What all ranks have at their near vertices, on the root; collective."""
        found = np.zeros((len(near.keys), *values.shape[1:]), values.dtype)
        if self.comm.size == 1:
            found[near.own] = values
            return found
        sent, received = np.zeros((2, self.comm.size), np.int64)
        sent[self.root] = len(values)
        if self.comm.rank == self.root:
            received[:] = near.counts
        arrived = swap(self.comm, values, sent, received)
        if self.comm.rank != self.root:
            return None
        found[near.every] = arrived
        return found


def _vertices_of(surface: Surface, cells: SurfaceCells, facets: np.ndarray) -> np.ndarray:
    """Bodies, and the vertices of the cells of some of their facets, each once, (n, 2)."""
    cell, at = np.unique(surface.cell[facets], return_index=True)
    body, corners = surface.body[facets[at[cell >= 0]]], cells.corners[cell[cell >= 0]]
    count = 1 + int(corners.max(initial=0))
    pairs = np.unique(body[:, None] * count + corners)
    return np.column_stack(np.divmod(pairs, count))
