"""Search for a step's contact vertices, with their fields and pairs: done once for all passes."""

from math import inf

from pgimp.jit.kernel import inlined, inner_kernel, is_record, kernel
from pgimp.kernels.contact.apart import are_apart, stay_apart
from pgimp.kernels.contact.gap import find_pairs
from pgimp.kernels.contact.law import rests_apart
from pgimp.kernels.contact.listed import FIELDS, PAIRS, VERTICES
from pgimp.kernels.contact.rigid_fields import (
    has_rigid_bodies,
    load_rigid_bodies,
    may_be_near,
    set_rigid_velocity,
)
from pgimp.kernels.contact.volumes import VOLUME_CORRECTION
from pgimp.kernels.data.field_marks import fields_marked, has_several, mark_fields
from pgimp.kernels.data.record import FORCE, MASS, MOMENTUM, VELOCITY
from pgimp.kernels.data.used_rows import next_rows, rows_with
from pgimp.kernels.data.velocity_fields import field_size
from pgimp.kernels.grid.faces import beyond_any, face_count, on_walls, wall_sides
from pgimp.kernels.rigid.ring_volume import ring_volume_factor, walled_volume_factor


@kernel
def list_vertices(contact, search, folded):
    """List the vertices of all planes with contact at which some pairs act on each other.

    Those at which no surfaces reach each other in the step are left out.

    Their order is that of the planes' vertices. So sums over them go in it too.

    Parameters
    ----------
    contact : Contact
        With its volumes; `listed` is set.
    search : Search
        The field is as after the fold of mirrors. In the last pass free rigid bodies take part.
    folded : bool
        Whether mirrors may have given vertices further fields.
    """
    listed, field, window = contact.listed, search.field, search.field.window
    found, least = (0, 0, 0), 2 - has_rigid_bodies(contact.rigid_bodies)
    for i in range(len(contact.vertex_counts)):
        listed.start[i] = found[VERTICES]
        if field.active[i] == 0 or contact.vertex_counts[i] == 0:
            continue
        if folded:
            mark_fields(field, i, contact.marks)
        left = rows_with(field, i, least)
        while left:
            begin, end, left = next_rows(field, left)
            for j in range(begin, end):
                for k in range(window.extent[2]):
                    mark = contact.marks[i, j, k]
                    near = may_be_near(contact.near, contact.rigid_bodies, i, j, k, folded)
                    if mark == 0 or not (near or has_several(mark)):
                        continue
                    number = (i + window.lower[0], j + window.lower[1], k + window.lower[2])
                    most = fields_marked(window, mark, contact.present)
                    found = _add(contact, search, number, most, near, found)
    listed.start[len(contact.vertex_counts)] = found[VERTICES]
    listed.found[VERTICES], listed.found[FIELDS], listed.found[PAIRS] = found


@inner_kernel
def _add(contact, search, number, most, near, found):
    """List a vertex, if any pairs act there.

    `most` fields may have mass there, see `Contact.present`. Rigid bodies may be `near`.
    """
    faces, frame, last = search.faces, search.frame, search.last
    count = find_fields(contact, faces, frame, search.field, number, most)
    if count == 0 or (count == 1 and not near):
        return found
    sides = wall_sides(faces, frame, number)
    rigid = 0
    if near:
        rigid = load_rigid_bodies(contact, contact.rigid_bodies, frame, number, sides, count, last)
    if count + rigid < 2 or (rigid == 0 and are_apart(contact, search, number, count)):
        return found
    ring_factor = ring_volume_factor(frame, number, sides)
    pairs = find_pairs(contact, frame, sides, ring_factor, count + rigid, rigid, search.dt)
    if pairs == 0 or stay_apart(contact, search, number, count, rigid, pairs):
        return found
    listed, (v, f, p) = contact.listed, found
    after = (v + 1, f + count + rigid, p + pairs)
    if (
        after[VERTICES] > len(listed.vertices)
        or after[FIELDS] > len(listed.fields)
        or after[PAIRS] > len(listed.pairs)
    ):
        return after
    row = listed.vertices[v]
    for d in range(3):
        row.number[d] = number[d]
    row.fields, row.rigid, row.first_field = count, rigid, f
    row.pairs, row.first_pair = pairs, p
    for a in range(count + rigid):
        listed.fields[f + a].offset = contact.offsets[a]
        listed.fields[f + a].body = contact.bodies[a]
    simple = rigid == 0 and not beyond_any(faces, face_count(faces), frame, number)
    for pair in range(pairs):
        kept, state, ends = listed.pairs[p + pair], contact.pair_states[pair], contact.ends[pair]
        kept.fields[0], kept.fields[1], kept.law = ends.fields[0], ends.fields[1], ends.law
        for end in range(2):
            kept.offsets[end] = contact.offsets[ends.fields[end]]
        simple = simple and rests_apart(contact.pairs, ends.law - 1, state)
        kept.gap_rate, kept.area = state.gap_rate, state.area
        kept.adhesion, kept.shear_adhesion = state.adhesion, state.shear_adhesion
        for d in range(3):
            kept.normal[d] = state.normal[d]
    row.simple = simple
    return after


@inner_kernel
def find_fields(contact, faces, frame, field, number, most):
    """Find the fields at a vertex; returns their number.

    Walls cut off part of its neighbourhood.
    """
    G, V, window, r = field.G, contact.volumes, field.window, 0
    size = field_size(window)
    for d in range(3):
        r += (number[d] - window.lower[d]) * window.stride[d]
    cell = 0.5 ** on_walls(faces, frame, number)
    cell *= walled_volume_factor(faces, frame, number)
    for d in range(len(frame.cell)):
        cell *= frame.cell[d]
    count = 0
    for n in range(most):
        offset = r + contact.present[n] * size
        if not (G[offset + MASS] > 0.0 and V[offset + MASS] > 0.0):
            continue
        contact.offsets[count] = offset
        contact.bodies[count] = int(V[offset + MOMENTUM] / V[offset + MASS] + 0.5) - 1
        contact.fields[count].mass = G[offset + MASS]
        contact.fields[count].filled = (V[offset + MASS] + V[offset + VOLUME_CORRECTION]) / cell
        cut = V[offset + MOMENTUM + 2]
        contact.fields[count].curvature_gap = V[offset + MOMENTUM + 1] / cut if cut > 0.0 else 0.0
        for d in range(3):
            contact.fields[count].surface[d] = V[offset + FORCE + d]
        count += 1
    return count


@inner_kernel
def vertex_number(contact, n):
    """The numbers of listed vertex `n`."""
    number = contact.listed.vertices[n].number
    return number[0], number[1], number[2]


@inner_kernel
def load_vertex(contact, frame, field, n, last):
    """Load the fields and pairs of listed vertex `n`, before any impulse in this pass.

    Returns the numbers of its fields with particles, its rigid bodies and its pairs.
    """
    row, listed = contact.listed.vertices[n], contact.listed
    for a in range(row.fields):
        entry, state = listed.fields[row.first_field + a], contact.fields[a]
        contact.offsets[a], contact.bodies[a] = entry.offset, entry.body
        state.mass = field.G[entry.offset + MASS]
        inverse = 1.0 if last else 1.0 / state.mass
        for d in range(3):
            state.velocity[d] = state.velocity_before[d] = (
                field.G[entry.offset + VELOCITY + d] * inverse
            )
    for a in range(row.fields, row.fields + row.rigid):
        contact.offsets[a], contact.bodies[a] = -1, listed.fields[row.first_field + a].body
        contact.fields[a].mass = inf
        _set_velocity(contact, contact.rigid_bodies, a, frame, vertex_number(contact, n), last)
    for pair in range(row.pairs):
        kept, state, ends = (
            listed.pairs[row.first_pair + pair],
            contact.pair_states[pair],
            contact.ends[pair],
        )
        ends.fields[0], ends.fields[1], ends.law = kept.fields[0], kept.fields[1], kept.law
        state.gap_rate, state.area = kept.gap_rate, kept.area
        state.adhesion, state.shear_adhesion = kept.adhesion, kept.shear_adhesion
        state.normal_impulse = state.sticking = state.adhesion_used = 0.0
        for d in range(3):
            state.normal[d], state.tangential_impulse[d] = kept.normal[d], 0.0
    return row.fields, row.rigid, row.pairs


@inlined
def _set_velocity(contact, rigid_bodies, a, frame, number, last):
    """Set the velocity of field `a`, a rigid body, at a vertex."""
    if not is_record(rigid_bodies):
        return None
    t = contact.bodies[a] - rigid_bodies.bodies
    set_rigid_velocity(contact.fields[a], rigid_bodies, t, frame, number, last)
