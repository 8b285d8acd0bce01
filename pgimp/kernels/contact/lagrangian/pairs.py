"""Candidate pairs: groups of bodies, rigid bodies and walls that may touch at a vertex.

For bodies in the initial configuration, whose sums at the vertices are in
`pgimp.kernels.contact.lagrangian.vertices`.
"""

from math import inf
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from pgimp.jit.kernel import inlined, inner_kernel, kernel
from pgimp.jit.memory import structure
from pgimp.kernels.contact.data import PAIR_STATE, clear_field
from pgimp.kernels.contact.gap import find_pairs
from pgimp.kernels.contact.lagrangian.reference_grid import depth
from pgimp.kernels.contact.lagrangian.rigid_ends import load_resting
from pgimp.kernels.contact.lagrangian.vertices import number_of
from pgimp.kernels.data.particles import FloatArray
from pgimp.kernels.grid.faces import face_count, on_walls, side_of, wall_of, wall_sides
from pgimp.kernels.rigid.bodies import position_of
from pgimp.kernels.rigid.ring_volume import ring_volume_factor
from pgimp.physics.contact.base import UNILATERAL

#: Ends of a pair: the entry of each in `ContactVertices`, later its row in `Coupling`, or -1 - n
#: for a rigid end. Then the body of each; the entry of the law; the vertex.
ENDS = structure(("rows", "i8", 2), ("bodies", "i8", 2), ("law", "i8"), ("vertex", "i8", 3))

#: Largest distance, in cells along the normal, between a vertex and the body's mass there. Farther
#: vertices would respond to strain, not to the velocity of the surface.
MAX_ARM = 0.9


class ContactPairs(NamedTuple):
    """Candidate pairs at vertices."""

    ends: NDArray  #: (pairs,) ENDS: The bodies, their vertex, and their law.
    states: NDArray  #: (pairs,) PAIR_STATE: As in `Contact`: normal, gap, and accumulated impulses.
    #: (pairs, 3, 3) float64: Velocities of rigid ends, first and second; where the pair is.
    rigid: FloatArray

    @classmethod
    def empty(cls, count: int) -> Self:
        """Allocate for `count` pairs."""
        return cls(np.empty(count, ENDS), np.empty(count, PAIR_STATE), np.empty((count, 3, 3)))

    def chosen(self, which: slice | np.ndarray) -> Self:
        """Return the pairs at some offsets or in a slice."""
        return type(self)(self.ends[which], self.states[which], self.rigid[which])


class SeparatingWalls(NamedTuple):
    """Unilateral walls, which count as rigid bodies."""

    first: int  #: Number of the first one among the bodies.
    planes: NDArray  #: (walls,) FACE_PLANE: The faces.


@inner_kernel
def _load(contact, a, row, cell):
    """Load a group's sums at a vertex as field `a`."""
    fields = contact.fields
    fields[a].mass = row.mass
    fields[a].filled = (row.volume + row.volume_correction) / cell
    fields[a].curvature_gap = row.curvature_gap / row.cut_weight if row.cut_weight > 0.0 else 0.0
    for d in range(3):
        fields[a].surface[d] = row.surface[d]
        fields[a].velocity[d] = fields[a].velocity_before[d] = 0.0
    contact.bodies[a], contact.offsets[a] = int(row.body), 0


@inner_kernel
def _is_far(frame, row, normal):
    """Whether a group's centre of mass is farther than `MAX_ARM` from its vertex.

    `row` has the group's sums there, `normal` the pair's normal.
    """
    way, cell = 0.0, 0.0
    for d in range(len(frame.cell)):
        way += normal.normal[d] * row.mass_offset[d]
        cell += (normal.normal[d] * frame.cell[d]) ** 2
    return way * way > MAX_ARM**2 * cell * row.mass**2


@inner_kernel
def _keep_pairs(contact, frame, sums, number, slots, pairs, found, contact_pairs):
    """Keep the pairs found by `find_pairs` at a vertex, up to the capacity.

    `slots` are the groups' entries in `sums`; fields behind them are rigid. Returns the number of
    pairs so far, `found` before.
    """
    for k in range(pairs):
        far = False
        for side in range(2):
            a = contact.ends[k].fields[side]
            if a < len(slots) and contact.pairs.kind[contact.ends[k].law - 1] == UNILATERAL:
                far = far or _is_far(frame, sums[slots[a]], contact.pair_states[k])
        if far:
            continue
        found += 1
        if found > len(contact_pairs.ends):
            continue
        end, rigid = contact_pairs.ends[found - 1], contact_pairs.rigid[found - 1]
        contact_pairs.states[found - 1] = contact.pair_states[k]
        rigid[:, :] = 0.0
        end.law, place = contact.ends[k].law, position_of(frame, number)
        for d in range(3):
            end.vertex[d], rigid[2, d] = number[d], place[d]
        for side in range(2):
            a = contact.ends[k].fields[side]
            end.bodies[side] = contact.bodies[a]
            end.rows[side] = slots[a] if a < len(slots) else -1 - contact.bodies[a]
            if a >= len(slots):
                for d in range(3):
                    rigid[side, d] = contact.fields[a].velocity[d]
    return found


@inlined
def _past_another(faces, axis, frame, number):
    """Whether a vertex is beyond a wall with another axis than `axis`."""
    if len(faces):
        for n in range(face_count(faces)):
            other, end = side_of(faces, n)
            if other != axis and (number[other] - wall_of(faces, n, frame)) * end > 0:
                return True
        return False
    return False


@inner_kernel
def _wall_pair(contact, frame, faces, walls, w, number, sides, cell):
    """Find the pair of the first group and a unilateral wall; 0 if there is none.

    The wall is a rigid body that begins at the wall's plane. Other walls end the neighbourhood.
    """
    axis, side = walls.planes[w].axis, walls.planes[w].side
    deep = depth(walls.planes[w], number)
    if deep < 0:
        return 0
    if _past_another(faces, axis, frame, number):
        return 0
    row = contact.fields[1]
    clear_field(row)
    row.mass, row.filled = inf, 0.5 if deep == 0 else 1.0
    contact.bodies[1] = walls.first + w
    along = tuple(0 if axis == d else sides[d] for d in range(3))
    ring_factor = ring_volume_factor(frame, number, along)
    area = cell * frame.inverse[axis] * ring_factor
    row.surface[axis] = -side * area * (1.0 if deep != 1 else 1e-3)
    return find_pairs(contact, frame, along, ring_factor, 2, 1, 1.0)


@kernel
def find_contact_pairs(contact, frame, faces, walls, contact_vertices, dt, contact_pairs):
    """Find the candidate pairs at all vertices.

    Parameters
    ----------
    contact : Contact
        Laws, rigid bodies, and scratch for the fields at a vertex.
    faces : Faces or ()
        All walls at rest, where neighbourhoods end.
    walls : SeparatingWalls
        The unilateral ones.
    contact_vertices : ContactVertices
        The groups' sums at the vertices.
    contact_pairs : ContactPairs
        Filled with the pairs.

    Returns
    -------
    int
        Number of pairs; pairs beyond the capacity are not kept.
    """
    keys, order, sums = contact_vertices.keys, contact_vertices.order, contact_vertices.sums
    found, i = 0, 0
    whole = 1.0
    for d in range(len(frame.cell)):
        whole *= frame.cell[d]
    while i < len(order):
        begin, vertex = i, keys[order[i]] // contact_vertices.groups
        while i < len(order) and keys[order[i]] // contact_vertices.groups == vertex:
            i += 1
        slots, number = order[begin:i], number_of(contact_vertices, vertex)
        count, sides = len(slots), wall_sides(faces, frame, number)
        cell = whole * 0.5 ** on_walls(faces, frame, number)
        ring_factor = ring_volume_factor(frame, number, sides)
        for a in range(count):
            _load(contact, a, sums[slots[a]], cell * ring_factor)
        fills = contact_vertices.fills[slots[0]]
        rigid_bodies = load_resting(
            contact, contact.rigid_bodies, frame, number, sides, count, fills
        )
        if count + rigid_bodies > 1:
            every = count + rigid_bodies
            pairs = find_pairs(contact, frame, sides, ring_factor, every, rigid_bodies, dt)
            found = _keep_pairs(contact, frame, sums, number, slots, pairs, found, contact_pairs)
        for w in range(len(walls.planes)):
            for a in range(count):
                on = depth(walls.planes[w], number) == 0
                half = cell * 2.0 if on else cell
                _load(contact, 0, sums[slots[a]], half * ring_factor)
                pairs = _wall_pair(contact, frame, faces, walls, w, number, sides, half)
                if pairs > 0:
                    contact.pair_states[0].gap_rate /= dt
                    found = _keep_pairs(
                        contact, frame, sums, number, slots[a : a + 1], pairs, found, contact_pairs
                    )
    return found
