"""Selection of the particles and vertices where contact is possible, kept for several steps."""

from __future__ import annotations

from typing import Any

import numpy as np

from pgimp.decomposition.grid import Grid
from pgimp.jit.bound import Bound
from pgimp.jit.rehearsal import needed
from pgimp.kernels.contact.lagrangian.candidates import Patches, find_candidates, find_reach
from pgimp.kernels.contact.lagrangian.filled import bound_filled, keep_possible
from pgimp.kernels.contact.lagrangian.hash_table import table_size
from pgimp.kernels.contact.lagrangian.pairs import SeparatingWalls
from pgimp.kernels.contact.lagrangian.reference_numbers import (
    PART,
    References,
    ReferenceSupports,
    find_reference_supports,
    keep_numbers,
    number_reference_vertices,
)
from pgimp.kernels.contact.lagrangian.rigid_ends import RIGID_FILL
from pgimp.kernels.contact.lagrangian.supports import Supports, find_supports, local_vertices
from pgimp.kernels.contact.lagrangian.travel import Tracked, greatest_travel, track, track_on
from pgimp.kernels.contact.lagrangian.vertices import (
    NEAR_MOTION,
    NEAR_PARTICLE,
    VERTEX_SUMS,
    ContactVertices,
    Reached,
    copy_near_motion,
    copy_near_particles,
)
from pgimp.kernels.contact.volumes import BOXES
from pgimp.kernels.data.frame import AxialInitialFrame, InitialFrame
from pgimp.kernels.rigid.bodies import AnyRigidBodies
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.contact.lagrangian.messages import greatest, swap, swap_parts
from pgimp.solver.contact.lagrangian.parts import SlaveKeys, move_to_boxes, parts_near
from pgimp.solver.contact.lagrangian.selected import Given, Selection, mirrors_of, plain
from pgimp.solver.contact.lagrangian.shares import FAR, divide, undivided
from pgimp.solver.rank_state import RankState

#: Least and greatest slack, in cells, of particles and rigid bodies until the next selection; the
#: steps at the greatest speed for which it should last.
MIN_SLACK, MAX_SLACK, SLACK_STEPS = 0.05, 0.3, 8


class Selector:
    """Makes selections, and knows how long one lasts.

    Parameters
    ----------
    rigid_bodies : RigidBodies or ()
        The rigid bodies at their positions.
    walls : SeparatingWalls
        The unilateral walls.
    faces : Faces or ()
        All walls at rest.

    Attributes
    ----------
    acts : (groups, groups + rigid bodies) int8
        How groups act on each other and on rigid bodies.
    groups, fields : (bodies,) int64
        Groups of bonded bodies, and their velocity fields on the reference grid.
    local : (k, 3) uint32
        See `Supports`.
    root : int
        The rank with the first layer.
    """

    def __init__(
        self,
        scene: Scene,
        comm: Communicator,
        rigid_bodies: AnyRigidBodies,
        walls: SeparatingWalls,
        faces: Any,
    ) -> None:
        self.scene, self.comm, self.call = scene, comm, Bound()
        self.acts, self._faces = (
            np.zeros((1, 1 + len(scene.interaction.rigid_bodies)), np.int8),
            faces,
        )
        frame = AxialInitialFrame if scene.case.axisymmetric else InitialFrame
        self._frame, self._plain = frame(*scene.domain.frame), plain(scene)
        self._rigid_bodies, self._walls = rigid_bodies, walls
        self.groups, self.fields = np.zeros((2, len(scene.body_names)), np.int64)
        self.mirrors = mirrors_of(scene)
        self.local = local_vertices(scene.settings.uncut.vertices(), scene.dimension)
        self._initial = local_vertices(scene.settings.vertices, scene.dimension)
        self._shares, self.root = undivided(comm.size), 0
        self._slack = self._rigid_slack = self._travel = 0.0
        self._table, self._parts = np.empty(0, NEAR_PARTICLE), np.empty((0, PART))
        self._window: Any = None
        self._tracked = Tracked.empty()

    def lasts(self, grid: Grid, travel: float) -> bool:
        """Whether the last selection still holds; collective.

        `travel` is the distance of rigid bodies since the step before, in cells.
        """
        self._travel += travel
        if self.scene.settings.mixed:
            return False
        most = np.inf
        if needed(self._window is grid.window):
            most = self.call(greatest_travel, self.scene.domain.frame, grid.field, self._tracked)
        if self._travel > self._rigid_slack:
            most = np.inf
        return greatest(self.comm, most) <= self._slack

    def select(
        self, rank: RankState, near: np.ndarray, speeds: tuple[float, float], looked: bool
    ) -> Selection:
        """Find the candidate vertices, and the particles within their reach; collective.

        Parameters
        ----------
        rank : RankState
            This rank.
        near : (n,) int64
            Offsets in the canonical order of particles near contact.
        speeds : (float, float)
            Greatest distances in cells that particles and rigid bodies move in a step.
        looked : bool
            Whether these are other particles than in the last selection.
        """
        scene, call, comm, grid, population = (
            self.scene, self.call, self.comm, rank.grid, rank.population
        )  # fmt: skip
        speed, rigid_speed = speeds
        slack, rigid = (
            min(MAX_SLACK, SLACK_STEPS * speed),
            min(MAX_SLACK, SLACK_STEPS * rigid_speed),
        )
        self._slack = 0.0 if scene.settings.mixed else max(MIN_SLACK, slack)
        self._rigid_slack = 0.0 if scene.settings.mixed else rigid
        self._travel, anew = 0.0, looked or scene.settings.mixed or self._window is not grid.window
        self._window = grid.window
        if population.outdated:
            population.update(near)
        rows = population.order[near].astype(np.int64)
        motion = np.empty(len(rows), NEAR_MOTION)
        particles = population.columns
        bodies = self.groups, self.fields, scene.settings.lagrangian
        call(copy_near_motion, self._plain, particles, rows, motion)
        exact = rank.slaves and not scene.settings.mixed  # beside others these meet by surfaces
        slaves = SlaveKeys(rank, 1 + int(self.fields.max())) if exact else None
        if slaves:
            move_to_boxes(scene, particles, rows, motion)
        if anew:
            self._table = np.empty(len(rows), NEAR_PARTICLE)
            call(copy_near_particles, self._plain, particles, rows, *bodies, self._table)
            if slaves:
                self._parts = parts_near(scene, particles, rows, self._table)
            self._tracked = call(
                track, self._frame, grid.field, self._table, self.local, self.mirrors
            )
        if needed(not anew):
            call(track_on, grid.field, self._tracked)
        table, pieces = self._table, self._parts
        if comm.size == 1:
            rows, chosen, _ = self._choose(table, motion, pieces, slaves)
            mine, none = near[rows], np.empty(0, np.int64)
            return chosen._replace(given=Given(mine, mine, chosen.keys, none, none))
        first, last = self._ranges(table, motion)
        if looked:
            first_layer = grid.slab.layers and grid.slab.lower is None
            self.root = -int(greatest(comm, -comm.rank if first_layer else -comm.size))
            most = np.array(scene.domain.frame.cells) + 2 * scene.domain.frame.ghost + 1
            self._shares = divide(comm, first, scene.settings.uncut.vertices(), most)
        parts = [self._shares.reached(first, last, r) for r in range(comm.size)]
        table, sent, received = swap_parts(comm, [table[part] for part in parts])
        motion = swap(comm, np.concatenate([motion[part] for part in parts]), sent, received)
        if slaves:
            pieces = swap(comm, np.concatenate([pieces[part] for part in parts]), sent, received)
        kept, chosen, found = self._choose(table, motion, pieces, slaves)
        owners = slaves.owners(grid, comm, found.keys) if slaves else None
        return self._agree([near[part] for part in parts], received, owners, kept, chosen, found)

    def _agree(
        self,
        near: list[np.ndarray],
        received: np.ndarray,
        owners: np.ndarray | None,
        kept: np.ndarray,
        chosen: Selection,
        found: References,
    ) -> Selection:
        """Tell other ranks which of the particles they sent are selected; collective."""
        ends = np.cumsum(received)
        source = np.searchsorted(ends, kept, side="right")
        back = kept - (ends - received)[source]
        sources = np.arange(self.comm.size)
        offsets, counted, asked = swap_parts(self.comm, [back[source == r] for r in sources])
        of_key = source[found.particle]  # ascending
        if owners is not None:  # of masters, which no particle has
            of_key = np.where(found.particle < 0, owners, of_key)
            order = np.argsort(of_key, kind="stable")
            chosen = chosen._replace(order=np.argsort(found.keys[order]))
        parts = [found.keys[of_key == r] for r in sources]
        wanted, vertices, asked_vertices = swap_parts(self.comm, parts)
        pieces = np.split(offsets, np.cumsum(asked)[:-1])
        mine = np.concatenate([some[piece] for some, piece in zip(near, pieces, strict=True)])
        given = Given(np.unique(mine), mine, wanted, asked, asked_vertices)
        return chosen._replace(given=given, particles=counted, vertices=vertices)

    def _ranges(self, table: np.ndarray, motion: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """First and last vertices that particles may reach, each (n, 3) float64."""
        frame, D = self.scene.domain.frame, self.scene.dimension
        away = table["half_width"][:, :D] + (self._slack + 1e-6)
        at = (motion["position"][:, :D] - np.array(frame.origin)) * np.array(frame.inverse)
        first, last = np.zeros((2, len(table), 3))
        first[:, :D] = np.floor(at - away) + frame.ghost
        last[:, :D] = np.floor(at - table["half_width"][:, :D] + self._slack + 1e-6)
        last[:, :D] += frame.ghost + self.scene.settings.uncut.vertices() - 1
        return first, last

    def _choose(
        self, table: np.ndarray, motion: np.ndarray, parts: np.ndarray, slaves: SlaveKeys | None
    ) -> tuple[np.ndarray, Selection, References]:
        """Particles within reach of candidate vertices in this rank's share.

        Returns their offsets, a selection without what ranks give each other, and the reference
        vertices in the order in which the particles have them.
        """
        scene, call = self.scene, self.call
        frame, slack, vertices = scene.domain.frame, self._slack, scene.settings.uncut.vertices()
        groups, none = 1 + int(self.groups.max()), np.empty(0, np.int64)
        low, extent = np.zeros(3, np.int64), np.ones(3, np.int64)
        bodies = len(scene.interaction.rigid_bodies)
        if len(table):
            first, last = self._ranges(table, motion)
            low = first.min(axis=0).astype(np.int64)
            extent = last.max(axis=0).astype(np.int64) - low + 1
        contact_vertices = ContactVertices(
            low, extent, groups, none, none, none.astype(np.uint32), Reached.empty(0, 0),
            np.empty(0, VERTEX_SUMS), np.empty((0, bodies), RIGID_FILL), none,
        )  # fmt: skip
        within, boxes = self._shares.within(self.comm.rank), self._wall_boxes()
        patches = call(
            find_candidates, frame, (table, motion), (slack, self._rigid_slack), vertices, within,
            boxes, self._rigid_bodies, contact_vertices,
        )  # fmt: skip
        order = self._possible(table, motion, patches, contact_vertices, boxes)
        rank = np.full(len(patches.keys), -1)
        rank[order] = np.arange(len(order))
        reach = call(find_reach, frame, table, motion, slack, vertices, patches, rank, len(order))
        contact_vertices = contact_vertices._replace(
            keys=patches.keys[order],
            start=reach.start,
            particle=reach.particle,
            reached=Reached.empty(len(order), len(reach.particle)),
            sums=np.empty(len(order), VERTEX_SUMS),
            fills=np.zeros((len(order), bodies), RIGID_FILL),
        )
        table = table[reach.rows]
        start = Supports.empty(len(table), self._initial, scene.case.axisymmetric and not slaves)
        fields = 1 + int(self.fields.max())
        half, x = (np.ascontiguousarray(table[name]) for name in ("half_width", "weight_position"))
        own = np.zeros_like(half) if slaves else half
        # Those of rings are about their mass's centroid, as in the plane.
        initial_frame = InitialFrame(*scene.domain.frame) if slaves else self._frame
        call(find_supports, scene.settings.shape, initial_frame, own, x, start)
        initial = ReferenceSupports.empty(len(table))
        call(find_reference_supports, frame, start, initial)
        found = call(number_reference_vertices, frame, table, start, self.mirrors, fields)
        if slaves:
            found = slaves.with_masters(found)
        order = np.argsort(found.keys)
        nothing = Given(none, none, none, none, none)
        cut = bool(table["cut"].any())
        keys = found.keys[order]
        hashes = np.full((table_size(len(keys)), 2), -1, np.int64)
        call(keep_numbers, keys, hashes)
        chosen = Selection(
            nothing, table, half, cut, contact_vertices, initial, hashes, keys, order, none, none,
            slaves.parts(parts[reach.rows], keys) if slaves else (),
        )  # fmt: skip
        return reach.rows, chosen, found

    def _possible(
        self,
        table: np.ndarray,
        motion: np.ndarray,
        patches: Patches,
        contact_vertices: ContactVertices,
        boxes: np.ndarray,
    ) -> np.ndarray:
        """Entries of vertices where there may be contact, in the order of their keys."""
        order, scene = np.argsort(patches.keys), self.scene
        # Bounds are of boxes in the plane.
        if scene.case.axisymmetric or not isinstance(scene.settings.uncut, BOXES):
            return order
        most, kept = np.empty(len(order)), np.empty(len(order), bool)
        frame, keys = scene.domain.frame, patches.keys[order]
        self.call(
            bound_filled,
            frame,
            table,
            motion,
            self._slack,
            scene.settings.uncut.vertices(),
            patches,
            most,
        )
        self.call(
            keep_possible,
            frame,
            (self._faces, boxes, self._rigid_bodies),
            self._rigid_slack,
            self.acts,
            (most[order], keys % contact_vertices.groups),
            contact_vertices._replace(keys=keys),
            kept,
        )
        return order[kept]

    def _wall_boxes(self) -> np.ndarray:
        """Least and greatest numbers of vertices at unilateral walls, (n, 2, 3) int64."""
        boxes = np.full((len(self._walls.planes), 2, 3), [[[-FAR], [FAR]]])
        for n, (axis, side, place, *_) in enumerate(self._walls.planes.tolist()):
            boxes[n, int(side < 0), axis] = place
        return boxes
