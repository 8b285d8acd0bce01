"""The surfaces of a scene's bodies and rigid bodies, in patches, with the cells that move them."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np

from pgimp.geometry.rows import distinct, each_once
from pgimp.jit.bound import Bound
from pgimp.jit.rehearsal import needed
from pgimp.kernels.contact.surfaces.data import Surface, SurfaceCells
from pgimp.kernels.contact.surfaces.motion import find_means
from pgimp.kernels.contact.surfaces.search import find_beside, find_tips, keys_of_vertices
from pgimp.kernels.data.motion import KEPT_MASS
from pgimp.kernels.data.record import RECORD
from pgimp.scene.bodies.clouds.point_cloud import Cloud
from pgimp.scene.bodies.lattice import Lattice
from pgimp.scene.bodies.lattice_body import LatticeBody
from pgimp.scene.bodies.surface_elements import find_elements
from pgimp.scene.bodies.surface_patches import Facets
from pgimp.scene.bodies.surfaces.boxes import Closed
from pgimp.scene.scene import Scene
from pgimp.solver.contact.grown import grown
from pgimp.solver.contact.impulses.messages import united
from pgimp.solver.contact.surfaces.box_bodies import boxes_of
from pgimp.solver.contact.surfaces.divided import Ends, all_facets
from pgimp.solver.contact.surfaces.rectangles import with_wide
from pgimp.solver.contact.surfaces.seams import closed_faces, one_period, places_with_images
from pgimp.solver.lagrangian.masters import Vertices
from pgimp.solver.rank_state import RankState

#: Cells along a side of a cluster of facets.
WIDE = 4

#: Greatest cosine between normals at a sharp edge.
SHARP = 0.3

#: Greatest distance of neighbouring facets, in cells, by dimensions.
_BESIDE = (1.0, 0.3, 0.4)

#: Cells from an edge within which no facets are joined.
_EDGE = 0.3

#: Cells behind a facet where its cell is looked for, the first whose vertices all have mass.
_DEPTHS = (1e-6, 0.1, 0.3, 0.6, 1.0, 1.5)


class Table(NamedTuple):
    """Facets of all bodies, equal on all ranks."""

    surface: Surface  #: The facets.
    cells: SurfaceCells  #: The cells that they are in.
    numbers: np.ndarray  #: (v, 4) int64: Numbers along x, y, z and fields of their vertices.
    keys: np.ndarray  #: (v,) int64: Keys of these, as of reference vertices.
    #: first, members: (m + 1,) and (n,) int64: The facets of each cluster.
    first: np.ndarray
    members: np.ndarray
    body: np.ndarray  #: (m,) int64: The clusters' bodies.
    #: owner, corner: (k,) int64: Clusters, and the vertices of their cells, each pair once.
    owner: np.ndarray
    corner: np.ndarray
    #: (k, D) int64: Periods of the domain from these vertices to the cells' corners.
    turns: np.ndarray
    #: ((patches + 1,) int64, (k,) int64): Patches beside each, with facets beside its own.
    around: tuple[np.ndarray, np.ndarray]
    every: Surface  #: The same facets, in the same memory, and after them wide ones.
    wide: np.ndarray  #: (n,) int64: The wide one that each facet is part of, or -1.

    def facets(self, clusters: np.ndarray) -> np.ndarray:
        """The facets of some clusters."""
        begin, count = self.first[clusters], self.first[clusters + 1] - self.first[clusters]
        at = np.arange(count.sum()) + np.repeat(begin - np.cumsum(count) + count, count)
        return self.members[at]


def table_of(rank: RankState, fields: tuple[int, ...]) -> Table:
    """Find the surfaces of all bodies; collective."""
    scene, frame = rank.scene, rank.scene.domain.frame
    D, cell = scene.dimension, np.array(frame.cell)
    origin, periods = np.array(frame.origin), np.zeros(3)
    periods[:D] = scene.domain.periods
    # What lies on a wall that lets go meets it.
    letting = {(face.axis, face.side) for face in scene.domain.faces if face.condition.approaches}
    closed = [face for face in scene.interaction.loads.surfaces.closed if face not in letting]
    gone = [scene.body_names.index(name) for name in scene.case.staged.removed]
    gone += np.flatnonzero(~scene.settings.lagrangian).tolist()  # of these facets know nothing
    rigid = dict(enumerate(_rigid_bodies(scene), len(scene.body_names)))
    every = _bodies(rank, gone) | rigid
    here = [*every]
    if needed(0):  # what has no facets has the same kernels, but for those that measure one plane
        for number in here:
            middle = sum(every[number].box[0]) // 2
            find_elements(every[number], None, (middle, middle + 1), ())
        here = []
    ends = [_ends(scene, every[number], number, closed) for number in here]
    found = all_facets(rank.comm, [every[number] for number in here], origin, cell, ends)
    body = np.repeat(np.array(here, np.int64), [len(each.x) for each in found])
    facets = Facets.joined(found)
    soft = body < len(scene.body_names)
    cells, of, numbers = _cells(rank, facets, body, soft, fields)
    index = np.full(len(body), -1)
    index[soft] = of
    place = np.zeros((len(body), 3))
    place[soft, :D] = (facets.x[soft, :D] - cells.low[of, :D]) / cell
    start, beside = _beside(scene, facets.x, body, float(cell.max()) * _BESIDE[D - 1])
    sizes = np.bincount(facets.patch, facets.area).astype(float)[facets.patch]
    surface = Surface(
        facets.x, facets.normal, facets.middle, facets.half, facets.area, facets.radius,
        facets.patch, sizes, body, index, place, facets.edges, np.zeros(len(body), np.uint8), start,
        beside, np.full((len(body), 3), np.inf), np.zeros((len(body), 3)),
        np.zeros((len(body), 2, 3)), np.zeros((len(body), 2**D)), periods if periods.any() else (),
    )  # fmt: skip
    inside, towards = np.zeros(len(body), bool), np.zeros((len(body), 3))
    find_tips(surface, SHARP, _EDGE * float(cell.max()), inside, towards)
    number = np.floor((facets.x[:, :D] - origin) / cell - _DEPTHS[0] * facets.normal[:, :D])
    whole, wide = with_wide(surface, (inside, towards), cell, number.astype(np.int64))
    if scene.case.axisymmetric or not scene.settings.lagrangian.all():
        whole, wide = surface, np.full(len(body), -1)
    find_means(frame, whole, np.zeros((2, 3)))
    own = {name: values[: len(body) + (name == "start")] for name, values in
           whole._asdict().items() if name not in ("beside", "periods")}  # fmt: skip
    surface = surface._replace(**own)
    keys = np.empty(len(numbers), np.int64)
    keys_of_vertices(bits_of(frame, 1 + max(fields, default=0)), numbers, keys)
    number = np.floor((facets.x[:, :D] - origin) / (WIDE * cell)).astype(np.int64)
    cluster = distinct(np.column_stack([body, number]))[1]
    count = 1 + cluster.max(initial=-1)
    members = np.argsort(cluster, kind="stable")
    first = np.concatenate([[0], np.cumsum(np.bincount(cluster, minlength=count))])
    each = np.column_stack([cluster[soft], of])
    owner, of_cell = each[distinct(each)[0]].T
    at = np.rint((cells.low[of_cell, :D] - origin) / cell).astype(np.int64) + frame.ghost
    at = (at[:, None] + np.array([*product((0, 1), repeat=D)])).reshape(-1, D)
    corner = cells.corners[of_cell].reshape(-1)
    turns = (at - numbers[corner, :D]) // np.array(frame.cells)
    pair = np.column_stack([np.repeat(owner, 2**D), corner, turns])
    owner, corner, *turns = pair[distinct(pair)[0]].T
    return Table(
        surface, cells, numbers, keys, first, members, body[members[first[:-1]]],
        np.ascontiguousarray(owner), np.ascontiguousarray(corner), np.stack(turns, axis=1),
        _around(facets.patch, start, beside), whole, wide,
    )  # fmt: skip


def _ends(scene: Scene, body: LatticeBody, number: int, held: Closed) -> Ends:
    """Where a body's surface ends; a rigid one's number comes after the others'."""
    ring, periods = scene.case.axisymmetric, scene.domain.periods
    if number < len(scene.body_names):
        return Ends(closed_faces(scene, body, held), ring, (periods,))
    entry = scene.interaction.rigid_bodies.entries[number - len(scene.body_names)]
    return Ends((), ring, one_period(body, entry, scene.domain.frame, periods))


def _bodies(rank: RankState, gone: list[int]) -> dict[int, LatticeBody]:
    """Bodies, but those that are `gone`, by their numbers; collective."""
    found: dict[int, LatticeBody] = {}
    for number, body in enumerate(Lattice(rank.scene.case).bodies):
        if number in gone:
            continue
        if isinstance(body, Cloud):
            found[number] = boxes_of(rank, number)
        elif body.exact:
            found[number] = body
        else:  # whatever weights its particles have, it meets others where it ends
            found[number] = LatticeBody(body.region, body.edges, body.centres, body.cut, body.cut)
    return found


def _rigid_bodies(scene: Scene) -> list[LatticeBody]:
    """Rigid bodies on lattices of their own, as fine as the particles' boxes."""
    found, frame = [], scene.domain.frame
    size = np.array(frame.cell) / scene.case.method.particles_per_cell
    extent = np.array(frame.cells) * frame.cell
    for entry in scene.interaction.rigid_bodies.entries:
        low, high = (np.array(end, float) for end in entry.region.bounds())
        origin = np.array(frame.origin)
        low, high = np.maximum(low, origin - extent), np.minimum(high, origin + 2.0 * extent)
        begin = np.floor((low - origin) / size).astype(np.int64) - 1
        end = np.ceil((high - origin) / size).astype(np.int64) + 1
        edges = [origin[d] + np.arange(begin[d], end[d] + 1) * size[d] for d in range(len(size))]
        centres = [0.5 * (each[1:] + each[:-1]) for each in edges]
        found.append(LatticeBody(entry.region, edges, centres, cut=True, exact=True))
    return found


def bits_of(frame: object, fields: int) -> tuple[int, int, int]:
    """See `pgimp.kernels.contact.impulses.reference_grid.key_bits`."""
    most = (*frame.vertices, 1, 1)[1:3]  # type: ignore[attr-defined]
    return (*((int(n) - 1).bit_length() for n in most), (fields - 1).bit_length())  # type: ignore


def _cells(
    rank: RankState, facets: Facets, body: np.ndarray, soft: np.ndarray, fields: tuple[int, ...]
) -> tuple[SurfaceCells, np.ndarray, np.ndarray]:
    """Cells that facets are in, the cell of each facet, and all vertices that move these."""
    scene, frame, slaves = rank.scene, rank.scene.domain.frame, rank.slaves
    D, cell, origin = scene.dimension, np.array(frame.cell), np.array(frame.origin)
    corner = np.array([*product((0, 1), repeat=D)])
    x, normal, body = facets.x[soft, :D], facets.normal[soft, :D], body[soft]
    field = np.array(fields or [0] * len(scene.body_names), np.int64)[body]
    number, left = np.zeros((len(x), D), np.int64), np.arange(len(x))
    for depth in _DEPTHS:
        if not len(left):
            break
        own = np.floor((x[left] - origin) / cell - depth * normal[left]).astype(np.int64)
        first, of = distinct(np.column_stack([field[left], own]))
        some = Vertices.key(
            rank, (own[first, None] + frame.ghost + corner).reshape(-1, D),
            np.repeat(body[left[first]], len(corner)),
        )  # fmt: skip
        known = _have_mass(rank, some)
        if slaves:
            known |= np.isin(some, slaves.keys)
        good = np.asarray(known.reshape(-1, len(corner)).all(axis=1))[of]
        if depth == _DEPTHS[0]:
            number[:] = own
        number[left[good]] = own[good]
        left = left[~good]
    first, of = distinct(np.column_stack([field, number]))
    places = np.column_stack([field, number])[first]
    corners = Vertices.key(
        rank, (places[:, None, 1:] + frame.ghost + corner).reshape(-1, D),
        np.repeat(body[first], len(corner)),
    )  # fmt: skip
    # What moves each vertex of a cell: itself, or its masters.
    row = np.repeat(np.arange(len(places)), len(corner))
    which = np.tile(np.arange(len(corner)), len(places))
    moved, weight = corners[:, None], np.ones((len(corners), 1))
    entries = [(row, moved[:, 0], which, weight[:, 0])]
    if slaves and len(slaves.keys):
        at = np.minimum(np.searchsorted(slaves.keys, corners), len(slaves.keys) - 1)
        follows = slaves.keys[at] == corners
        entries = [tuple(each[~follows] for each in entries[0])]  # type: ignore[list-item]
        for e in range(slaves.of.shape[1]):
            entries.append(
                (
                    row[follows],
                    slaves.masters[slaves.of[at[follows], e]],
                    which[follows],
                    slaves.weights[at[follows], e],
                )
            )
    row, moved, which, weight = (np.concatenate(each) for each in zip(*entries, strict=True))
    every = each_once(np.concatenate([corners, moved]))
    column = np.searchsorted(every, moved)
    pairs = np.column_stack([row, column])
    first, entry = distinct(pairs)
    pairs, weights = pairs[first], np.zeros((len(first), len(corner)))
    np.add.at(weights, (entry, which), weight)
    start = np.concatenate([[0], np.cumsum(np.bincount(pairs[:, 0], minlength=len(places)))])
    low, plain = np.zeros((len(places), 3)), np.diff(start) == len(corner)
    low[:, :D] = origin + places[:, 1:] * cell
    rows = start[:-1][plain, None] + np.arange(len(corner))
    plain[plain] = (weights[rows] == np.eye(len(corner))).all(axis=(1, 2))
    cells = SurfaceCells(
        low, np.searchsorted(every, corners).reshape(-1, len(corner)), start,
        np.ascontiguousarray(pairs[:, 1]), weights, _cells_beside(places),
        plain,
    )  # fmt: skip
    return cells, of, np.stack(Vertices.numbers(rank, every), axis=1)


def _cells_beside(places: np.ndarray) -> np.ndarray:
    """The cells below and above along each direction, (m, 6); -1 for none.

    `places` are fields and numbers along the directions, (m, 1 + D), ascending.
    """
    found = np.full((len(places), 6), -1)
    if not len(places):
        return found
    inside = places - places.min(axis=0) + 1
    shape = tuple(inside.max(axis=0) + 2)
    keys = np.ravel_multi_index(tuple(inside.T), shape)
    for d in range(1, places.shape[1]):
        step = int(np.prod(shape[d + 1 :]))
        for side in (0, 1):
            moved = keys + (2 * side - 1) * step
            at = np.minimum(np.searchsorted(keys, moved), len(keys) - 1)
            found[:, 2 * (d - 1) + side] = np.where(keys[at] == moved, at, -1)
    return found


def _have_mass(rank: RankState, keys: np.ndarray) -> np.ndarray:
    """Mask of the vertices with mass on any rank; collective."""
    at = records_of(rank, np.stack(Vertices.numbers(rank, keys), axis=1))
    grid = rank.grid
    masses = grid.by_vertex(grid.kept.values)[..., KEPT_MASS].copy()
    for seam in rank.scene.domain.seams:  # both copies have parts
        inside, beyond = grid.copies(masses, seam.axis)
        inside += beyond
    mass = masses.reshape(-1)
    found = np.zeros(len(keys), np.uint8)
    found[at >= 0] = mass[at[at >= 0]] > 0.0
    return united(rank.comm, found).astype(bool)


def records_of(rank: RankState, numbers: np.ndarray, more: int = 0) -> np.ndarray:
    """Numbers of vertices' records, -1 where the rank does not own them, or `more` planes above."""
    grid = rank.grid
    (i, j, k), field = (numbers[:, :3] - grid.window.lower).T, numbers[:, 3]
    there = (i >= 0) & (i < min(grid.owned + more, grid.planes))
    for each, most in zip((j, k), grid.window.extent[1:], strict=True):
        there &= (each >= 0) & (each < most)
    stride = [s // RECORD for s in grid.window.stride]
    size = grid.window.extent[1] * grid.window.extent[2]
    return np.where(there, i * stride[0] + field * size + j * stride[1] + k * stride[2], -1)


def _beside(
    scene: Scene, x: np.ndarray, body: np.ndarray, radius: float
) -> tuple[np.ndarray, np.ndarray]:
    """Neighbours of each facet, see `Surface`."""
    count, origin, periods = len(x), scene.domain.frame.origin, scene.domain.periods
    every, placed = places_with_images(x, origin, periods, radius)
    x, body = placed, body[every]
    start = np.zeros(len(x) + 1, np.int64)
    key_of, strides = bins_of(x, radius, scene.dimension)
    order = np.argsort(key_of, kind="stable")
    call = Bound()
    beside, _ = grown(
        16 * len(x) + 16,
        lambda size: np.empty(size, np.int64),
        lambda room: call(
            find_beside, x, body, key_of, (key_of[order], order), strides, radius, start, room
        ),
    )
    return start[: count + 1], every[beside[: start[count]]]


def bins_of(x: np.ndarray, side: float, D: int) -> tuple[np.ndarray, np.ndarray]:
    """Keys of the bins that points, (n, 3), are in, and the strides of keys by direction."""
    bins = np.floor(x / side).astype(np.int64)
    bins -= bins.min(axis=0, initial=1 << 60) - 1
    extent = bins.max(axis=0, initial=0) + 2
    strides = np.array([extent[1] * extent[2], extent[2], 1])
    key_of = bins @ strides
    strides[D:2] = 0  # neighbours along the last one have neighbouring keys
    return key_of, strides


def _around(
    patch: np.ndarray, start: np.ndarray, beside: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Patches beside each patch, given those of facets, see `Table`, and neighbours of these."""
    count = 1 + int(patch.max(initial=-1))
    own, other = np.repeat(patch, np.diff(start)), patch[beside]
    keys = each_once((own * count + other)[own != other])
    own, other = np.divmod(keys, max(count, 1))
    return np.concatenate([[0], np.cumsum(np.bincount(own, minlength=count))]), other
