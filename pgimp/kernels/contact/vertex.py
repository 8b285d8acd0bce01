"""Contact vertices: their search, and the law of contact at them."""

from math import sqrt

from pgimp.jit.kernel import inlined, inner_kernel, is_record, kernel
from pgimp.kernels.contact.books import book
from pgimp.kernels.contact.data import SWEEPS, fields_of, impulse_of
from pgimp.kernels.contact.law import exchange, find_held
from pgimp.kernels.contact.select import clear_range, include
from pgimp.kernels.contact.sliding import sliding_part
from pgimp.kernels.contact.vertex_list import load_vertex, vertex_number
from pgimp.kernels.data.field_marks import has_several, mark_fields
from pgimp.kernels.data.ledger import (
    CONTACT_AREA,
    HEAT,
    IMPULSE,
    LOSS,
    NORMAL_IMPULSE,
    TANGENTIAL_IMPULSE,
)
from pgimp.kernels.data.record import ACCELERATION, MASS, MOMENTUM, VELOCITY
from pgimp.kernels.data.used_rows import next_rows, rows_with
from pgimp.kernels.grid.conditions import Holding
from pgimp.kernels.grid.constraints import is_marked
from pgimp.kernels.loads.loads import relaxed_part
from pgimp.kernels.rigid.bodies import move_freely, position_of


@kernel
def find_contact_vertices(field, where, marks, vertex_counts, vertex_ranges):
    """Count the vertices at which several fields have mass, in each of a rank's planes.

    Parameters
    ----------
    field : Field
        After the halo exchange, so that ranks agree in shared planes.
    where : (planes,) bool
        Which of the planes to look at; others hold no several fields.
    marks : (planes, y, z) int64
        Set in their rows with fields, see `mark_fields`.
    vertex_counts : (planes,) int64
        Set here.
    vertex_ranges : (planes,) VERTEX_RANGE
        Set to their ranges, see `select_near`.
    """
    vertex_counts[:] = 0
    for i in range(len(vertex_counts)):
        clear_range(vertex_ranges[i])
        if field.active[i] == 0 or not where[i]:
            continue
        mark_fields(field, i, marks)
        left = rows_with(field, i, 2)
        while left:
            begin, end, left = next_rows(field, left)
            for j in range(begin, end):
                for k in range(marks.shape[2]):
                    if has_several(marks[i, j, k]):
                        vertex_counts[i] += 1
                        include(vertex_ranges[i], j, k)


@inlined
def apply_contact(contact, faces, frame, field, forcing, i, ledger, last):
    """Apply contact at the vertices of plane `i`.

    Parameters
    ----------
    contact : Contact or ()
        () in scenes without contact.
    faces, frame, field, forcing, ledger
        As in `update_momentum`; `contact` of the ledger grows by the last pass.
    last : bool
        Whether the grid holds velocities and accelerations; else it holds momenta.
    """
    if not is_record(contact):
        return None
    if contact.listed.start[i] < contact.listed.start[i + 1]:
        _apply_in_plane(contact, faces, frame, field, forcing, i, ledger, last)


@inner_kernel
def _apply_in_plane(contact, faces, frame, field, forcing, i, ledger, last):
    """See `apply_contact`."""
    dt, listed = forcing.dt, contact.listed
    holding = Holding(faces, frame, forcing, contact.scratch_impulse, forcing.loads.relaxation)
    # Particles get a part of the first pass, by which they relax to the grid.
    part = 1.0 if last else relaxed_part(forcing.loads.relaxation, dt)
    for n in range(listed.start[i], listed.start[i + 1]):
        if _exchange_alone(contact, forcing, field, i, n, part, last, ledger):
            continue
        count, pairs, changed = contact_at_vertex(contact, holding, field, n, last)
        if not changed:
            continue
        for a in range(count):
            offset = contact.offsets[a]
            for d in range(3):
                change = contact.fields[a].velocity[d] - contact.fields[a].velocity_before[d]
                if last:
                    field.G[offset + VELOCITY + d] += change
                    field.G[offset + ACCELERATION + d] += change / dt
                    _set_before(contact, contact.rigid_bodies, a, d, field.G, dt)
                else:
                    field.G[offset + MOMENTUM + d] += contact.fields[a].mass * change
        if part > 0.0 and i < field.owned:
            number = vertex_number(contact, n)
            place = position_of(frame, number)
            for pair in range(pairs):
                book(contact, holding, (number, place), pair, part, last, ledger, i)


@inner_kernel
def _exchange_alone(contact, forcing, field, plane, n, part, last, ledger):
    """Apply the law at listed vertex `n` of `plane` if that is simple; returns whether it is.

    It is where no surfaces reach each other in the step. Else it is for one pair of bodies, held
    neither by walls nor by constraints. The impulse is that of `pgimp.kernels.contact.law`, and
    `part` of it is booked.
    """
    listed, G = contact.listed, field.G
    vertex = listed.vertices[n]
    if vertex.simple == 0:
        return False
    for pair in range(vertex.first_pair, vertex.first_pair + vertex.pairs):
        row = listed.pairs[pair]
        r, s, N = row.offsets[0], row.offsets[1], row.normal
        if is_marked(forcing.marked, r) or is_marked(forcing.marked, s):
            return False
        by_r, by_s = 1.0 / G[r + MASS], 1.0 / G[s + MASS]
        u, v = (1.0, 1.0) if last else (by_r, by_s)
        w = tuple(v * G[s + VELOCITY + d] - u * G[r + VELOCITY + d] for d in range(3))
        normal = w[0] * N[0] + w[1] * N[1] + w[2] * N[2]
        if normal + row.gap_rate >= 0.0:
            continue
        if vertex.pairs > 1:
            return False
        mobility, answer = by_r + by_s, 1.0 / (by_r + by_s)
        push = -(normal + row.gap_rate) / (N[0] ** 2 + N[1] ** 2 + N[2] ** 2) * answer
        stick = tuple((normal * N[d] - w[d]) * answer for d in range(3))
        length = sqrt(stick[0] ** 2 + stick[1] ** 2 + stick[2] ** 2)
        stress, slip = row.area * forcing.dt, length * mobility
        slides = sliding_part(contact.pairs, row.law - 1, 0.0, push, stress, length, slip)
        J = tuple(push * N[d] + slides * stick[d] for d in range(3))
        _give(G, r, s, J, by_r, by_s, forcing.dt, last)
        if part > 0.0 and plane < field.owned:
            booked, heat, after = ledger.contact[plane, row.law - 1], 0.0, 0.0
            for d in range(3):
                left = w[d] + mobility * J[d]
                heat -= slides * stick[d] * left
                after += left * N[d]
                booked[IMPULSE + d] -= part * J[d]
            booked[NORMAL_IMPULSE] += part * push
            booked[TANGENTIAL_IMPULSE] += part * slides * length
            booked[HEAT] += part * heat
            booked[LOSS] -= part * push * after
            if last:
                booked[CONTACT_AREA] += row.area
    return True


@inner_kernel
def _give(G, r, s, J, by_r, by_s, dt, last):
    """Give the impulse J to the record at `s`, and take it from the record at `r`."""
    rate = 1.0 / dt
    for d in range(3):
        if last:
            a, b = J[d] * by_r, J[d] * by_s
            G[r + VELOCITY + d] -= a
            G[r + ACCELERATION + d] -= a * rate
            G[s + VELOCITY + d] += b
            G[s + ACCELERATION + d] += b * rate
        else:
            G[r + MOMENTUM + d] -= J[d]
            G[s + MOMENTUM + d] += J[d]


@inlined
def _set_before(contact, rigid_bodies, a, d, G, dt):
    """Set component `d` of a field's velocity before the step, for the books of free bodies."""
    if move_freely(rigid_bodies):
        field, b = contact.fields[a], G[contact.offsets[a] + ACCELERATION + d]
        field.velocity_before[d] = field.velocity[d] - dt * b
    return None


@inner_kernel
def contact_at_vertex(contact, holding, field, n, last):
    """Find the fields after contact at listed vertex `n`.

    Returns the number of fields with particles, the number of pairs, and whether there are any
    impulses.
    """
    count, rigid, pairs = load_vertex(contact, holding.frame, field, n, last)
    number = vertex_number(contact, n)
    held = find_held(contact, holding, number, count, rigid, last)
    some = False
    for _ in range(SWEEPS if held or pairs > 1 else 1):
        changed = False
        for pair in range(pairs):
            changed = exchange(contact, holding, number, held, pair, last) or changed
        if not changed:
            break
        some = True
    return count, pairs, some


@kernel
def contact_forces(contact, faces, frame, field, forcing, last, out):
    """Add to `out` the contact force at each vertex on the lower-numbered body of each pair.

    Parameters
    ----------
    contact, faces, frame, field, forcing
        As in `update_momentum`, before its beginning or after it.
    last : bool
        Whether to add the force of the last pass, after the beginning; else the part of the
        first pass that particles receive.
    out : (vertices, 3) float64
        Forces in the rank's own planes.
    """
    window = field.window
    holding = Holding(faces, frame, forcing, contact.scratch_impulse, forcing.loads.relaxation)
    part = 1.0 if last else relaxed_part(forcing.loads.relaxation, forcing.dt)
    listed, lower = contact.listed, window.lower
    for n in range(listed.start[field.owned]):
        number = vertex_number(contact, n)
        _, pairs, _ = contact_at_vertex(contact, holding, field, n, last)
        vertex = (number[0] - lower[0]) * window.extent[1] + number[1] - lower[1]
        vertex = vertex * window.extent[2] + number[2] - lower[2]
        for pair in range(pairs):
            a, b = fields_of(contact, pair)
            sign = -1.0 if contact.bodies[a] < contact.bodies[b] else 1.0
            row = contact.pair_states[pair]
            for d in range(3):
                out[vertex, d] += part * sign * impulse_of(row, d) / forcing.dt
