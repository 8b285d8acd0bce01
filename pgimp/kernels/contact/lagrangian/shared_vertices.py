"""Vertices shared by several groups, or near rigid bodies and walls, and the particles there.

Most of the particles near contact have no such vertex. Particles with one first vertex share all
vertices, a patch, whose numbers are found once.
"""

from typing import NamedTuple

import numpy as np

from pgimp.jit.kernel import allocating_kernel, inner_kernel
from pgimp.kernels.contact.lagrangian.hash_table import find_or_insert, table_size
from pgimp.kernels.contact.lagrangian.vertices import key_of
from pgimp.kernels.data.particles import IntArray


class Patches(NamedTuple):
    """Particles with weight on shared vertices, and the numbers of these vertices.

    Attributes
    ----------
    rows : (n,) int64
        The particles' offsets in their table.
    patch : (n,) int64
        The patch of each.
    numbers : (patches, k) int64
        Entries of the groups at the vertices of a patch; -1 where a group shares no vertex.
    keys : (m,) int64
        Their keys, see `pgimp.kernels.contact.lagrangian.vertices.ContactVertices`.
    """

    rows: IntArray
    patch: IntArray
    numbers: IntArray
    keys: IntArray

    @classmethod
    def empty(cls) -> "Patches":
        """No particles."""
        none = np.empty(0, np.int64)
        return cls(none, none, np.empty((0, 1), np.int64), none)


@inner_kernel
def _vertex(begin, local, q):
    """Numbers of vertex `q` of a patch that begins at `begin`."""
    return begin[0] + local[q, 0], begin[1] + local[q, 1], begin[2] + local[q, 2]


@inner_kernel
def _inside(boxes, number):
    """Whether a vertex is in any of some boxes."""
    for n in range(len(boxes)):
        inside = True
        for d in range(3):
            inside = inside and boxes[n, 0, d] <= number[d] <= boxes[n, 1, d]
        if inside:
            return True
    return False


@allocating_kernel
def find_shared(table, local, within, boxes, contact_vertices) -> Patches:
    """Find the particles with shared vertices.

    Parameters
    ----------
    table : (n,) NEAR_PARTICLE
        Particles.
    local : (k, 3) uint32
        See `Supports`.
    within : (3,) int64
        An axis, and the range of the vertices along it that count.
    boxes : (m, 2, 3) int64
        Least and greatest numbers of the vertices where rigid bodies or walls may be.
    contact_vertices : ContactVertices
        Without entries.

    Returns
    -------
    Patches
    """
    many, (axis, least, greatest) = len(local), within
    patch_of, patches = np.empty(len(table), np.int64), 0
    begins, groups = np.empty((len(table), 3), np.int64), np.empty(len(table), np.int64)
    known = np.full((table_size(len(table)), 2), -1, np.int64)
    for i in range(len(table)):
        first, group = table[i].first_vertex, table[i].group
        x, y, z = first[0], first[1], first[2]
        patch_of[i] = find_or_insert(known, key_of(contact_vertices, (x, y, z), group), patches)
        if patch_of[i] == patches:
            begins[patches, 0], begins[patches, 1], begins[patches, 2] = x, y, z
            groups[patches] = group
            patches += 1
    # The groups at each vertex: the first one, or -1 where there are several.
    known = np.full((table_size(many * patches), 2), -1, np.int64)
    vertex, alone = np.full((patches, many), -1, np.int64), np.empty(many * patches, np.int64)
    found = 0
    for k in range(patches):
        for q in range(many):
            number = _vertex(begins[k], local, q)
            if not least <= number[axis] <= greatest:
                continue
            n = find_or_insert(known, key_of(contact_vertices, number, 0), found)
            vertex[k, q] = n
            if n == found:
                alone[n] = -1 if _inside(boxes, number) else groups[k]
                found += 1
            elif alone[n] != groups[k]:
                alone[n] = -1
    known = np.full((table_size(many * patches), 2), -1, np.int64)
    keys, kept, entries = np.empty(many * patches, np.int64), np.zeros(patches, np.bool_), 0
    for k in range(patches):
        for q in range(many):
            n = vertex[k, q]
            if n < 0 or alone[n] >= 0:
                vertex[k, q] = -1
                continue
            key = key_of(contact_vertices, _vertex(begins[k], local, q), groups[k])
            n = find_or_insert(known, key, entries)
            if n == entries:
                keys[n] = key
                entries += 1
            vertex[k, q], kept[k] = n, True
    count = 0
    for i in range(len(table)):
        count += kept[patch_of[i]]
    rows, patch = np.empty(count, np.int64), np.empty(count, np.int64)
    count = 0
    for i in range(len(table)):
        if kept[patch_of[i]]:
            rows[count], patch[count] = i, patch_of[i]
            count += 1
    return Patches(rows, patch, vertex, keys[:entries])
