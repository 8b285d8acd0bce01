"""Contact at the vertices where the velocity fields of several bodies meet.

Bodies that touch, and whose surfaces are flat, fill the neighbourhood of a vertex between them:
the parts that they fill, sum_p S_vp V_p over the volume of a cell, add up to 1, wherever the
surfaces lie and however they are inclined. The missing part gives the gap. Its normal is that
of the surfaces, the sum of V_p grad S_vp.

Two passes: the momenta from the particles are projected before forces act on them, and the
velocities after that. Particles receive the change of the second pass as an acceleration, but not
that of the first, else the part of their velocities that the grid cannot resolve would become a
force. Together they make two tied bodies move as one, to rounding.
"""

from math import inf, sqrt
from typing import Any, NamedTuple

import numpy as np

from pgimp.jit.kernel import inner_kernel
from pgimp.kernels.contact.select import VERTEX_RANGE
from pgimp.physics.contact import FRICTION, Pairs

#: Least part of a vertex's neighbourhood that either body must fill: less gives no reliable gap, as
#: strain changes it.
LEAST_FILLED = 0.02

#: Least part that a body must fill to be held by a rigid one, where the gap is exact: however
#: little is past the surface, it carries the stress of the first particles.
LEAST_HELD = 1e-6

#: The same where the rigid surface is inclined to the grid by more than the sine `INCLINED`, in
#: proportion below. Cut boxes have corners there that the surface does not have, and these are all
#: that a vertex in the rigid body sees of a body a fifth of a cell away.
LEAST_INCLINED, INCLINED = 0.08, 0.05

#: Least part of the mass of two fields that either must have.
LEAST_MASS = 1e-5

#: Least length of a normal's sum, relative to the side of a cell of the neighbourhood's volume:
#: deep inside bodies, without a surface, it is rounding.
LEAST_NORMAL = 1e-4

#: Least part of a normal's square that is along the walls of a vertex: less counts as none.
LEAST_WITHIN = 0.01

#: Sweeps over the pairs of a vertex where one is not enough: where more than two fields meet, or
#: where walls or constraints hold some of them.
SWEEPS = 8

#: A velocity field at a vertex. `filled` is the part of the neighbourhood that its bodies fill,
#: `surface` the sum of V grad S. `inverse_mass`, by component, is 0 where the field is held;
#: `bilateral_inverse_mass` is 0 only where it is held at any velocity: by no wall that lets go.
#: A rigid body has infinite mass.
FIELD_STATE = np.dtype([
    ("mass", "f8"),
    ("filled", "f8"),
    ("surface", "f8", 3),
    ("curvature_gap", "f8"),
    ("velocity", "f8", 3),
    ("velocity_before", "f8", 3),
    ("inverse_mass", "f8", 3),
    ("bilateral_inverse_mass", "f8", 3),
], align=True)  # fmt: skip

#: A pair of fields. `normal` is from the first to the second, `gap_rate` the velocity that closes
#: the gap within the step. Impulses are those so far; `sticking` is the tangential one over that of
#: sticking. `adhesion` and `shear_adhesion` bound the adhesive impulses along the normal and across
#: it; `adhesion_used` is the former over that of holding.
PAIR_STATE = np.dtype([
    ("normal", "f8", 3),
    ("gap_rate", "f8"),
    ("area", "f8"),
    ("normal_impulse", "f8"),
    ("tangential_impulse", "f8", 3),
    ("sticking", "f8"),
    ("adhesion", "f8"),
    ("shear_adhesion", "f8"),
    ("adhesion_used", "f8"),
], align=True)  # fmt: skip

#: The two fields of a pair, and the entry of its law.
PAIR_ENDS = np.dtype([("fields", "i8", 2), ("law", "i8")], align=True)


class Contact(NamedTuple):
    """The data of contact for the kernels.

    Attributes
    ----------
    pairs : Pairs
        The law of each pair of bodies.
    volumes : (planes * plane,) float64
        The sums of `VolumeSums`, for the planes where bodies meet.
    vertex_counts : (planes,) int64
        Number of the vertices at which bodies meet, in each plane.
    vertex_ranges : (planes, SPREAD) int64
        Between which vertices these are, see `select_near`.
    places, bodies : (fields,) int64
        Scratch: places of the records of the fields at a vertex, and their bodies.
    fields : (fields,) FIELD_STATE
        Scratch: their states.
    ends : (pairs,) PAIR_ENDS
        Scratch: the fields of each pair at a vertex, and its law.
    pair_states : (pairs,) PAIR_STATE
        Scratch: the states of the pairs.
    scratch_impulse : (faces, 3) float64
        Scratch for what faces would book.
    rigid_bodies : Tools or ()
        The rigid bodies, which count as fields without a place in the grid, and with infinite
        mass.
    """

    pairs: Pairs
    volumes: np.ndarray
    vertex_counts: np.ndarray
    vertex_ranges: np.ndarray
    places: np.ndarray
    bodies: np.ndarray
    fields: np.ndarray
    ends: np.ndarray
    pair_states: np.ndarray
    scratch_impulse: np.ndarray
    rigid_bodies: Any

    @classmethod
    def empty(
        cls,
        pairs: Pairs,
        volumes: Any,
        planes: int,
        fields: int,
        faces: int,
        rigid_bodies: Any = (),
    ) -> "Contact":
        """Allocate for `planes` planes, where at most `fields` bodies meet at a vertex."""
        most = fields + (len(rigid_bodies.motion) if rigid_bodies else 0)
        count = most * (most - 1) // 2
        return cls(
            pairs, volumes, np.zeros(planes, np.int64), np.zeros((planes, VERTEX_RANGE), np.int64),
            np.zeros(most, np.int64), np.zeros(most, np.int64), np.zeros(most, FIELD_STATE),
            np.zeros(count, PAIR_ENDS), np.zeros(count, PAIR_STATE), np.zeros((faces, 3)),
            rigid_bodies,
        )  # fmt: skip


@inner_kernel
def fields_of(contact, pair):
    """The two fields of a pair."""
    fields = contact.ends[pair].fields
    return fields[0], fields[1]


@inner_kernel
def impulse_of(row, d):
    """Component `d` of the impulse that a pair has exchanged."""
    return row.tangential_impulse[d] + row.normal_impulse * row.normal[d]


@inner_kernel
def clear_field(row):
    """Set the state of a field to zero."""
    row.mass = row.filled = row.curvature_gap = 0.0
    for d in range(3):
        row.surface[d] = row.velocity[d] = row.velocity_before[d] = 0.0
        row.inverse_mass[d] = row.bilateral_inverse_mass[d] = 0.0


@inner_kernel
def clear_pair(row):
    """Set the state of a pair to zero."""
    row.gap_rate = row.area = row.normal_impulse = row.sticking = 0.0
    row.adhesion = row.shear_adhesion = row.adhesion_used = 0.0
    for d in range(3):
        row.normal[d] = row.tangential_impulse[d] = 0.0


@inner_kernel
def find_pairs(contact, frame, sides, count, rigid, dt):
    """Find the pairs of fields that act on each other at a vertex; returns their number.

    Of `count` fields the last `rigid` are those of rigid bodies. `sides` tells in which directions
    the vertex is on a wall, see `wall_sides`.
    """
    fields, ends, states = contact.fields, contact.ends, contact.pair_states
    missing = 1.0
    for a in range(count):
        missing -= fields[a].filled
    found = 0
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
            if contact.pairs.law[entry - 1] == FRICTION:
                if b < count - rigid:
                    least = min(fields[a].mass, fields[b].mass)
                    if least < LEAST_MASS * (fields[a].mass + fields[b].mass):
                        continue
                    if min(fields[a].filled, fields[b].filled) < LEAST_FILLED:
                        continue
                elif fields[a].filled < LEAST_HELD or fields[b].filled < LEAST_FILLED:
                    continue
                if not _find_gap(frame, fields, one, other, sides, row):
                    continue
                if b >= count - rigid and fields[a].filled < _least_held(row):
                    continue
                excess = max(fields[one].curvature_gap + fields[other].curvature_gap, 0.0)
                bent = excess * _volume(frame, sides) / row.gap_rate**2
                gap = row.gap_rate * _gap(fields[one], fields[other], row, missing, bent)
                row.gap_rate = max(gap - excess, 0.0) / dt
                normal, shear, reach = contact.pairs.adhesion[entry - 1]
                if row.gap_rate * dt < reach:
                    row.adhesion, row.shear_adhesion = normal * row.area * dt, shear * row.area * dt
            ends[found].fields[0], ends[found].fields[1], ends[found].law = one, other, entry
            found += 1
    return found


@inner_kernel
def _least_held(row):
    """Least part that a body must fill to be held by a rigid one with the normal of a pair."""
    along = max(abs(row.normal[0]), abs(row.normal[1]), abs(row.normal[2]))
    return LEAST_INCLINED * min(sqrt(max(1.0 - along * along, 0.0)) / INCLINED, 1.0)


@inner_kernel
def _volume(frame, sides):
    """Volume of a cell, less the parts behind walls."""
    volume = 1.0
    for d in range(len(frame.cell)):
        volume *= frame.cell[d] * (1.0 if sides[d] == 0 else 0.5)
    return volume


@inner_kernel
def _gap(a, b, row, missing, bent):
    """Return the gap between two fields, in cells along the normal; set the area of contact.

    Where one body ends sideways, it covers only a part of the other, the ratio of their areas. To
    touch it, it must fill there what the other leaves free. The neighbourhood is weighted with a
    tent, which is 1 - s at the surface's distance s, where the smaller part is (1 - s)^2 / 2. A
    surface that is bent away from the other has an area that is smaller by `bent` where both touch.
    """
    first, second = 0.0, 0.0
    for d in range(3):
        first += a.surface[d] * row.normal[d]
        second -= b.surface[d] * row.normal[d]
    row.area = max(min(first, second), 0.0)
    small, large = (a, b) if first < second else (b, a)
    cover = 1.0
    if row.area > 0.0 and large.mass == inf:
        cover = row.area / max(max(first, second) - bent, row.area)
    left = min(missing, cover * (1.0 - large.filled) - small.filled)
    part = min(small.filled / cover, large.filled)
    return max(left, 0.0) / (cover * sqrt(min(2.0 * part, 1.0)))


@inner_kernel
def _find_gap(frame, fields, a, b, sides, row):
    """Set normal, from `a` to `b`, and, as `gap_rate`, the cell's length along the normal.

    Returns whether there is a surface. Where a wall cuts bodies, that cut is no surface of contact:
    on a wall the normal is along it, unless bodies lie on each other there. The normal of a rigid
    body is known, and is used alone.
    """
    square, along, side = 0.0, 0.0, 1.0
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
    length = sqrt(square)
    if not sqrt(along) > LEAST_NORMAL * side:
        return False
    for d in range(3):
        row.normal[d] /= length
    row.gap_rate = length / sqrt(along)
    return True
