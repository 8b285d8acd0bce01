"""Which facets may soon meet another body: boxes of clusters, clusters that meet, facets."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from pgimp.jit.bound import Bound
from pgimp.jit.rehearsal import needed
from pgimp.kernels.contact.impulses.pairs import SeparatingWalls
from pgimp.kernels.contact.surfaces.data import no_facets
from pgimp.kernels.contact.surfaces.nearest import ACROSS
from pgimp.kernels.contact.surfaces.search import (
    bound_clusters,
    find_close,
    find_meeting,
    mark_between,
)
from pgimp.mpi.communicator import Communicator
from pgimp.scene.scene import Scene
from pgimp.solver.contact.grown import grown
from pgimp.solver.contact.surfaces.seams import close_images, with_images
from pgimp.solver.contact.surfaces.table import Table, sorted_bins
from pgimp.solver.rank_state import RankState

#: Cells by which clusters' boxes reach beyond their vertices.
_BEYOND = 0.2


class Meeting(NamedTuple):
    """Clusters of facets that may meet."""

    pairs: np.ndarray  #: (n, 2) int64: Pairs of clusters.
    #: low, high: (clusters, D) float64: Boxes of all.
    low: np.ndarray
    high: np.ndarray
    on_walls: dict[int, np.ndarray]  #: For each wall the facets that may meet it.


def boxes_of(
    call: Bound, comm: Communicator, rank: RankState, table: Table, records: np.ndarray, rigid: Any
) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest coordinates of the clusters; collective.

    `records` are those of the surface vertices, -1 where another rank has one.
    """
    scene, surface = rank.scene, table.surface
    frame, D, soft = scene.domain.frame, scene.dimension, len(scene.body_names)
    cell, motion, numbers = np.array(frame.cell), rank.grid.kept, table.numbers
    ends, clusters = np.full((2, len(table.body), D), np.inf), (table.owner, table.corner)
    if table.turns.any():  # a vertex on a seam is at both ends of the domain
        numbers, records = numbers[table.corner], records[table.corner]
        numbers[:, :D] += table.turns * frame.cells
        clusters = table.owner, np.arange(len(numbers))
    call(bound_clusters, frame, numbers, records, motion, clusters, ends)
    ends = _least(comm, ends)
    hard = np.flatnonzero((table.body >= soft) & (table.body < soft + len(rigid and rigid.motion)))
    if len(hard):
        some, first = table.facets(hard), table.first[hard + 1] - table.first[hard]
        row = rigid.motion[surface.body[some] - soft]
        x = (row["rotation"] @ (surface.x[some] - row["reference"])[:, :, None])[:, :, 0]
        x, first = (x + row["centre"])[:, :D], np.cumsum(first) - first
        ends[0, hard] = np.minimum.reduceat(x, first)
        ends[1, hard] = -np.maximum.reduceat(x, first)
    return ends[0] - _BEYOND * cell, -ends[1] + _BEYOND * cell


def find_meeting_clusters(
    call: Bound, scene: Scene, walls: SeparatingWalls, table: Table, acts: np.ndarray,
    boxes: tuple[np.ndarray, np.ndarray], reach: np.ndarray,
) -> Meeting:  # fmt: skip
    """Find the clusters that may meet others, or walls, within distances by direction."""
    frame, periods, (low, high) = scene.domain.frame, scene.domain.periods, boxes
    cell, order = np.array(frame.cell), np.argsort(low[:, 0], kind="stable")
    if periods.any():
        pairs = close_images(low, high, frame.origin, periods, reach).T
        pairs = pairs[(acts | acts.T)[table.body[pairs[:, 0]], table.body[pairs[:, 1]]] != 0]
    else:
        pairs, found = grown(
            8 * len(low) + 16,
            lambda size: np.empty((size, 2), np.int64),
            lambda room: call(find_close, order, low, high, reach, table.body, acts, room),
        )
        pairs = pairs[:found]
    alone = np.flatnonzero(acts[table.body, table.body])
    on_walls, n = {}, len(scene.body_names)
    free = [*scene.interaction.rigid_bodies.free]
    moving = np.flatnonzero((table.body < n) | np.isin(table.body - n, free))
    for w, (axis, side, place, *_) in enumerate(walls.planes.tolist()):
        at = frame.origin[axis] + (place - frame.ghost) * cell[axis]
        end = (high if side > 0 else low)[moving, axis]
        near = moving[side * (at - end) < reach[axis]]
        on_walls[walls.first + w] = table.facets(near)
    return Meeting(np.concatenate([pairs, np.column_stack([alone, alone])]), low, high, on_walls)


def find_candidates(
    call: Bound, scene: Scene, walls: SeparatingWalls, table: Table, acts: np.ndarray,
    meeting: Meeting, reach: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Find facets near another body, by patch, body and number; and all facets near others.

    Returns (n,) NEAR_FACET and (m,) int64, ascending. Facets are moved.
    """
    surface, frame, most = table.surface, scene.domain.frame, float(reach.max())
    periods, marks, there = scene.domain.periods, np.zeros(len(surface.x), np.uint8), surface
    own = which = np.empty(0, np.int64)
    if periods.any():
        own = table.facets(np.unique(meeting.pairs))
        there, which = with_images(surface, own, frame.origin, periods, most)
        some = np.arange(len(which))
    else:
        clusters, boxes = (table.first, table.members), meeting[:3]
        call(mark_between, surface, clusters, boxes, most, marks)
        some = np.flatnonzero(marks)
        marks[:] = 0
    parts, count, found_near = [no_facets(0)], len(acts), marks
    if there is not surface:
        found_near = np.zeros(len(some), np.uint8)
    if needed(len(some)):
        best = np.full(count, np.inf), np.empty(count, np.int64), np.empty(count, np.int64)
        some, bins = sorted_bins(there.now, some, most, scene.dimension)
        distances = most, frame.cell[0]
        every, found = grown(
            2 * len(some) + 16,
            no_facets,
            lambda room: call(
                find_meeting, there, acts, some, bins, distances, found_near, best, room
            ),
        )
        every = every[:found]
        if there is not surface:  # what images find, they find as well
            every = every[every["facet"] < len(own)]
            every["facet"], every["other"] = which[every["facet"]], which[every["other"]]
            marks[which[found_near != 0]] = 1
        parts.append(every)
    for body, these in meeting.on_walls.items():
        axis, side, place, *_ = walls.planes[body - walls.first].tolist()
        at = frame.origin[axis] + (place - frame.ghost) * frame.cell[axis]
        away = side * (at - surface.now[these, axis])
        these = these[(away < reach[axis]) & (side * surface.turned[these, axis] > -ACROSS)]
        one = no_facets(len(these))
        one["facet"], one["body"], one["other"] = these, body, -1
        marks[these] = 1
        parts.append(one)
    every = np.concatenate(parts)
    number = surface.patch[every["facet"]] * (walls.first + len(walls.planes)) + every["body"]
    order = np.argsort(number * len(surface.x) + every["facet"], kind="stable")
    return every[order], np.flatnonzero(marks)


def _least(comm: Communicator, values: np.ndarray) -> np.ndarray:
    """The least values of all ranks; collective."""
    if comm.size == 1:
        return values
    from mpi4py import MPI

    found = np.empty_like(values)
    comm.Allreduce(values, found, MPI.MIN)
    return found
