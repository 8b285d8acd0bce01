"""Rows of B of bodies that are exact to their surface: weights of parts, and slaves' masters.

A cut particle has the weights of its part of a cell, about the part's centroid (see
`pgimp.kernels.transfer.parts`). Vertices that hold next to nothing are slaves
(`pgimp.solver.lagrangian.slaves`): a row has their masters in place of them, with their weights.
So a row keeps its sum and its first moments, and momentum and angular momentum stay exact.
"""

from typing import NamedTuple

from pgimp.jit.kernel import inner_kernel
from pgimp.kernels.contact.lagrangian.reference_numbers import WIDE
from pgimp.kernels.data.particles import FloatArray, IntArray

#: Numbers of a part: the vector to its centroid, and its products of inertia.
PART = 7


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
