"""Pairs of bodies in the current configuration at vertices, in scenes that also have surfaces.

They are those of `pgimp.kernels.contact.vertex_list`, but for unilateral walls: these are met where
they are. All pairs of a scene are solved for together, so that each is a pair of rows of B here. A
body's row is its own field at the vertex.
"""

from math import inf

from pgimp.jit.kernel import inlined, inner_kernel, kernel
from pgimp.kernels.contact.data import clear_field
from pgimp.kernels.contact.gap import find_pairs
from pgimp.kernels.contact.impulses.reference_grid import depth, key_bits, key_of_vertex
from pgimp.kernels.contact.select import clear_range, include
from pgimp.kernels.contact.vertex_list import find_fields
from pgimp.kernels.data.record import MASS
from pgimp.kernels.data.used_rows import fields_with, next_bit, used_rows
from pgimp.kernels.data.velocity_fields import field_count, field_size
from pgimp.kernels.grid.faces import face_count, side_of, wall_of, wall_sides
from pgimp.kernels.rigid.bodies import position_of
from pgimp.kernels.rigid.ring_volume import ring_volume_factor


@inner_kernel
def _rows_from(field, i, first, least):
    """Bits of the rows of plane `i` in which one, or two, fields from `first` on may be nonzero."""
    once, twice = 0, 0
    for f in range(first, field_count(field.window)):
        rows = used_rows(field, i, f)
        twice |= once & rows
        once |= rows
    return once if least == 1 else twice


@inner_kernel
def _present_from(field, i, bit, first, out):
    """List the fields from `first` on that may be nonzero in the rows of a bit; how many."""
    count = 0
    for n in range(fields_with(field, i, bit, out)):
        if out[n] >= first:
            out[count] = out[n]
            count += 1
    return count


@inner_kernel
def _on_wall(walls, number):
    """Whether a vertex is on a unilateral wall, or beyond it."""
    for w in range(len(walls.planes)):
        if depth(walls.planes[w], number) >= 0:
            return True
    return False


@kernel
def find_shared_vertices(contact, field, walls, first):
    """Count the vertices that bodies in the current configuration share, or have at a wall.

    Parameters
    ----------
    contact : Contact
        Counts and ranges of the vertices in each plane are set.
    field : Field
        After the halo exchange, so that ranks agree in shared planes.
    walls : SeparatingWalls
        The unilateral ones.
    first : int
        The first field of these bodies: those after it are theirs, too.
    """
    window, G, size = field.window, field.G, field_size(field.window)
    least, present = 2 if len(walls.planes) == 0 else 1, contact.present
    for i in range(len(contact.vertex_counts)):
        contact.vertex_counts[i] = 0
        clear_range(contact.vertex_ranges[i])
        if field.active[i] == 0:
            continue
        left = _rows_from(field, i, first, least)
        while left:
            begin, end, bit, left = next_bit(field, left)
            most = _present_from(field, i, bit, first, present)
            for j in range(begin, end):
                for k in range(window.extent[2]):
                    r = i * window.stride[0] + j * window.stride[1] + k * window.stride[2]
                    found = 0
                    for n in range(most):
                        found += G[r + present[n] * size + MASS] > 0.0
                    number = (i + window.lower[0], j + window.lower[1], k + window.lower[2])
                    if found > 1 or (found == 1 and _on_wall(walls, number)):
                        contact.vertex_counts[i] += 1
                        include(contact.vertex_ranges[i], j, k)


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
def _wall_pair(contact, frame, walls, w, number, sides, dt):
    """Find the pair of the first field and a unilateral wall; 0 if there is none.

    The wall is a rigid body that begins at the wall's plane. Others end the neighbourhood.
    """
    axis, side = walls.planes[w].axis, walls.planes[w].side
    deep, row, area = depth(walls.planes[w], number), contact.fields[1], 1.0
    clear_field(row)
    row.mass, row.filled = inf, 0.5 if deep == 0 else 1.0
    contact.bodies[1] = walls.first + w
    along = tuple(0 if axis == d else sides[d] for d in range(3))
    ring = ring_volume_factor(frame, number, along)
    for d in range(len(frame.cell)):
        area *= (1.0 if d == axis else frame.cell[d]) * (1.0 if along[d] == 0 else 0.5)
    row.surface[axis] = -side * area * ring * (1.0 if deep != 1 else 1e-3)
    return find_pairs(contact, frame, along, ring, 2, 1, dt)


@inner_kernel
def _keep(contact, frame, field, number, count, pairs, found, room):
    """Keep the pairs found at a vertex, as far as there is room; the number of all so far.

    The first `count` fields are of bodies, others are walls.
    """
    (contact_pairs, keys), window, r = room, field.window, 0
    for d in range(3):
        r += (number[d] - window.lower[d]) * window.stride[d]
    for k in range(pairs):
        found += 1
        if found > len(contact_pairs.ends):
            continue
        end, rigid = contact_pairs.ends[found - 1], contact_pairs.rigid[found - 1]
        contact_pairs.states[found - 1] = contact.pair_states[k]
        rigid[:, :] = 0.0
        end.law, place = contact.ends[k].law, position_of(frame, number)
        end.parted = 0.0
        for d in range(3):
            end.vertex[d], rigid[2, d] = number[d], place[d]
        for side in range(2):
            a = contact.ends[k].fields[side]
            end.bodies[side] = contact.bodies[a]
            end.rows[side], keys[found - 1, side] = -1 - contact.bodies[a], -1
            if a < count:
                f = (contact.offsets[a] - r) // field_size(window)
                bits = key_bits(frame, field_count(window))
                end.rows[side] = 2 * (found - 1) + side
                keys[found - 1, side] = key_of_vertex(bits, number, f)
    return found


@kernel
def find_vertex_pairs(contact, frame, faces, field, walls, first, dt, room) -> int:
    """Find the pairs at a rank's own vertices; returns their number.

    Parameters
    ----------
    contact : Contact
        Laws, sums of volumes, and scratch for the fields at a vertex.
    faces : Faces or ()
        All walls at rest, where neighbourhoods end.
    first : int
        See `find_shared_vertices`.
    room : (ContactPairs, (n, 2) int64)
        Filled as far as there is room: the pairs, with twice their number plus the side as a body's
        row, and the keys of the bodies' vertices, -1 of walls.
    """
    window, found = field.window, 0
    least = 2 if len(walls.planes) == 0 else 1
    for i in range(field.owned):
        if field.active[i] == 0 or contact.vertex_counts[i] == 0:
            continue
        left = _rows_from(field, i, first, least)
        while left:
            begin, end, bit, left = next_bit(field, left)
            most = _present_from(field, i, bit, first, contact.present)
            for j in range(begin, end):
                for k in range(window.extent[2]):
                    number = (i + window.lower[0], j + window.lower[1], k + window.lower[2])
                    count = find_fields(contact, faces, frame, field, number, most)
                    if count == 0:
                        continue
                    sides, pairs = wall_sides(faces, frame, number), 0
                    if count > 1:
                        ring = ring_volume_factor(frame, number, sides)
                        pairs = find_pairs(contact, frame, sides, ring, count, 0, dt)
                    found = _keep(contact, frame, field, number, count, pairs, found, room)
                    for w in range(len(walls.planes)):
                        deep, axis = depth(walls.planes[w], number), walls.planes[w].axis
                        if deep < 0 or _past_another(faces, axis, frame, number):
                            continue
                        for a in range(count):
                            find_fields(contact, faces, frame, field, number, most)
                            contact.offsets[0] = contact.offsets[a]
                            contact.bodies[0] = contact.bodies[a]
                            contact.fields[0] = contact.fields[a]
                            if deep == 0:  # the wall fills what others leave out
                                contact.fields[0].filled *= 0.5
                            pairs = _wall_pair(contact, frame, walls, w, number, sides, dt)
                            found = _keep(contact, frame, field, number, 1, pairs, found, room)
    return found
