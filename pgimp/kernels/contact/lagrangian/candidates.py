"""Candidate vertices: where particles of several groups, rigid bodies or walls may meet soon.

Bodies move little in a step. So the vertices that they may share, and the particles within reach
of each, are found for several steps at once: wherever particles and rigid bodies move by less than
a slack. Particles in one cell are one patch, whose vertices are looked up once.
"""

from math import ceil, floor
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pgimp.jit.kernel import allocating_kernel, inner_kernel
from pgimp.kernels.contact.lagrangian.hash_table import find_or_insert, table_size
from pgimp.kernels.contact.lagrangian.rigid_ends import may_fill
from pgimp.kernels.contact.lagrangian.vertices import key_of
from pgimp.kernels.data.particles import IntArray
from pgimp.kernels.transfer.first_vertex import first_vertex


class Patches(NamedTuple):
    """Particles by cell and group, and the candidate vertices within their reach."""

    patch: IntArray  #: (n,) int64: The patch of each particle.
    #: begin, extent: (patches, 3) int64: First vertex of each, and number of vertices by direction.
    begin: IntArray
    extent: IntArray
    #: (patches, k) int64: Offsets of the group's entries at its vertices in `keys`, the last
    #: direction innermost; -1 where the vertex is no candidate.
    entry: IntArray
    some: NDArray  #: (patches,) bool: Whether a patch has candidate vertices.
    #: (m,) int64: Keys of the entries, see `pgimp.kernels.contact.lagrangian.vertices.key_of`.
    keys: IntArray

    @classmethod
    def empty(cls) -> "Patches":
        """No particles."""
        none, flat = np.empty(0, np.int64), np.empty((0, 3), np.int64)
        return cls(none, flat, flat, np.empty((0, 1), np.int64), np.empty(0, np.bool_), none)


class Reach(NamedTuple):
    """The particles within reach of each entry."""

    rows: IntArray  #: (n,) int64: Offsets of all these particles in their table, ascending.
    start: IntArray  #: (m + 1,) int64: First item of each entry in `particle`.
    particle: NDArray[np.uint32]  #: (k,) uint32: Offsets in `rows`, ascending for each entry.

    @classmethod
    def empty(cls) -> "Reach":
        """No entries."""
        none = np.empty(0, np.int64)
        return cls(none, np.zeros(1, np.int64), np.empty(0, np.uint32))


@inner_kernel
def reached_range(frame, row, motion, slack, vertices, d):
    """First and last vertex along `d` that a particle reaches when it moves by up to `slack`.

    Its support ends a cell beyond its half-width, mostly before the last of `vertices`.
    """
    if d >= len(frame.cell):
        return 0, 0
    x, half, away = motion.position[d], row.half_width[d], slack * frame.cell[d]
    low = first_vertex(frame, d, half, x - away)
    end = (x + away - frame.origin[d]) * frame.inverse[d] + half + 1e-6
    last = first_vertex(frame, d, half, x + away) + vertices - 1
    return low, min(last, ceil(end) + frame.ghost)


@inner_kernel
def _cell(frame, motion, d):
    """Number of a particle's cell along `d`; 0 along missing directions."""
    if d >= len(frame.cell):
        return 0
    return floor((motion.position[d] - frame.origin[d]) * frame.inverse[d]) + frame.ghost


@inner_kernel
def _number(begin, extent, o):
    """Numbers of vertex `o` of a patch."""
    rest = o // extent[2]
    x, y = begin[0] + rest // extent[1], begin[1] + rest % extent[1]
    return x, y, begin[2] + o % extent[2]


@inner_kernel
def inside(boxes, number):
    """Whether a vertex is in any of some boxes."""
    for n in range(len(boxes)):
        inside = True
        for d in range(3):
            inside = inside and boxes[n, 0, d] <= number[d] <= boxes[n, 1, d]
        if inside:
            return True
    return False


@inner_kernel
def _table_shape(contact_vertices, count):
    """Shape of a table for `count` keys: with a row for each key where that is not much longer."""
    extent, hashed = contact_vertices.extent, table_size(count)
    every = extent[0] * extent[1] * extent[2] * contact_vertices.groups
    return (every, 1) if every <= 2 * hashed else (hashed, 2)


@inner_kernel
def _find(known, key, found):
    """Number of a key in a table of this shape; a new key is inserted with number `found`."""
    if known.shape[1] == 2:
        return find_or_insert(known, key, found)
    if known[key, 0] < 0:
        known[key, 0] = found
    return known[key, 0]


@allocating_kernel
def find_candidates(
    frame, particles, slacks, vertices, within, boxes, rigid_bodies, contact_vertices
) -> Patches:
    """Find the candidate vertices.

    Parameters
    ----------
    particles : (NEAR_PARTICLE, NEAR_MOTION), each (n,)
        Particles and their positions.
    slacks : (float, float)
        Cells by which particles, and rigid bodies, may move along a direction.
    vertices : int
        Vertices of a support along a direction.
    within : (3,) int64
        An axis, and the range of the vertices along it that count.
    boxes : (m, 2, 3) int64
        Least and greatest numbers of the vertices where walls may be.
    rigid_bodies
        RigidBodies or ().
    contact_vertices : ContactVertices
        Without entries; all cells and vertices of the particles have keys there.
    """
    (axis, least, greatest), (slack, rigid_slack) = within, slacks
    table, motion = particles
    patch_of, patches = np.empty(len(table), np.int64), 0
    begin, last = np.empty((len(table), 3), np.int64), np.empty((len(table), 3), np.int64)
    groups = np.empty(len(table), np.int64)
    known = np.full((table_size(len(table)), 2), -1, np.int64)
    for i in range(len(table)):
        at = motion[i]
        cell = (_cell(frame, at, 0), _cell(frame, at, 1), _cell(frame, at, 2))
        p = find_or_insert(known, key_of(contact_vertices, cell, table[i].group), patches)
        patch_of[i] = p
        for d in range(3):
            low, high = reached_range(frame, table[i], at, slack, vertices, d)
            if p == patches:
                begin[p, d], last[p, d] = low, high
            else:
                begin[p, d], last[p, d] = min(begin[p, d], low), max(last[p, d], high)
        if p == patches:
            groups[p] = table[i].group
            patches += 1
    begin, groups = begin[:patches].copy(), groups[:patches]
    extent, most, every = last[:patches] - begin + 1, 1, 0
    for p in range(patches):
        many = extent[p, 0] * extent[p, 1] * extent[p, 2]
        most, every = max(most, many), every + many
    # The group at each vertex, or -1 where there are several.
    known = np.full(_table_shape(contact_vertices, every), -1, np.int64)
    entry, alone = np.full((patches, most), -1, np.int64), np.empty(every, np.int64)
    found = 0
    for p in range(patches):
        for o in range(extent[p, 0] * extent[p, 1] * extent[p, 2]):
            number = _number(begin[p], extent[p], o)
            if not least <= number[axis] <= greatest:
                continue
            n = _find(known, key_of(contact_vertices, number, 0), found)
            entry[p, o] = n
            if n == found:
                beside = inside(boxes, number) or may_fill(rigid_bodies, frame, number, rigid_slack)
                alone[n] = -1 if beside else groups[p]
                found += 1
            elif alone[n] != groups[p]:
                alone[n] = -1
    known = np.full(_table_shape(contact_vertices, every), -1, np.int64)
    some = np.zeros(patches, np.bool_)
    keys, entries = np.empty(every, np.int64), 0
    for p in range(patches):
        for o in range(extent[p, 0] * extent[p, 1] * extent[p, 2]):
            n = entry[p, o]
            if n < 0 or alone[n] >= 0:
                entry[p, o] = -1
                continue
            key = key_of(contact_vertices, _number(begin[p], extent[p], o), groups[p])
            n = _find(known, key, entries)
            if n == entries:
                keys[n] = key
                entries += 1
            entry[p, o], some[p] = n, True
    return Patches(patch_of, begin, extent, entry, some, keys[:entries].copy())


@allocating_kernel
def find_reach(frame, table, motion, slack, vertices, patches, rank, entries) -> Reach:
    """Find the particles within reach of each entry, when they move by up to `slack`.

    Parameters
    ----------
    table, motion
        The particles.
    slack, vertices
        See `find_candidates`.
    patches : Patches
        The particles' patches.
    rank : (m,) int64
        Rank of each entry in the order of their keys; -1 for those that are left out.
    entries : int
        Number of the others.

    Returns
    -------
    Reach
        Of these, in the order of their keys.
    """
    entry, begin, extent = patches.entry, patches.begin, patches.extent
    some, start = patches.some, np.zeros(entries + 1, np.int64)
    kept = np.empty(len(table), np.int64)
    rows = np.empty(len(table), np.int64)
    particle = np.empty(0, np.uint32)
    filled = start
    for fill in (0, 1):  # count, then fill
        count = 0
        for i in range(len(table)):
            p, any_entry = patches.patch[i], False
            if not some[p]:
                continue
            x0, x1 = reached_range(frame, table[i], motion[i], slack, vertices, 0)
            y0, y1 = reached_range(frame, table[i], motion[i], slack, vertices, 1)
            z0, z1 = reached_range(frame, table[i], motion[i], slack, vertices, 2)
            for x in range(x0 - begin[p, 0], x1 - begin[p, 0] + 1):
                for y in range(y0 - begin[p, 1], y1 - begin[p, 1] + 1):
                    for z in range(z0 - begin[p, 2], z1 - begin[p, 2] + 1):
                        e = entry[p, (x * extent[p, 1] + y) * extent[p, 2] + z]
                        if e < 0 or rank[e] < 0:
                            continue
                        any_entry = True
                        if fill == 0:
                            start[rank[e] + 1] += 1
                        else:
                            particle[filled[rank[e]]] = kept[i]
                            filled[rank[e]] += 1
            if any_entry and fill == 0:
                kept[i], rows[count] = count, i
                count += 1
        if fill == 0:
            rows = rows[:count].copy()
            for e in range(entries):
                start[e + 1] += start[e]
            particle, filled = np.empty(start[entries], np.uint32), start.copy()
    return Reach(rows, start, particle)
