"""Bookkeeping of contact in the initial configuration: impulses, heat, losses, areas, reactions.

An impulse is shared by all reference vertices in its row of B. Held vertices do not move: faces
and constraints bear their share, as for all forces there.
"""

from pgimp.jit.kernel import inlined, inner_kernel, kernel
from pgimp.kernels.contact.books import book, book_rigid_bodies, losses_of
from pgimp.kernels.contact.impulses.coupling import velocity_of
from pgimp.kernels.contact.impulses.gauss_seidel import impulse_of, load_pair
from pgimp.kernels.contact.impulses.reference_grid import (
    OF_VELOCITY_BEFORE,
    key_bits,
    offset_of_key,
)
from pgimp.kernels.contact.impulses.rigid_ends import is_free
from pgimp.kernels.data.ledger import (
    CONTACT_AREA,
    LOSS,
    MOMENT,
    PLACED,
    PLACES,
    PRESSED,
    WALL_HEAT,
    WALL_LOSS,
)
from pgimp.kernels.data.record import ACCELERATION, MASS, RECORD, VELOCITY
from pgimp.kernels.data.velocity_fields import field_count
from pgimp.kernels.grid.conditions import Holding, hold
from pgimp.kernels.loads.prescribed import add_moment, place_of


@inner_kernel
def _press_at(contact_pairs, x, y, z, of):
    """Whether the bodies of the pair with the ends `of` press on each other at a vertex."""
    ends = contact_pairs.ends
    low, high = 0, len(ends)
    while low < high:  # vertices ascend
        middle = (low + high) // 2
        i, j, k = ends[middle].vertex[0], ends[middle].vertex[1], ends[middle].vertex[2]
        if i < x or (i == x and (j < y or (j == y and k < z))):
            low = middle + 1
        else:
            high = middle
    while low < len(ends):
        end = ends[low]
        if end.vertex[0] != x or end.vertex[1] != y or end.vertex[2] != z:
            return False
        if end.bodies[0] == of.bodies[0] and end.bodies[1] == of.bodies[1]:
            return contact_pairs.states[low].normal_impulse != 0.0
        low += 1
    return False


@inner_kernel
def _wall_of(end, walls):
    """Number of a pair's wall; below 0 without one."""
    return max(end.bodies[0], end.bodies[1]) - walls.first


@inner_kernel
def _book_areas(contact_pairs, walls, ledger):
    """Book the contact area at vertices without pressure next to vertices with pressure.

    Weighting divides an area between the two planes of vertices next to it. One of them may
    transmit all of the pressure. Patches have areas of their own.
    """
    for k in range(len(contact_pairs.ends)):
        end, row, axis = contact_pairs.ends[k], contact_pairs.states[k], 0
        if row.normal_impulse != 0.0 or _wall_of(end, walls) >= 0 or end.vertex[2] < 0:
            continue
        for d in range(1, 3):
            if abs(row.normal[d]) > abs(row.normal[axis]):
                axis = d
        for way in (-1, 1):
            x = end.vertex[0] + (way if axis == 0 else 0)
            y = end.vertex[1] + (way if axis == 1 else 0)
            z = end.vertex[2] + (way if axis == 2 else 0)
            if _press_at(contact_pairs, x, y, z, end):
                ledger.contact[0, end.law - 1, CONTACT_AREA] += row.area
                break


@inlined
def _load_before(contact, end, rigid, coupling, values):
    """Load the velocities before the step of a pair's ends; of rigid ones that in it.

    Returns half of what the velocity apart along the normal has changed by, times the impulse:
    what losses by the velocity after the step lack of those by the mean one. There is none with a
    free rigid body, see `book_rigid_bodies`.
    """
    row, changed, free = contact.pair_states[0], 0.0, False
    for a in range(2):
        field, sign = contact.fields[a], 2.0 * a - 1.0
        before = (rigid[a, 0], rigid[a, 1], rigid[a, 2])
        if end.rows[a] >= 0:
            before = velocity_of(coupling, end.rows[a], values, OF_VELOCITY_BEFORE)
        free = free or is_free(contact.rigid_bodies, end.rows[a])
        for d in range(3):
            field.velocity_before[d] = before[d]
            changed += sign * row.normal[d] * (field.velocity[d] - before[d])
    return 0.0 if free else 0.5 * row.normal_impulse * changed


@kernel
def book_contacts(contact, free, contact_pairs, coupling, solved, values, walls, ledger):
    """Book the exchanged impulses in the first plane of the grid, on this plane's owner.

    Parameters
    ----------
    values : (m, NUMBERS) float64
        The records of `ReferenceVertices`.
    walls : SeparatingWalls
        Impulses on them and their losses are booked as the faces'.
    """
    _book_areas(contact_pairs, walls, ledger)
    for k in range(len(contact_pairs.ends)):
        end, row = contact_pairs.ends[k], contact_pairs.states[k]
        wall = _wall_of(end, walls)
        load_pair(contact, contact_pairs, k, coupling, solved)
        rest = _load_before(contact, end, contact_pairs.rigid[k], coupling, values)
        if wall >= 0:
            sign = -1.0 if end.bodies[0] < end.bodies[1] else 1.0
            face, fields = walls.planes[wall].face, contact.fields
            for d in range(3):
                ledger.impulse[0, face, d] += sign * impulse_of(row, d)
            u = (fields[0].velocity[0], fields[0].velocity[1], fields[0].velocity[2])
            v = (fields[1].velocity[0], fields[1].velocity[1], fields[1].velocity[2])
            heat, loss = losses_of(row, u, v)
            loss += rest + book_rigid_bodies(
                contact, contact.rigid_bodies, contact_pairs.rigid[k, 2], 0, 1.0, (u, v), ledger, 0
            )
            ledger.wall_energy[0, face, WALL_HEAT] += heat
            ledger.wall_energy[0, face, WALL_LOSS] += loss
            continue
        place = contact_pairs.rigid[k, 2]
        book(contact, free, ((0, 0, 0), place), 0, 1.0, True, ledger, 0)
        ledger.contact[0, end.law - 1, LOSS] += rest
        first = PLACES * (end.law - 1)
        if first < ledger.contact_moments.shape[1]:
            _book_place(row, place, ledger.contact_moments[0, first : first + PLACES])


@inner_kernel
def _book_place(row, x, booked):
    """Book the moment of a pair on its first body, and where it presses."""
    for d in range(3):
        e, f = (d + 1) % 3, (d + 2) % 3
        booked[MOMENT, d] -= x[e] * impulse_of(row, f) - x[f] * impulse_of(row, e)
        booked[PLACED, d] += row.normal_impulse * x[d]
    booked[PRESSED, 0] += row.normal_impulse


@inner_kernel
def _book_faces(holding, number, r, u, b, lost, m):
    """Book the faces' share of `lost` at a vertex of mass m and velocity u; returns the rest.

    Impulses are linear in the mass, so that the faces' other reactions cancel in the books.
    """
    dt = holding.forcing.dt
    v, _ = hold(holding, number, r, u, b, -m)
    pushed = (u[0] + lost[0] / m, u[1] + lost[1] / m, u[2] + lost[2] / m)
    faster = (b[0] + lost[0] / (m * dt), b[1] + lost[1] / (m * dt), b[2] + lost[2] / (m * dt))
    w, _ = hold(holding, number, r, pushed, faster, m)
    return m * (w[0] - v[0]), m * (w[1] - v[1]), m * (w[2] - v[2])


@inlined
def _book_constraints(marked, r, rest, impulse):
    """Book the share of the first constraint that holds a component."""
    if len(marked) == 0:
        return None
    constraints, mask, x = marked[0], marked[1], place_of(marked, r)
    for d in range(3):
        for k in range(len(constraints)):
            if mask[r // RECORD] >> k & 1 and constraints[k].held[d]:
                impulse[k, d] -= rest[d]
                add_moment(constraints[k], x, d, -rest[d], impulse)
                break


@kernel
def book_held(holding, field, changes, ledger):
    """Book the impulses on held components at the reference vertices that a rank owns.

    Parameters
    ----------
    holding : Holding
        Faces and constraints.
    field : Field
        After `change_velocities`: held components move as prescribed.
    changes : Changes
        The keys of vertices of all ranks, and the impulses on held components.
    ledger : Ledger
        Impulses grow by the shares, and work by the shares times the velocities there.
    """
    G, forcing = field.G, holding.forcing
    bits = key_bits(holding.frame, field_count(field.window))
    for n in range(len(changes.keys)):
        lost = (changes.held[n, 0], changes.held[n, 1], changes.held[n, 2])
        if lost[0] == 0.0 and lost[1] == 0.0 and lost[2] == 0.0:
            continue
        r, number = offset_of_key(field, bits, changes.keys[n])
        i = number[0] - field.window.lower[0]
        if r < 0 or i >= field.owned or not G[r + MASS] > forcing.mass_cutoff:
            continue
        u = (G[r + VELOCITY], G[r + VELOCITY + 1], G[r + VELOCITY + 2])
        b = (G[r + ACCELERATION], G[r + ACCELERATION + 1], G[r + ACCELERATION + 2])
        own = Holding(holding.faces, holding.frame, forcing, ledger.impulse[i], holding.rate)
        rest = _book_faces(own, number, r, u, b, lost, G[r + MASS])
        _book_constraints(forcing.marked, r, rest, ledger.constraint_impulse[i])
        for d in range(3):
            ledger.work[i] -= lost[d] * u[d]
