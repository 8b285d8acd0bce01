"""Facets that may soon meet another body, or their own: known for several steps."""

from __future__ import annotations

from typing import Any

import numpy as np

from pgimp.jit.bound import Bound
from pgimp.jit.rehearsal import needed
from pgimp.kernels.contact.data import Contact
from pgimp.kernels.contact.impulses.pairs import SeparatingWalls
from pgimp.kernels.contact.surfaces.awake import find_near_gaps
from pgimp.kernels.contact.surfaces.data import KNOWN, Patches, no_facets
from pgimp.kernels.contact.surfaces.gaps import FARTHEST
from pgimp.kernels.contact.surfaces.motion import move_facets
from pgimp.kernels.contact.surfaces.patches.levels import NEAR
from pgimp.kernels.contact.surfaces.search import greatest_way
from pgimp.kernels.contact.surfaces.shifts import find_shifts, least_left
from pgimp.kernels.contact.surfaces.spread import kept_of, scratch_of
from pgimp.kernels.data.motion import DISPLACEMENT
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.rigid.bodies import MOTION
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.contact.impulses.messages import greatest, greatest_of
from pgimp.solver.contact.surfaces.candidates import (
    boxes_of,
    candidates_of,
    find_candidates,
    find_meeting_clusters,
    in_order,
    least,
)
from pgimp.solver.contact.surfaces.groups import Groups, find_groups
from pgimp.solver.contact.surfaces.shares import Share, marked, share_of
from pgimp.solver.contact.surfaces.table import Table, records_of
from pgimp.solver.contact.surfaces.wide import joined, moving_of
from pgimp.solver.rank_state import RankState

#: Cells by which each body may move until the next search, at most.
TRAVEL = 0.25

#: Cells by which it may move at least, and else the way in so many steps.
_LEAST, _AHEAD = 0.02, 32.0

#: Cells over these by which those are farther from each other that are not watched.
_WATCHED = 6.0

#: Cells by which bodies move while normals turn by one, of both together, at least.
_TURNS = 4.0

#: By how much cosines between normals may change until the next search: faces beside an edge are
#: looked at before they face what is beside them. Curved faces may by `MEETS - FACES`. Then that
#: before walls, which have no edges.
_TURNED = 0.31, 0.6

#: Pieces of facets that are kept within a step, for each candidate, and more for a wide one.
PIECES, _MORE_PIECES = 3, 4

U = slice(DISPLACEMENT, DISPLACEMENT + 3)

#: What a checkpoint has: four numbers, the lengths of these parts, and displacements at the last
#: search, facets near others, those that move, facets, bodies and next facets of candidates, what
#: is known of their patches, clusters that are watched, by how much they might move, and the motion
#: of rigid bodies then.
_NUMBERS, _PARTS = 4, 8


class Proximity:
    """Finds the facets near other bodies, and knows how long they are all.

    Parameters
    ----------
    walls : SeparatingWalls
        The unilateral walls.

    Attributes
    ----------
    facets : (n,) int64 or None
        All facets of clusters that may meet others; None before the first search.
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
        self.facets: np.ndarray | None = None
        self.candidates, self._moving = no_facets(0), np.empty(0, np.int64)
        # Candidates of all ranks, what is known of their patches, and which of both are its own.
        self._found = self.candidates, np.empty((0, KNOWN)), *np.empty((2, 0), np.int64)
        self.labels, self.root = np.empty(0, np.int64), 0
        self.groups: Groups
        self.share: Share
        self.scratch = scratch_of(scene.dimension)
        cell, pairs = np.array(scene.domain.frame.cell), scene.interaction.pairs
        adheres = pairs.adhesion[:, 2].max(initial=0.0) if pairs else 0.0
        self.alone = False
        self.far, self._before_walls = (max(n * cell.min(), adheres) for n in (FARTHEST, NEAR))
        self._travel, self._left, self._tilts = TRAVEL, 0.0, False  # joined facets have tilted
        self.reach = float(self._reach().max())
        self.met = np.empty((0, 2), np.int64)
        self._moved = 0.0
        self._records, self._shared = np.empty((2, 0), np.int64)  # with the next rank's first plane
        # Of the last search: clusters that are watched, and motion of rigid bodies.
        self._watched = np.empty((0, 2), np.int64), np.empty(0)
        self._poses: Any = ()
        self.patches = Patches(
            np.zeros(1, np.int64), np.empty(0, np.int64), np.empty(0, np.uint8), np.empty(0),
            np.empty((0, KNOWN)),
        )  # fmt: skip
        self._awake = self.patches
        # Facets that are moved in a step, and how many; the first of each patch that may be.
        self._chosen, self._first = np.empty((2, 0), np.int64)
        self._moves, self._marks = np.zeros(1, np.int64), np.empty(0, np.bool_)
        self._whole = bool(scene.case.output.surface)  # loads are of all facets
        self._row = np.empty(KNOWN)
        self._window: object = None
        self._before = np.empty((0, 4))  # displacements of all surface vertices at the last search
        self._restored = np.empty(0)

    def _reach(self) -> np.ndarray:
        """Distances by direction within which facets may meet before the next search."""
        return 2.0 * self._travel * np.array(self.scene.domain.frame.cell) + self.far

    def boxes(self, rank: RankState, table: Table, rigid: Any) -> tuple[np.ndarray, np.ndarray]:
        """See `boxes_of`; collective."""
        return boxes_of(self.call, self.comm, rank, table, self._records, rigid)

    def restart(self) -> None:
        """Search in the next step: the surfaces have changed."""
        self._moved, self._window, self.facets = np.inf, None, None

    def relocate(self) -> None:
        """Note that vertices have changed ranks, perhaps. This is no reason to search."""
        self._window = None

    @property
    def state(self) -> np.ndarray:
        """What a checkpoint has of the search, (n,) float64, of the root; empty on others.

        Collective. It is state: in a concave corner the facet next to another may depend on where
        the way to it begins.
        """
        if self.facets is None:
            return np.empty(0)
        every, known = self._everyone()
        tilts = greatest(self.comm, self._tilts)
        if self.comm.rank != self.root:
            return np.empty(0)
        of = np.stack([every["facet"], every["body"], every["other"]], axis=1)
        pairs, left = self._watched
        poses = np.array(self._poses).view(np.float64) if len(self._poses) else np.empty(0)
        parts = (
            self._before[:, :3].ravel(), self.facets, self._moving, of.ravel(), known.ravel(),
            pairs.ravel(), left, poses,
        )  # fmt: skip
        numbers = [self._moved, self._travel, self._left, tilts]
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
        parts = np.split(state[head:], np.cumsum(sizes[:-1]))
        before, facets, moving, found, known, pairs, left, poses = parts
        self.facets, self._moving = facets.astype(np.int64), moving.astype(np.int64)
        self._moved, self._travel, self._left, self._tilts = state[:_NUMBERS].tolist()
        self._before = np.pad(before.reshape(-1, 3), ((0, 0), (0, 1)))
        self._watched = pairs.astype(np.int64).reshape(-1, 2), left.copy()
        self._poses = poses.copy().view(MOTION) if len(poses) else ()
        every = candidates_of(table.every, found.astype(np.int64).reshape(-1, 3))
        self._found = every, known.reshape(-1, KNOWN), *np.empty((2, 0), np.int64)
        self.candidates, self.patches = every[:0], Patches.of(table.every, every[:0])
        self._locate(rank, table)

    def _locate(self, rank: RankState, table: Table) -> None:
        """Find the records of vertices, the root, and the rank's share as it was; collective."""
        self._window = rank.grid.window
        self._records = records_of(rank, table.numbers)
        self._shared = records_of(rank, table.numbers, 1)
        if self.facets is not None:
            self._find_root(rank)
            self._divide(table, *self._everyone())

    def everyone(self) -> tuple[np.ndarray, np.ndarray]:
        """The candidates of all ranks, and the facets near others; collective."""
        return self._everyone()[0], self._moving

    def _everyone(self) -> tuple[np.ndarray, np.ndarray]:
        """The candidates of all ranks, and what is known of their patches; collective."""
        every, known, mine, here = self._found
        own = mine, self.candidates["other"], here, self.patches.known
        for numbers, others, patches, rows in self.comm.allgather(own):
            every["other"][numbers], known[patches] = others, rows
        return every, known

    def _find_root(self, rank: RankState) -> None:
        """Find the rank with the first layer; collective."""
        slab = rank.grid.slab
        first = slab.layers and (slab.lower is None or slab.first == self.scene.domain.ring)
        self.root = -int(greatest(self.comm, -self.comm.rank if first else -self.comm.size))

    def all_displacements(
        self, rank: RankState, table: Table, records: np.ndarray | None = None
    ) -> np.ndarray:
        """Displacements of all surface vertices, (v, 4) float64, the last 0; collective.

        `records` are theirs, see `records_of`; they are found if they may have changed.
        """
        records = records_of(rank, table.numbers) if records is None else records
        own, found = np.flatnonzero(records >= 0), np.zeros((len(records), 4))
        found[own, :3] = rank.grid.kept.values.reshape(-1, RECORD)[records[own], U]
        if self.comm.size > 1:
            for some, values in self.comm.allgather((own, found[own])):
                found[some] = values
        return found

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
            divided = self.facets is not None
        # Each step looks: what is at rest may be pushed, and steps may become longer.
        way = max(self.way(rank, dt), rate * dt)
        travel, tilts = greatest_of(self.comm, way, self._tilts)
        self._moved, self._tilts = self._moved + travel, False
        if self.facets is not None and not tilts:
            if 2.0 * self._moved > self._left:
                self._left, self._moved = self._find_left(rank, table, rigid), travel
            if 2.0 * self._moved <= self._left:
                return divided
        self._before, self._moved = self.all_displacements(rank, table, self._records), travel
        self._poses = rigid.motion.copy() if rigid else ()
        self._travel = float(np.clip(_AHEAD * travel, _LEAST, TRAVEL))
        self._left = 2.0 * self._travel
        self._find_root(rank)
        boxes, reach = self.boxes(rank, table, rigid), self._reach()
        call, scene, walls = self.call, self.scene, self.walls
        ways = self._travel, self._unwatched - self._travel
        fars = self.far, self._before_walls
        meeting = find_meeting_clusters(call, scene, walls, table, acts, boxes, fars, ways)
        self._watched = meeting.watched, meeting.left
        if needed(0):
            self._find_left(rank, table, rigid)
        near = marked(len(table.surface.x), [meeting.facets, *meeting.on_walls.values()])
        found, self.facets, self._moving = np.empty((0, 3), np.int64), near, near[:0]
        if needed(len(near)):
            of = table.surface, table.cells, self._before, near, self.scratch
            call(move_facets, scene.domain.frame, rigid, *of)
            part = self.comm.rank, self.comm.size
            parts = self.comm.allgather(
                find_candidates(call, scene, walls, table, acts, meeting, reach, _TURNED, part)
            )
            found = np.concatenate([each[0] for each in parts])
            self._moving = marked(len(table.surface.x), [each[1] for each in parts])
        found = joined(table, walls, in_order(table.surface, found))
        every = candidates_of(table.every, found)
        travel = np.inf if self._whole else self._travel
        self._moving = moving_of(table, every, travel, self._moving)
        self._divide(table, every)
        self._left = min(self._left, _TURNS * _TURNED[0])
        return True

    def awake(
        self, laws: Contact, table: Table, u: np.ndarray, values: np.ndarray, dt: float
    ) -> Patches:
        """The patches that may have a pair in a step, whose gaps are found.

        `u` and `values` are displacements of the share's vertices, (v, 4), and their records.
        """
        share, patches = self.share, self.patches
        moving = (
            share.moving, self._first, table.around, self._marks, self._chosen, self._moves,
            self._whole,
        )  # fmt: skip
        awake, self._tilts = self.call(
            find_near_gaps, self.scene.domain.frame, laws, self.walls, table.every,
            (share.cells, u, values), (dt, self.far), (self.candidates, patches),
            (moving, self.scratch, self._row),
        )  # fmt: skip
        if awake != len(self._awake.awake):
            self._awake = patches.first(awake)
        return self._awake

    @property
    def _unwatched(self) -> float:
        """Cells by which bodies may move before some may meet that are not watched."""
        return self._travel * (1.0 if self.scene.domain.periods.any() else 1.0 + _WATCHED)

    def _find_left(self, rank: RankState, table: Table, rigid: Any) -> float:
        """Cells by which bodies may move relative to each other until the next search; collective.

        It may be below 0.
        """
        scene, clusters = self.scene, (table.first, table.members)
        if scene.domain.periods.any():  # a cell may have vertices at both ends
            now = self.all_displacements(rank, table, self._records)
        else:
            now, own = np.full(self._before.shape, np.nan), np.flatnonzero(self._shared >= 0)
            records = rank.grid.kept.values.reshape(-1, RECORD)
            now[own, :3] = records.take(self._shared[own], axis=0)[:, U]
        ends = np.full((2, len(table.body), scene.dimension + 1), np.inf)
        moved = now, self._before, now - self._before
        of = table.surface, table.cells, clusters, moved, (rigid, self._poses)
        self.call(find_shifts, scene.domain.frame, *of, ends)
        ends = least(self.comm, ends)
        ends[:, :, -1] *= _TURNS
        most, turned = 2.0 * self._unwatched, tuple(_TURNS * most for most in _TURNED)
        more = turned[0] + most - 2.0 * self._travel
        return float(self.call(least_left, *self._watched, (most, more), turned, ends))

    def way(self, rank: RankState, dt: float) -> float:
        """See `greatest_way`; of the rank's vertices of surfaces."""
        return float(self.call(greatest_way, rank.grid.frame, self._records, rank.grid.kept, dt))

    def has(self, bodies: np.ndarray) -> np.ndarray:
        """Mask of the pairs of bodies, (n, 2), in the rank's groups; on the root those in none."""
        groups = self.groups
        found = np.full(len(bodies), self.root)
        some = groups.of[bodies].max(axis=1) >= 0
        found[some] = groups.rank[groups.number(bodies[some])]
        return found == self.comm.rank

    def _divide(self, table: Table, every: np.ndarray, known: np.ndarray | None = None) -> None:
        """Find the groups of all candidates, and the rank's share; collective.

        `known` is of their patches, see `Patches`.
        """
        surface, count = table.every, len(self.labels)
        patches = Patches.of(surface, every)
        start, known = patches.start, patches.known if known is None else known
        first = every[start[:-1]]
        met = surface.body[first["facet"]] * count + first["body"]
        met, of = np.unique(met, return_inverse=True)
        self.met, size = np.column_stack(np.divmod(met, count)), np.diff(start)
        of, x = np.repeat(of, size), surface.x[every["facet"], 0]
        self.groups = find_groups(self.labels, self.met, of, x, self.comm.size)
        if self.alone:
            self.groups.rank[:] = self.root
        own = self.groups.rank[self.groups.number(self.met)] == self.comm.rank
        mine, patch_of = np.flatnonzero(own[of]), np.repeat(np.arange(len(size)), size)
        here = np.unique(patch_of[mine])
        self.candidates = every
        if self.comm.size > 1:
            self.candidates = every[mine]
            patches = Patches.of(surface, self.candidates)
        self._found = every, known, mine, here
        surface.now[:] = np.inf
        self.share = share_of(self.comm, table, self._moving, self.groups, self._records)
        self.patches = patches._replace(known=known[here])
        self._awake = self.patches
        count, moving = len(table.around[0]) - 1, self.share.moving
        self._chosen = np.empty(len(moving) + 2 * len(mine), np.int64)
        self._marks, self._moves[0] = np.zeros(count, np.bool_), 0
        self._first = np.searchsorted(surface.patch[moving], np.arange(count + 1))
        room = PIECES * len(mine)
        room += _MORE_PIECES * int((self.candidates["facet"] >= len(table.wide)).sum())
        if len(self.scratch[-1][0]) < room:
            kept = kept_of(self.scene.dimension, room * 5 // 4)
            self.scratch = (*self.scratch[:-1], kept)
