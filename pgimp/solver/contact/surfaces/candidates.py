"""Which facets may soon meet another body: boxes of clusters, clusters that meet, facets."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from pgimp.jit.bound import Bound
from pgimp.jit.rehearsal import needed
from pgimp.kernels.contact.impulses.pairs import SeparatingWalls
from pgimp.kernels.contact.surfaces.data import Surface, no_facets
from pgimp.kernels.contact.surfaces.nearest import ACROSS, TURNS
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
from pgimp.solver.contact.surfaces.shares import marked
from pgimp.solver.contact.surfaces.table import Table, bins_of
from pgimp.solver.rank_state import RankState

#: Cells by which clusters' boxes reach beyond their vertices.
_BEYOND = 0.2


class Meeting(NamedTuple):
    """Clusters of facets that may meet."""

    pairs: np.ndarray  #: (n, 2) int64: Pairs of clusters.
    #: watched, left: (k, 2) int64, (k,) float64: See `least_left`; with pairs that are farther.
    watched: np.ndarray
    left: np.ndarray
    #: low, high: (clusters, D) float64: Boxes of all.
    low: np.ndarray
    high: np.ndarray
    facets: np.ndarray  #: (k,) int64: Facets of these pairs.
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
    ends = least(comm, ends)
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
    boxes: tuple[np.ndarray, np.ndarray], fars: tuple[float, float], ways: tuple[float, float],
) -> Meeting:  # fmt: skip
    """Find the clusters that may meet others, or walls: come nearer than the distances `fars`.

    `ways` are the cells by which both move at most until the next search, and more cells for those
    that are watched.
    """
    frame, periods, (low, high), (far, near) = scene.domain.frame, scene.domain.periods, boxes, fars
    cell, order = np.array(frame.cell), np.argsort(low[:, 0], kind="stable")
    reach, most = (far + 2.0 * way * cell for way in (ways[0], sum(ways)))
    watched, left = [np.empty((0, 2), np.int64)], [np.empty(0)]
    if periods.any():
        pairs = close_images(low, high, frame.origin, periods, reach).T
        pairs = pairs[(acts | acts.T)[table.body[pairs[:, 0]], table.body[pairs[:, 1]]] != 0]
    else:
        pairs, found = grown(
            16 * len(low) + 16,
            lambda size: np.empty((size, 2), np.int64),
            lambda room: call(find_close, order, low, high, most, table.body, acts, room),
        )
        watched.append(pairs[:found])
        a, b = watched[-1].T
        gap = np.maximum(low[a] - high[b], low[b] - high[a])
        left.append(((gap - far) / cell).max(axis=1))
        pairs = watched[-1][(gap <= reach).all(axis=1)]
    alone = np.flatnonzero(acts[table.body, table.body])
    on_walls, n = {}, len(scene.body_names)
    free = [*scene.interaction.rigid_bodies.free]
    moving = np.flatnonzero((table.body < n) | np.isin(table.body - n, free))
    for w, (axis, side, place, *_) in enumerate(walls.planes.tolist()):
        at = frame.origin[axis] + (place - frame.ghost) * cell[axis]
        end = (high if side > 0 else low)[moving, axis]
        away = side * (at - end)
        some, wall = away < most[axis], -1 - 2 * axis - (side > 0)
        watched.append(np.column_stack([moving[some], np.full(int(some.sum()), wall)]))
        left.append((np.maximum(away[some], reach[axis]) - near) / cell[axis])
        on_walls[walls.first + w] = table.facets(moving[away < reach[axis]])
    watched.append(np.column_stack([alone, alone]))
    pairs, left = np.concatenate([pairs, watched[-1]]), [*left, np.zeros(len(alone))]
    facets = table.facets(marked(len(low), [pairs.reshape(-1)]))
    return Meeting(
        pairs, np.concatenate(watched), np.maximum(np.concatenate(left), 2.0 * ways[0]), low, high,
        facets, on_walls,
    )  # fmt: skip


def runs_of(
    surface: Surface, some: np.ndarray, reach: float, cell: float, D: int
) -> tuple[Any, ...]:
    """Runs of facets that are near each other, those of a patch, for `find_meeting`.

    They are the first of each, (n + 1,) int64; bodies, (n,) int64; in the order of bins least and
    greatest coordinates, (n, 6) float64; the keys of these bins, ascending, (n,) int64, that order,
    strides, see `find_beside`, and room for ranges, (9, 2) int64; and for numbers, (n,) int64.
    """
    patch, x = surface.patch[some], surface.now[some]
    ends = (patch[1:] != patch[:-1]) | (np.abs(x[1:] - x[:-1]) > 2.0 * cell).any(axis=1)
    first = np.flatnonzero(np.concatenate([np.ones(min(1, len(some)), bool), ends]))
    low, high = np.minimum.reduceat(x, first), np.maximum.reduceat(x, first)
    side = reach + float((high - low).max(initial=0.0))
    key_of, strides = bins_of(0.5 * (low + high), side, D)
    order = np.argsort(key_of, kind="stable")
    bins = key_of[order], order, strides, np.empty((9, 2), np.int64)
    return (
        np.append(first, len(some)),
        surface.body[some[first]],
        np.concatenate([low, high], axis=1)[order],
        bins,
        np.empty(len(order), np.int64),
    )


def find_facets(
    call: Bound, surface: Surface, acts: np.ndarray, some: np.ndarray, cell: float,
    reach: tuple[float, float], part: tuple[int, int], marks: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """Find which of some facets may soon meet another body, see `find_meeting`, (n, 3) int64.

    `reach` are a distance, and by how much cosines may change, see `find_meeting`. `part` are a
    number and the number of parts of equal size of which it is: of the facets that look for others.
    """
    count, D = len(acts), surface.means.shape[1].bit_length() - 1
    best = np.full(count, np.inf), np.empty(count, np.int64), np.empty(count, np.int64)
    runs = runs_of(surface, some, reach[0], cell, D)
    begin, end = (len(runs[1]) * n // part[1] for n in (part[0], part[0] + 1))
    every, found = grown(
        2 * len(some) // part[1] + 16,
        lambda size: np.empty((size, 3), np.int64),
        lambda room: call(
            find_meeting,
            surface,
            acts,
            some,
            runs,
            (reach[0], cell, reach[1], begin, end),
            marks,
            best,
            room,
        ),
    )
    return every[:found]


def find_candidates(
    call: Bound, scene: Scene, walls: SeparatingWalls, table: Table, acts: np.ndarray,
    meeting: Meeting, reach: np.ndarray, turned: tuple[float, float], part: tuple[int, int],
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Find facets near another body, and all facets near others: of a part, see `find_facets`.

    Returns facets, bodies and the facets next to the first, (n, 3) int64, and (m,) int64. Facets
    are moved. Until the next search cosines between normals change by `turned`, of facets and of
    these and walls.
    """
    surface, frame, most = table.surface, scene.domain.frame, float(reach.max())
    periods, marks, there = scene.domain.periods, np.zeros(len(surface.x), np.uint8), surface
    turns, before_walls = (most - TURNS for most in turned)
    own = which = np.empty(0, np.int64)
    if periods.any():
        own = meeting.facets
        there, which = with_images(surface, own, frame.origin, periods, most)
        some = np.arange(len(which))
    else:
        clusters = table.first, table.members
        boxes = meeting.pairs, meeting.low, meeting.high
        call(mark_between, surface, clusters, boxes, most, marks)
        some = np.flatnonzero(marks)
        marks[:] = 0
    parts = [np.empty((0, 3), np.int64)]
    if needed(len(some)):
        found = marks if there is surface else np.zeros(len(some), np.uint8)
        every = find_facets(call, there, acts, some, frame.cell[0], (most, turns), part, found)
        if there is not surface:  # what images find, they find as well
            every = every[every[:, 0] < len(own)]
            every[:, ::2] = which[every[:, ::2]]
            marks[which[found != 0]] = 1
        parts.append(every)
    for body, these in meeting.on_walls.items() if part[0] == 0 else ():
        axis, side, place, *_ = walls.planes[body - walls.first].tolist()
        at = frame.origin[axis] + (place - frame.ghost) * frame.cell[axis]
        away = side * (at - surface.now[these, axis])
        faces = side * surface.turned[these, axis] > -ACROSS - before_walls
        these = these[(away < reach[axis]) & faces]
        marks[these] = 1
        parts.append(np.column_stack([these, np.full(len(these), body), np.full(len(these), -1)]))
    return np.concatenate(parts), np.flatnonzero(marks)


def in_order(surface: Surface, found: np.ndarray) -> np.ndarray:
    """Candidates as of `find_candidates`, by patch, body and number."""
    facet, body, _ = found.T
    return found[np.lexsort((facet, body, surface.patch[facet]))]


def candidates_of(surface: Surface, found: np.ndarray) -> np.ndarray:
    """Facets near others, (n,) NEAR_FACET, of which nothing is known; in order.

    `found` are as of `find_candidates`.
    """
    found = in_order(surface, found)
    every = no_facets(len(found))
    every["facet"], every["body"], every["other"] = found.T
    every["gap"], every["side"] = np.inf, -1
    return every


def least(comm: Communicator, values: np.ndarray) -> np.ndarray:
    """The least values of all ranks; collective."""
    if comm.size == 1:
        return values
    from mpi4py import MPI

    found = np.empty_like(values)
    comm.Allreduce(values, found, MPI.MIN)
    return found
