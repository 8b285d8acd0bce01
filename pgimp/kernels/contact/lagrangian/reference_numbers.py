"""Numbers of the reference vertices on which particles have weight."""

from typing import NamedTuple

import numpy as np

from pgimp.jit.kernel import allocating_kernel, inner_kernel
from pgimp.kernels.contact.lagrangian.hash_table import find_or_insert, table_size
from pgimp.kernels.contact.lagrangian.reference_grid import across, image_of, key_of_vertex
from pgimp.kernels.contact.lagrangian.supports import vertex_at, weights_at
from pgimp.kernels.data.particles import IntArray


class Numbers(NamedTuple):
    """Numbers of particles' reference vertices, without those that have no weight.

    Attributes
    ----------
    many : (n,) int64
        How many each particle has.
    vertex : (n, k) int64
        Their numbers.
    local : (n, k) int64
        Their offsets in the particle's support, ascending.
    """

    many: IntArray
    vertex: IntArray
    local: IntArray

    @classmethod
    def empty(cls, count: int, vertices: int) -> "Numbers":
        """Allocate for so many particles, and vertices of a support."""
        vertex, local = np.empty((2, count, vertices), np.int64)
        return cls(np.empty(count, np.int64), vertex, local)


class References(NamedTuple):
    """The reference vertices of particles, in the order in which these have them.

    Attributes
    ----------
    keys : (m,) int64
    particle : (m,) int64
        The first particle of each.
    """

    keys: IntArray
    particle: IntArray

    @classmethod
    def empty(cls) -> "References":
        """No vertices."""
        none = np.empty(0, np.int64)
        return cls(none, none)


@inner_kernel
def _has_weight(supports, i, q):
    """Whether vertex `q` belongs to support `i`."""
    x, y, z = weights_at(supports, i, q)
    return x != 0.0 and y != 0.0 and z != 0.0


@allocating_kernel
def number_reference_vertices(frame, table, supports, mirrors, fields, numbers) -> References:
    """Find and number the reference vertices on which particles have weight.

    Particles with one first vertex share all vertices: their numbers are found once.

    Parameters
    ----------
    table, supports
        The particles, of `fields` velocity fields, and their supports in the initial configuration.
    mirrors : (n,) FACE_PLANE
        The reflecting walls, see `Mirror`; a vertex beyond one has its image's sums.
    numbers : Numbers
        Set here, in the order in which vertices are found.
    """
    ny_nz, patches, many = across(frame), 0, len(supports.local)
    patch_of = np.empty(len(table), np.int64)
    known = np.full((table_size(len(table)), 2), -1, np.int64)
    for i in range(len(table)):
        first = supports.first[i]
        key = key_of_vertex(ny_nz, (first[0], first[1], first[2]), fields, table[i].field)
        patch_of[i] = find_or_insert(known, key, patches)
        patches = max(patches, patch_of[i] + 1)
    number_in = np.full((patches, many), -1, np.int64)
    known = np.full((table_size(patches * many), 2), -1, np.int64)
    keys, particle = np.empty((2, patches * many), np.int64)
    found = 0
    for i in range(len(table)):
        patch, count = patch_of[i], 0
        for q in range(many):
            if not _has_weight(supports, i, q):
                continue
            if number_in[patch, q] < 0:
                number = image_of(mirrors, vertex_at(supports, i, q))
                key = key_of_vertex(ny_nz, number, fields, table[i].field)
                n = find_or_insert(known, key, found)
                if n == found:
                    keys[n], particle[n] = key, i
                    found += 1
                number_in[patch, q] = n
            numbers.vertex[i, count], numbers.local[i, count] = number_in[patch, q], q
            count += 1
        numbers.many[i] = count
    return References(keys[:found].copy(), particle[:found].copy())


@allocating_kernel
def renumber(numbers, order):
    """Number vertices in the order of which `order` has their former numbers."""
    rank = np.empty(len(order), np.int64)
    for n in range(len(order)):
        rank[order[n]] = n
    for i in range(len(numbers.many)):
        for o in range(numbers.many[i]):
            numbers.vertex[i, o] = rank[numbers.vertex[i, o]]
