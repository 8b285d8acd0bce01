"""Contact vertices: their search, and the law of contact at them."""

from math import inf

from pgimp.jit.kernel import inner_kernel, kernel, specialise
from pgimp.kernels.contact.books import book
from pgimp.kernels.contact.data import SWEEPS
from pgimp.kernels.contact.gap import find_pairs
from pgimp.kernels.contact.law import exchange, find_held
from pgimp.kernels.contact.select import clear_range, include
from pgimp.kernels.data.record import ACCELERATION, FORCE, MASS, MOMENTUM, RECORD, VELOCITY
from pgimp.kernels.data.velocity_fields import field_count, field_size, has_several
from pgimp.kernels.grid.conditions import Holding
from pgimp.kernels.grid.faces import on_walls, wall_sides
from pgimp.kernels.loads.loads import relaxed_part
from pgimp.kernels.rigid.bodies import position_of
from pgimp.kernels.rigid.fill import fill
from pgimp.kernels.transfer.contribution import VOLUME_CORRECTION


@kernel
def find_contact_vertices(field, where, vertex_counts, vertex_ranges):
    """Count the vertices at which several fields have mass, in each of a rank's planes.

    Parameters
    ----------
    field : Field
        After the halo exchange, so that ranks agree in shared planes.
    where : (planes,) bool
        Which of the planes may hold several fields.
    vertex_counts : (planes,) int64
        Set here.
    vertex_ranges : (planes,) VERTEX_RANGE
        Set to their ranges, see `select_near`.
    """
    window, G = field.window, field.G
    size, count = field_size(window), field_count(window)
    vertex_counts[:] = 0
    for i in range(len(vertex_counts)):
        clear_range(vertex_ranges[i])
        if field.active[i] == 0 or count == 1 or not where[i] or not has_several(field, i):
            continue
        r = i * window.stride[0]
        for j in range(window.extent[1]):
            for k in range(window.extent[2]):
                found = 0
                for f in range(count):
                    found += G[r + f * size + MASS] > 0.0
                if found > 1:
                    vertex_counts[i] += 1
                    include(vertex_ranges[i], j, k)
                r += RECORD


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


@specialise(apply_contact)
def _apply_contact(contact, faces, frame, field, forcing, i, ledger, last):
    if not hasattr(contact, "instance_class"):
        return lambda contact, faces, frame, field, forcing, i, ledger, last: None

    def apply_in_plane(contact, faces, frame, field, forcing, i, ledger, last):
        if contact.vertex_counts[i] > 0:
            _apply_in_plane(contact, faces, frame, field, forcing, i, ledger, last)

    return apply_in_plane


@inner_kernel
def _apply_in_plane(contact, faces, frame, field, forcing, i, ledger, last):
    """See `apply_contact`."""
    window, dt = field.window, forcing.dt
    holding = Holding(faces, frame, forcing, contact.scratch_impulse, forcing.loads.relaxation)
    for j in range(window.extent[1]):
        for k in range(window.extent[2]):
            r = i * window.stride[0] + j * window.stride[1] + k * window.stride[2]
            number = (i + window.lower[0], j + window.lower[1], k + window.lower[2])
            count, pairs = contact_at_vertex(contact, holding, field, number, r, last)
            if pairs == 0:
                continue
            for a in range(count):
                offset = contact.offsets[a]
                for d in range(3):
                    change = contact.fields[a].velocity[d] - contact.fields[a].velocity_before[d]
                    if last:
                        field.G[offset + VELOCITY + d] += change
                        field.G[offset + ACCELERATION + d] += change / dt
                    else:
                        field.G[offset + MOMENTUM + d] += contact.fields[a].mass * change
            # Particles get a part of the first pass, by which they relax to the grid.
            part = 1.0 if last else relaxed_part(forcing.loads.relaxation, dt)
            if part > 0.0 and i < field.owned:
                for pair in range(pairs):
                    book(contact, holding, number, pair, part, last, ledger, i)


@inner_kernel
def contact_at_vertex(contact, holding, field, number, r, last):
    """Find the fields after contact at the vertex whose first record has offset `r`.

    Returns the number of fields with particles, and the number of candidate pairs; without any,
    nothing else is set.
    """
    faces, frame, dt = holding.faces, holding.frame, holding.forcing.dt
    count = _find_fields(contact, faces, frame, field, r, number)
    if count == 0:
        return 0, 0
    sides = wall_sides(faces, frame, number)
    rigid = load_rigid_bodies(contact, contact.rigid_bodies, frame, number, sides, count, last)
    if count + rigid < 2:
        return 0, 0
    pairs = find_pairs(contact, frame, sides, count + rigid, rigid, dt)
    if pairs == 0:
        return 0, 0
    for a in range(count):
        offset = contact.offsets[a]
        inverse = 1.0 if last else 1.0 / contact.fields[a].mass
        for d in range(3):
            v = field.G[offset + VELOCITY + d] * inverse
            contact.fields[a].velocity[d] = contact.fields[a].velocity_before[d] = v
    held = find_held(contact, holding, number, count, rigid, last)
    for _ in range(SWEEPS if held or pairs > 1 else 1):
        for pair in range(pairs):
            exchange(contact, holding, number, held, pair, last)
    return count, pairs


@inner_kernel
def _find_fields(contact, faces, frame, field, r, number):
    """Find the fields at the vertex whose first record has offset `r`; returns their number.

    Walls cut off part of its neighbourhood.
    """
    G, V, size = field.G, contact.volumes, field_size(field.window)
    cell = 0.5 ** on_walls(faces, frame, number)
    for d in range(len(frame.cell)):
        cell *= frame.cell[d]
    count = 0
    for f in range(field_count(field.window)):
        offset = r + f * size
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


def load_rigid_bodies(contact, rigid_bodies, frame, number, sides, count, last):
    """Add the rigid bodies near a vertex to the `count` fields there; returns their number.

    The velocity from particles is paired with the rigid velocity at the step's beginning, after
    forces at its end. So the material gets its support's acceleration.
    """


@specialise(load_rigid_bodies)
def _load_rigid_bodies(contact, rigid_bodies, frame, number, sides, count, last):
    if not hasattr(rigid_bodies, "instance_class"):
        return lambda contact, rigid_bodies, frame, number, sides, count, last: 0

    def find(contact, rigid_bodies, frame, number, sides, count, last):
        found, point = count, rigid_bodies.point[0]
        for t in range(len(rigid_bodies.motion)):
            if (rigid_bodies.lattice[t].free >= 0 and not last) or not fill(
                rigid_bodies, t, frame, number, sides
            ):
                continue
            row, motion = contact.fields[found], rigid_bodies.motion[t]
            velocity = motion.velocity_after if last else motion.velocity_before
            contact.offsets[found], contact.bodies[found] = -1, rigid_bodies.bodies + t
            row.mass, row.filled, row.curvature_gap = inf, point.filled, point.curvature_gap
            x = position_of(frame, number)
            arm = (x[0] - motion.centre[0], x[1] - motion.centre[1], x[2] - motion.centre[2])
            for d in range(3):
                e, f = (d + 1) % 3, (d + 2) % 3
                v = velocity[d]
                v += velocity[3 + e] * arm[f] - velocity[3 + f] * arm[e]
                row.surface[d] = point.surface[d]
                row.velocity[d] = row.velocity_before[d] = v
                row.inverse_mass[d] = row.bilateral_inverse_mass[d] = 0.0
            found += 1
        return found - count

    return find
