"""The reference vertices on which particles have weight: their numbers, and sums there.

Of bodies that are exact to their surface a cut particle has the weights of its part of a cell,
about the part's centroid (see `pgimp.kernels.transfer.parts`). Vertices that hold next to nothing
are slaves (`pgimp.solver.lagrangian.slaves`): a row has their masters in place of them, with their
weights. So it keeps its sum and its first moments, and momentum and angular momentum stay exact.
"""

from typing import NamedTuple

import numpy as np

from pgimp.jit.kernel import allocating_kernel, inner_kernel, kernel
from pgimp.jit.vectors.rows import load_row, store_row
from pgimp.jit.vectors.simd import pack, vector, where
from pgimp.kernels.contact.lagrangian.hash_table import find_or_insert, table_size
from pgimp.kernels.contact.lagrangian.reference_grid import image_of, key_bits, key_of_vertex
from pgimp.kernels.contact.lagrangian.supports import vertex_at, weights_at
from pgimp.kernels.data.particles import FloatArray, IntArray

#: Vertices of a box of sums, along each axis.
WIDE = 8

#: Numbers of a part of a cell: the vector to its centroid, and its products of inertia.
PART = 7


class ReferenceSupports(NamedTuple):
    """Initial supports of n particles, from the first to the last vertex with weight.

    The last of three axes is the scene's last direction; axes that it does not have come first.
    """

    #: first, many: (n, 3) int64: The first vertex with weight, and how many there are, by axis.
    first: IntArray
    many: IntArray
    #: w, g: (3 n + 1, 4) float64: Weights and gradients times the cell, a row for each axis; 0
    #: beyond the last vertex. The last row is not set: `add_particle` reads past a row.
    w: FloatArray
    g: FloatArray

    @classmethod
    def empty(cls, count: int) -> "ReferenceSupports":
        """Allocate for so many particles."""
        first, many = np.empty((2, count, 3), np.int64)
        w, g = np.empty((2, 3 * count + 1, 4))
        return cls(first, many, w, g)


class References(NamedTuple):
    """The reference vertices of particles, in the order in which these have them."""

    keys: IntArray  #: (m,) int64.
    particle: IntArray  #: (m,) int64: The first particle of each.

    @classmethod
    def empty(cls) -> "References":
        """No vertices."""
        none = np.empty(0, np.int64)
        return cls(none, none)


@inner_kernel
def by_axis(frame, values):
    """Values by direction, three, in the order of axes of `ReferenceSupports`."""
    D = len(frame.cell)
    if D == 3:
        return values[0], values[1], values[2]
    if D == 2:
        return values[2], values[0], values[1]
    return values[1], values[2], values[0]


@inner_kernel
def by_direction(frame, values):
    """Values by axis of `ReferenceSupports`, three, in the order of directions."""
    D = len(frame.cell)
    if D == 3:
        return values[0], values[1], values[2]
    if D == 2:
        return values[1], values[2], values[0]
    return values[2], values[0], values[1]


@kernel
def find_reference_supports(frame, supports, found):
    """Set the `ReferenceSupports` of particles from their `Supports`."""
    axes = by_axis(frame, (0, 1, 2))
    for i in range(len(found.first)):
        for axis in range(3):
            d = axes[axis]
            begin, end, row = 0, 4, 3 * i + axis
            while begin < 3 and supports.w[i, d, begin] == 0.0:
                begin += 1
            while end > begin + 1 and supports.w[i, d, end - 1] == 0.0:
                end -= 1
            found.first[i, axis] = supports.first[i, d] + begin
            found.many[i, axis] = end - begin
            for k in range(4):
                there = k < end - begin
                found.w[row, k] = supports.w[i, d, begin + k] if there else 0.0
                found.g[row, k] = supports.g[i, d, begin + k] if there else 0.0


@inner_kernel
def _has_weight(supports, i, q):
    """Whether vertex `q` belongs to support `i`."""
    x, y, z = weights_at(supports, i, q)
    return x != 0.0 and y != 0.0 and z != 0.0


@allocating_kernel
def number_reference_vertices(frame, table, supports, mirrors, fields) -> References:
    """Find and number the reference vertices on which particles have weight.

    Particles with one first vertex share all vertices: their numbers are found once.

    Parameters
    ----------
    table, supports
        The particles, of `fields` velocity fields, and their supports in the initial configuration.
    mirrors : (n,) FACE_PLANE
        The reflecting walls, see `Images`; a vertex beyond one has its image's sums.
    """
    bits, patches, many = key_bits(frame, fields), 0, len(supports.local)
    patch_of = np.empty(len(table), np.int64)
    known = np.full((table_size(len(table)), 2), -1, np.int64)
    for i in range(len(table)):
        first = supports.first[i]
        key = key_of_vertex(bits, (first[0], first[1], first[2]), table[i].field)
        patch_of[i] = find_or_insert(known, key, patches)
        patches = max(patches, patch_of[i] + 1)
    number_in = np.full((patches, many), -1, np.int64)
    known = np.full((table_size(patches * many), 2), -1, np.int64)
    keys, particle = np.empty((2, patches * many), np.int64)
    found = 0
    for i in range(len(table)):
        patch = patch_of[i]
        for q in range(many):
            if number_in[patch, q] < 0 and _has_weight(supports, i, q):
                number = image_of(mirrors, vertex_at(supports, i, q))
                key = key_of_vertex(bits, number, table[i].field)
                n = find_or_insert(known, key, found)
                if n == found:
                    keys[n], particle[n] = key, i
                    found += 1
                number_in[patch, q] = n
    return References(keys[:found].copy(), particle[:found].copy())


@kernel
def keep_numbers(keys, hashes):
    """Insert keys and their numbers, in this order, into an empty hash table."""
    for n in range(len(keys)):
        find_or_insert(hashes, keys[n], n)


@inner_kernel
def _moved_on(rows, row, c):
    """A row of four numbers from column `c` of `WIDE` on, 0 to 4, in two vectors; 0 elsewhere."""
    before, zero = pack(0.0, 1.0, 2.0, 3.0) < vector(float(c)), vector(0.0)
    low, high = load_row(rows, row, -c), load_row(rows, row, 4 - c)
    return where(before, zero, low), where(before, high, zero)


@inner_kernel
def add_particle(box, supports, i, low, part, way):
    """Add a particle's share of a row at the vertices of a box, four along the last axis at once.

    A vertex j gets S0_jp + grad S0_jp . way, times `part`. `low` is the first vertex of the box,
    and `way` is the vector from the particle to the row's vertex, both by axis.

    All particles read and write the box in the same vectors: a CPU waits where it reads numbers of
    two recent stores.
    """
    first, many, w, g = supports.first, supports.many, supports.w, supports.g
    x, y, z = 3 * i, 3 * i + 1, 3 * i + 2
    a, b, c = first[i, 0] - low[0], first[i, 1] - low[1], first[i, 2] - low[2]
    weights, slopes, steep = _moved_on(w, z, c), _moved_on(g, z, c), part * way[2]
    weights = part * weights[0], part * weights[1]
    slopes = steep * slopes[0], steep * slopes[1]
    for m in range(many[i, 0]):
        wx, gx = w[x, m], way[0] * g[x, m]
        for n in range(many[i, 1]):
            wy = w[y, n]
            flat, even = wx * wy + gx * wy + wx * way[1] * g[y, n], wx * wy
            row = (a + m) * WIDE + b + n
            for half in range(2):
                sums = load_row(box, row, 4 * half)
                store_row(box, row, 4 * half, sums + flat * weights[half] + even * slopes[half])


class Parts(NamedTuple):
    """Parts of the particles near contact, and slaves among their reference vertices."""

    #: (n, PART) float64: By axis as in `ReferenceSupports`, in cells: the vector from the middle of
    #: a particle's box to its part's centroid. Then means of products of the distances from there:
    #: of the last two axes, the first and the last, the first two, and of all.
    parts: FloatArray
    slave: IntArray  #: (k,) int64: Numbers of reference vertices among the slaves; -1 for others.
    of: IntArray  #: (s, 2^D) int64: Numbers of the slaves' masters among these vertices.
    weights: FloatArray  #: (s, 2^D) float64: Their weights.


@inner_kernel
def add_part(box, supports, i, low, part, way, parts):
    """As `add_particle`, for the part of a cell; `way` is from the middle of its whole box."""
    first, many, w, g = supports.first, supports.many, supports.w, supports.g
    x, y, z = 3 * i, 3 * i + 1, 3 * i + 2
    a, b, c = first[i, 0] - low[0], first[i, 1] - low[1], first[i, 2] - low[2]
    u, v, t = way[0] - parts[i, 0], way[1] - parts[i, 1], way[2] - parts[i, 2]
    yz, xz, xy, every = parts[i, 3], parts[i, 4], parts[i, 5], parts[i, 6]
    for k in range(many[i, 0]):
        nx, gx = w[x, k], g[x, k]
        for m in range(many[i, 1]):
            ny, gy = w[y, m], g[y, m]
            for n in range(many[i, 2]):
                nz, gz = w[z, n], g[z, n]
                dx, dy, dz = ny * nz + gy * gz * yz, nx * nz + gx * gz * xz, nx * ny + gx * gy * xy
                N = nx * dx + ny * gx * gz * xz + nz * gx * gy * xy + gx * gy * gz * every
                N += gx * dx * u + gy * dy * v + gz * dz * t
                box[(a + k) * WIDE + b + m, c + n] += part * N


@inner_kernel
def fold_row(parts, r, used, seen, coupling):
    """Put masters in the place of slaves in row `r`, which ends at `used`; returns its new end.

    `seen` is as in `find_coupling`; the row has room for all masters.
    """
    column, entry, begin, end = coupling.column, coupling.entry, coupling.start[r], used
    for k in range(begin, used):
        s = parts.slave[column[k]]
        if s < 0:
            continue
        for e in range(parts.of.shape[1]):
            j, weight = parts.of[s, e], parts.weights[s, e]
            if weight == 0.0:
                continue
            if seen[0, j] != r:
                seen[0, j], seen[1, j], column[end] = r, end, j
                for d in range(entry.shape[1]):
                    entry[end, d] = 0.0
                end += 1
            for d in range(entry.shape[1]):
                entry[seen[1, j], d] += weight * entry[k, d]
    kept = begin
    for k in range(begin, end):
        if parts.slave[column[k]] < 0:
            column[kept] = column[k]
            for d in range(entry.shape[1]):
                entry[kept, d] = entry[k, d]
            kept += 1
    return kept
