"""How far bodies in the initial configuration have moved, from the motion of their vertices.

A particle's displacement is a mean of its reference vertices': none moves farther than they do.
"""

from typing import NamedTuple

import numpy as np

from pgimp.jit.kernel import allocating_kernel, inner_kernel, kernel
from pgimp.kernels.contact.lagrangian.hash_table import find_or_insert, table_size
from pgimp.kernels.contact.lagrangian.reference_grid import image_of
from pgimp.kernels.data.motion import DISPLACEMENT
from pgimp.kernels.data.particles import FloatArray, IntArray
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.data.velocity_fields import field_size
from pgimp.kernels.transfer.first_vertex import first_vertex


class Tracked(NamedTuple):
    """Vertices whose displacements are watched."""

    records: IntArray  #: (n,) int64: Offsets of their records.
    before: FloatArray  #: (n, 3) float64: Displacements from which theirs are counted.

    @classmethod
    def empty(cls) -> "Tracked":
        """No vertices."""
        return cls(np.empty(0, np.int64), np.empty((0, 3)))


@inner_kernel
def _first(frame, row, d):
    """First reference vertex of a particle along `d`; 0 along missing directions."""
    if d >= len(frame.cell):
        return 0
    return first_vertex(frame, d, row.half_width[d], row.weight_position[d])


@allocating_kernel
def track(frame, field, table, local, mirrors) -> Tracked:
    """Watch all reference vertices of particles in the initial configuration.

    Parameters
    ----------
    frame
        InitialFrame.
    field : Field
        With the vertices' motion.
    table : (n,) NEAR_PARTICLE
        The particles; those in the current configuration do not count.
    local, mirrors
        See `Supports`, and `number_reference_vertices`.
    """
    window, values = field.window, field.motion.values
    known = np.full((table_size(len(table)), 2), -1, np.int64)
    patches, firsts = 0, np.empty((len(table), 4), np.int64)
    last, size = np.int64(-1), np.int64(len(values))
    for i in range(len(table)):
        if table[i].lagrangian == 0:
            continue
        x, y = _first(frame, table[i], 0), _first(frame, table[i], 1)
        z, f = _first(frame, table[i], 2), table[i].field
        key = (x - window.lower[0]) * window.stride[0] + (y - window.lower[1]) * window.stride[1]
        key += (z - window.lower[2]) * window.stride[2] + f * field_size(window) + size
        if key == last:
            continue
        last = key
        if find_or_insert(known, key, patches) == patches:
            firsts[patches, 0], firsts[patches, 1], firsts[patches, 2] = x, y, z
            firsts[patches, 3] = f
            patches += 1
    known = np.full((table_size(patches * len(local)), 2), -1, np.int64)
    records, found = np.empty(patches * len(local), np.int64), 0
    for p in range(patches):
        for q in range(len(local)):
            number = tuple(firsts[p, d] + local[q, d] for d in range(3))
            x, y, z = image_of(mirrors, number)
            x, y, z = x - window.lower[0], y - window.lower[1], z - window.lower[2]
            if x < 0 or x >= len(field.active) or y < 0 or y >= window.extent[1]:
                continue
            if z < 0 or z >= window.extent[2]:
                continue
            r = x * window.stride[0] + y * window.stride[1] + z * window.stride[2]
            r += firsts[p, 3] * field_size(window)
            if find_or_insert(known, r // RECORD, found) == found:
                records[found] = r
                found += 1
    before = np.empty((found, 3))
    for n in range(found):
        for d in range(3):
            before[n, d] = values[records[n] + DISPLACEMENT + d]
    return Tracked(records[:found].copy(), before)


@kernel
def track_on(field, tracked):
    """Count displacements of watched vertices from where they are now."""
    values = field.motion.values
    for n in range(len(tracked.records)):
        for d in range(3):
            tracked.before[n, d] = values[tracked.records[n] + DISPLACEMENT + d]


@kernel
def greatest_travel(frame, field, tracked):
    """Greatest distance of watched vertices from where they were, in cells along a direction."""
    values, most = field.motion.values, 0.0
    for d in range(len(frame.cell)):
        away = 0.0
        for n in range(len(tracked.records)):
            u = values[tracked.records[n] + DISPLACEMENT + d] - tracked.before[n, d]
            away = max(away, abs(u))
        most = max(most, away * frame.inverse[d])
    return most
