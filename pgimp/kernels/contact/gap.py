"""Pairs of velocity fields at a vertex, and the gap between their surfaces.

Bodies that touch with flat surfaces fill the neighbourhood of a vertex between them. Their filled
parts, sum_p S_vp V_p over the volume of a cell, add up to 1, wherever the surfaces lie and however
they are inclined. The missing part gives the gap; the sum of V_p grad S_vp gives its normal.
"""

from math import inf, sqrt

from pgimp.jit.kernel import inner_kernel
from pgimp.kernels.contact.data import clear_pair
from pgimp.physics.contact.base import UNILATERAL

#: Least part of a vertex's neighbourhood that either body must fill: less gives no reliable gap, as
#: strain changes it.
LEAST_FILLED = 0.02

#: Least part that a body must fill to be supported by a rigid one, where the gap is exact. However
#: little is past the surface, it carries the stress of the first particles.
LEAST_HELD = 1e-6

#: Least part where the rigid surface is inclined to the grid by more than the sine `INCLINED`, in
#: proportion below. Cut boxes have spurious corners there. A vertex in the rigid body would have
#: only these in reach, 0.2 cells before contact.
LEAST_INCLINED, INCLINED = 0.08, 0.05

#: Least part of the mass of two fields for each of them.
LEAST_MASS = 1e-5

#: Least length of a normal's sum, relative to the volume of the neighbourhood over the cell size.
#: Deep inside bodies, without a surface, the sum is rounding.
LEAST_NORMAL = 1e-4

#: Least part of a normal's square that is along the walls of a vertex: less counts as none.
LEAST_WITHIN = 0.01


@inner_kernel
def find_pairs(contact, frame, sides, ring_factor, count, rigid, dt):
    """Find the pairs of fields that act on each other at a vertex; returns their number.

    The last `rigid` of `count` fields are rigid bodies. `sides` has the directions in which
    the vertex is on a wall, see `wall_sides`; `ring_factor` is from `ring_volume_factor`.
    """
    fields, ends, states = contact.fields, contact.ends, contact.pair_states
    missing = 1.0
    for a in range(count):
        missing -= fields[a].filled
    found, rate = 0, 1.0 / dt
    for a in range(count - rigid):
        for b in range(a + 1, count):
            first, second = contact.bodies[a], contact.bodies[b]
            one, other = (a, b) if first < second else (b, a)
            entry = contact.pairs.entry[min(first, second), max(first, second)]
            if entry < 0:
                one, other, entry = other, one, -entry
            if entry == 0:
                continue
            row = states[found]
            clear_pair(row)
            if contact.pairs.kind[entry - 1] == UNILATERAL:
                if b < count - rigid:
                    least = min(fields[a].mass, fields[b].mass)
                    if least < LEAST_MASS * (fields[a].mass + fields[b].mass):
                        continue
                    if min(fields[a].filled, fields[b].filled) < LEAST_FILLED:
                        continue
                elif fields[a].filled < LEAST_HELD or fields[b].filled < LEAST_FILLED:
                    continue
                length = _find_normal(frame, fields, one, other, sides, ring_factor, row)
                if length == 0.0:
                    continue
                if b >= count - rigid and fields[a].filled < _least_held(row):
                    continue
                excess = max(fields[one].curvature_gap + fields[other].curvature_gap, 0.0)
                bent = 0.0
                if b >= count - rigid:
                    bent = excess * _volume(frame, sides) * ring_factor / length**2
                gap = length * _gap(fields[one], fields[other], row, missing, bent)
                row.gap_rate = max(gap - excess, 0.0) * rate
                normal, shear, reach = contact.pairs.adhesion[entry - 1]
                if reach > 0.0 and row.gap_rate * dt < reach:
                    row.adhesion, row.shear_adhesion = normal * row.area * dt, shear * row.area * dt
            ends[found].fields[0], ends[found].fields[1], ends[found].law = one, other, entry
            found += 1
    return found


@inner_kernel
def _least_held(row):
    """Least part that a body must fill to be supported by a rigid one with a pair's normal."""
    along = max(abs(row.normal[0]), abs(row.normal[1]), abs(row.normal[2]))
    return LEAST_INCLINED * min(sqrt(max(1.0 - along * along, 0.0)) / INCLINED, 1.0)


@inner_kernel
def _volume(frame, sides):
    """Volume of a cell, without the parts behind walls."""
    volume = 1.0
    for d in range(len(frame.cell)):
        volume *= frame.cell[d] * (1.0 if sides[d] == 0 else 0.5)
    return volume


@inner_kernel
def _gap(a, b, row, missing, bent):
    """Return the gap between two fields, in cells along the normal; set the area of contact.

    Where one body ends sideways, it covers only part of the other: the ratio of their areas. On
    touching it fills the space there that the other leaves free. The neighbourhood is weighted with
    a tent, 1 - s at the surface's distance s, where the smaller part is (1 - s)^2 / 2. A surface
    curved away from the other has an area smaller by `bent` on touching.
    """
    first, second = 0.0, 0.0
    for d in range(3):
        first += a.surface[d] * row.normal[d]
        second -= b.surface[d] * row.normal[d]
    row.area = max(min(first, second), 0.0)
    small, large = (a, b) if first < second else (b, a)
    cover, filled = 1.0, small.filled
    if row.area > 0.0 and large.mass == inf:
        cover = row.area / max(max(first, second) - bent, row.area)
        filled /= cover
    left = min(missing, cover * (1.0 - large.filled) - small.filled)
    if not left > 0.0:
        return 0.0
    part = min(filled, large.filled)
    return left / (cover * sqrt(min(2.0 * part, 1.0)))


@inner_kernel
def _find_normal(frame, fields, a, b, sides, ring_factor, row):
    """Set the normal, from `a` to `b`; returns the cell's length along it, 0 without a surface.

    A cut by a wall is no contact surface: on a wall the normal
    is along the wall, unless bodies lie on each other there. With a rigid body, its exact normal is
    used.
    """
    square, along, side = 0.0, 0.0, ring_factor
    whole, within = 0.0, 0.0
    of_a = 0.0 if fields[b].mass == inf else 1.0
    of_b = 0.0 if fields[a].mass == inf else 1.0
    for d in range(len(frame.cell)):
        n = (of_a * fields[a].surface[d] - of_b * fields[b].surface[d]) ** 2
        whole += n
        within += n if sides[d] == 0 else 0.0
    flat = within > LEAST_WITHIN * whole
    for d in range(len(frame.cell)):
        n = of_a * fields[a].surface[d] - of_b * fields[b].surface[d]
        if flat and sides[d] != 0:
            n = 0.0
        row.normal[d] = n
        square += n * n
        along += (n * frame.inverse[d]) ** 2
        side *= frame.cell[d]
    length, over = sqrt(square), sqrt(along)
    if not over > LEAST_NORMAL * side:
        return 0.0
    for d in range(3):
        row.normal[d] /= length
    return length / over
