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
from pgimp.kernels.contact.select import SPREAD
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

#: Columns of `Contact.fields`: mass, part filled, normal, velocity, that before, inverse mass by
#: component, which is 0 where it is held, the curvature's share of the gap, and the inverse mass
#: again, 0 only where it is held bilaterally, at any velocity: by no wall that lets go.
WEIGHT, PART, OUTWARD, NOW, BEFORE, MOBILITY, EXCESS, BILATERAL = 0, 1, 2, 5, 8, 11, 14, 15
FIELDS = 18

#: Columns of `Contact.partners`: normal, velocity that closes the gap within the step, impulses so
#: far along the normal and across it, the latter over that of sticking, area, the impulses of
#: adhesion along the normal and across it, the former over that of holding.
NORMAL, GAP_RATE, PUSH, SLIP, STUCK, AREA, PULL, CLING, DRAWN = 0, 3, 4, 5, 8, 9, 10, 11, 12
PARTNERS = 13


class Contact(NamedTuple):
    """The data of contact for the kernels.

    Attributes
    ----------
    pairs : Pairs
        The law of each pair of bodies.
    volumes : (planes * plane,) float64
        The sums of `VolumeSums`, for the planes where bodies meet.
    met : (planes,) int64
        Number of the vertices at which bodies meet, in each plane.
    spread : (planes, SPREAD) int64
        Between which vertices these are, see `select_near`.
    places, bodies : (fields,) int64
        Scratch: places of the records of the fields at a vertex, and their bodies.
    fields : (fields, FIELDS) float64
        Scratch: their properties.
    ends : (pairs, 3) int64
        Scratch: the two fields of each pair at a vertex, and the entry of its law.
    partners : (pairs, PARTNERS) float64
        Scratch: the properties of the pairs.
    unbooked : (faces, 3) float64
        Scratch for what faces would book.
    tools : Tools or ()
        The rigid bodies, which count as fields without a place in the grid, and with infinite
        mass.
    """

    pairs: Pairs
    volumes: np.ndarray
    met: np.ndarray
    spread: np.ndarray
    places: np.ndarray
    bodies: np.ndarray
    fields: np.ndarray
    ends: np.ndarray
    partners: np.ndarray
    unbooked: np.ndarray
    tools: Any

    @classmethod
    def empty(
        cls, pairs: Pairs, volumes: Any, planes: int, fields: int, faces: int, tools: Any = ()
    ) -> "Contact":
        """Allocate for `planes` planes, where at most `fields` bodies meet at a vertex."""
        most = fields + (len(tools.motion) if tools else 0)
        count = most * (most - 1) // 2
        return cls(
            pairs, volumes, np.zeros(planes, np.int64), np.zeros((planes, SPREAD), np.int64),
            np.zeros(most, np.int64), np.zeros(most, np.int64), np.zeros((most, FIELDS)),
            np.zeros((count, 3), np.int64), np.zeros((count, PARTNERS)), np.zeros((faces, 3)),
            tools,
        )  # fmt: skip


@inner_kernel
def find_pairs(contact, frame, sides, count, rigid, dt):
    """Find the pairs of fields that act on each other at a vertex; returns their number.

    Of `count` fields the last `rigid` are those of rigid bodies. `sides` tells in which directions
    the vertex is on a wall, see `wall_sides`.
    """
    fields, ends, partners = contact.fields, contact.ends, contact.partners
    missing = 1.0
    for a in range(count):
        missing -= fields[a, PART]
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
            row = partners[found]
            row[:] = 0.0
            if contact.pairs.law[entry - 1] == FRICTION:
                if b < count - rigid:
                    least = min(fields[a, WEIGHT], fields[b, WEIGHT])
                    if least < LEAST_MASS * (fields[a, WEIGHT] + fields[b, WEIGHT]):
                        continue
                    if min(fields[a, PART], fields[b, PART]) < LEAST_FILLED:
                        continue
                elif fields[a, PART] < LEAST_HELD or fields[b, PART] < LEAST_FILLED:
                    continue
                if not _find_gap(frame, fields, one, other, sides, row):
                    continue
                if b >= count - rigid and fields[a, PART] < _least_held(row):
                    continue
                excess = max(fields[one, EXCESS] + fields[other, EXCESS], 0.0)
                bent = excess * _volume(frame, sides) / row[GAP_RATE] ** 2
                gap = row[GAP_RATE] * _gap(fields[one], fields[other], row, missing, bent)
                row[GAP_RATE] = max(gap - excess, 0.0) / dt
                normal, shear, reach = contact.pairs.adhesion[entry - 1]
                if row[GAP_RATE] * dt < reach:
                    row[PULL], row[CLING] = normal * row[AREA] * dt, shear * row[AREA] * dt
            ends[found, 0], ends[found, 1], ends[found, 2] = one, other, entry
            found += 1
    return found


@inner_kernel
def _least_held(row):
    """Least part that a body must fill to be held by a rigid one with the normal of a pair."""
    along = max(abs(row[NORMAL]), abs(row[NORMAL + 1]), abs(row[NORMAL + 2]))
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
        first += a[OUTWARD + d] * row[NORMAL + d]
        second -= b[OUTWARD + d] * row[NORMAL + d]
    row[AREA] = max(min(first, second), 0.0)
    small, large = (a, b) if first < second else (b, a)
    cover = 1.0
    if row[AREA] > 0.0 and large[WEIGHT] == inf:
        cover = row[AREA] / max(max(first, second) - bent, row[AREA])
    left = min(missing, cover * (1.0 - large[PART]) - small[PART])
    part = min(small[PART] / cover, large[PART])
    return max(left, 0.0) / (cover * sqrt(min(2.0 * part, 1.0)))


@inner_kernel
def _find_gap(frame, fields, a, b, sides, row):
    """Set normal, from `a` to `b`, and, as `GAP_RATE`, the cell's length along the normal.

    Returns whether there is a surface. Where a wall cuts bodies, that cut is no surface of contact:
    on a wall the normal is along it, unless bodies lie on each other there. The normal of a rigid
    body is known, and is used alone.
    """
    square, along, side = 0.0, 0.0, 1.0
    whole, within = 0.0, 0.0
    of_a = 0.0 if fields[b, WEIGHT] == inf else 1.0
    of_b = 0.0 if fields[a, WEIGHT] == inf else 1.0
    for d in range(len(frame.cell)):
        n = (of_a * fields[a, OUTWARD + d] - of_b * fields[b, OUTWARD + d]) ** 2
        whole += n
        within += n if sides[d] == 0 else 0.0
    flat = within > LEAST_WITHIN * whole
    for d in range(len(frame.cell)):
        n = of_a * fields[a, OUTWARD + d] - of_b * fields[b, OUTWARD + d]
        if flat and sides[d] != 0:
            n = 0.0
        row[NORMAL + d] = n
        square += n * n
        along += (n * frame.inverse[d]) ** 2
        side *= frame.cell[d]
    length = sqrt(square)
    if not sqrt(along) > LEAST_NORMAL * side:
        return False
    for d in range(3):
        row[NORMAL + d] /= length
    row[GAP_RATE] = length / sqrt(along)
    return True
