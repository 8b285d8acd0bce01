"""Momentum update (14) of the vertices, boundary conditions, and reactions of the faces."""

from pgimp.jit.kernel import inlined, inner_kernel, is_record, kernel
from pgimp.jit.vectors.simd import lane, load, pack, store, vector, where, with_lane
from pgimp.kernels.contact.vertex import apply_contact
from pgimp.kernels.data.motion import KEPT_VELOCITY, grid_rate, keeps, velocity_before
from pgimp.kernels.data.record import ACCELERATION, FORCE, HELD, MASS, RECORD, VELOCITY
from pgimp.kernels.data.used_rows import next_rows, used_rows
from pgimp.kernels.data.velocity_fields import field_count, field_size
from pgimp.kernels.grid.conditions import Holding, book_losses, hold
from pgimp.kernels.grid.constraint_flags import also_held
from pgimp.kernels.grid.constraints import constrained_velocity
from pgimp.kernels.grid.faces import beyond_any, box_of, face_count, side_of, wall_of
from pgimp.kernels.loads.loads import given
from pgimp.kernels.loads.wall_gap import clear

#: Parts of the update: all; up to the last pass of contact, and the rest; all of further planes.
WHOLE, BEGINNING, REST, FURTHER = 0, 1, 2, 3


@kernel
def update_momentum(frame, field, faces, forcing, ledger, contact, part):
    """Turn the sums of a rank's active planes into velocities and accelerations.

    Parameters
    ----------
    frame, field, forcing
        See `Frame`, `Field`, `Forcing`; constraints are applied after this.
    faces : Faces or ()
        The boundary conditions.
    ledger : Ledger
        `impulse` grows by each face's momentum given to the material. `work` grows by the work of
        gravity and of moving faces, force times displacement. So a constant gravity's work is the
        weight times the displacement of the centre of mass. Kinetic energy differs from it by an
        amount of order dt, also in free fall. `wall_energy` grows by what unilateral faces take.
        `outside_mass` is set to the mass on the vertices beyond each face.
    contact : Contact or ()
        Contact of the velocity fields.
    part : int
        `WHOLE`, or `BEGINNING` and `REST` in two calls. Where fields of several calls have some
        active planes each, all but the first have `FURTHER`.
    """
    G, active, owned, plane = field.G, field.active, field.owned, field.window.stride[0]
    dt, gravity, mass_cutoff, work = forcing.dt, forcing.gravity, forcing.mass_cutoff, ledger.work
    if part != REST and part != FURTHER:
        ledger.outside_mass[:] = 0.0
    heavy = gravity[0] != 0.0 or gravity[1] != 0.0 or gravity[2] != 0.0
    size, row = field_size(field.window), field.window.stride[1]
    for i in range(len(active)):
        if active[i] == 0:
            continue
        if part != REST:
            apply_contact(contact, faces, frame, field, forcing, i, ledger, False)
            for f in range(field_count(field.window)):
                kept = (field.motion, keeps(field.motion, f))
                first, left = i * plane + f * size, used_rows(field, i, f)
                while left:
                    begin, end, left = next_rows(field, left)
                    _accelerate(
                        G, kept, first + begin * row, first + end * row, dt, gravity, mass_cutoff,
                        forcing.clearances,
                    )  # fmt: skip
        if part == BEGINNING:
            continue
        apply_contact(contact, faces, frame, field, forcing, i, ledger, True)
        for n in range(face_count(faces)):
            constrain_plane(faces, n, frame, field, forcing, i, ledger)
        if heavy and i < owned:
            total = vector(0.0)
            for f in range(field_count(field.window)):
                first, left = i * plane + f * size, used_rows(field, i, f)
                while left:
                    begin, end, left = next_rows(field, left)
                    for r in range(first + begin * row, first + end * row, RECORD):
                        v = load(G, r)
                        m = vector(lane(v, 0))  # positive, except beyond mirrors and seams
                        total = total + where(m > 0.0, m * v, vector(0.0))
            power = gravity[0] * lane(total, 1) + gravity[1] * lane(total, 2)
            work[i] += dt * (power + gravity[2] * lane(total, 3))


@inner_kernel
def _accelerate(G, kept, begin, end, dt, gravity, mass_cutoff, clearances):
    """Turn the sums of a field of a plane into velocities and accelerations.

    `kept` is the vertices' motion, and whether they keep it.
    """
    if not is_record(kept[0]):
        pull = pack(0.0, gravity[0], gravity[1], gravity[2])
        for r in range(begin, end, RECORD):  # without a branch: every third vertex may be empty
            p, f = load(G, r), load(G, r + HELD)
            m = lane(p, 0)
            inverse = 1.0 / m if m > 0.0 else 0.0
            part = 1.0 if m > mass_cutoff else 0.0
            a = (part * inverse) * f + part * pull
            v = inverse * p + dt * a
            store(G, r, with_lane(v, 0, m))
            store(G, r + HELD, with_lane(a, 0, lane(f, 0)))
            if m >= 0.0:
                clear(clearances, G, r)
        return
    for r in range(begin, end, RECORD):
        m = G[r + MASS]
        if m > mass_cutoff and _moves_on(kept, G, r, dt, gravity):
            pass
        elif m > mass_cutoff:
            inverse = 1.0 / m
            for d in range(3):
                a = G[r + FORCE + d] * inverse + gravity[d]
                G[r + ACCELERATION + d] = a
                G[r + VELOCITY + d] = velocity_before(*kept, G, r, d, inverse) + dt * a
        else:
            inverse = 1.0 / m if m > 0.0 else 0.0
            for d in range(3):
                G[r + ACCELERATION + d] = 0.0
                G[r + VELOCITY + d] = velocity_before(*kept, G, r, d, inverse)
        if m >= 0.0:
            clear(clearances, G, r)


@inlined
def _moves_on(kept, G, r, dt, gravity):
    """Accelerate the vertex at `r` if it keeps its motion, all components at once."""
    motion, keeps_motion = kept
    if not is_record(motion):
        return False
    if not keeps_motion:
        return False
    m, f = G[r + MASS], load(G, r + FORCE - 1)
    inverse = 1.0 / m
    a = pack(0.0, inverse, inverse, inverse) * f + pack(0.0, gravity[0], gravity[1], gravity[2])
    v = pack(0.0, dt, dt, dt) * a + load(motion.values, r + KEPT_VELOCITY - 1)
    store(G, r + MASS, with_lane(v, 0, m))
    store(G, r + FORCE - 1, with_lane(a, 0, lane(f, 0)))
    return True


@inlined
def constrain_plane(faces, n, frame, field, forcing, i, ledger):
    """Apply the conditions at the vertices of plane `i` on or beyond face `n` but none before it.

    Where faces join, a vertex is treated by all of them at once. The work of each is its force
    times the velocity after the last face, or after a constraint.
    """
    if len(faces) == 0:
        return None
    return _constrain_face(faces, n, frame, field, forcing, i, ledger)


@inner_kernel
def _constrain_face(faces, n, frame, field, forcing, i, ledger):
    """See `constrain_plane`."""
    window, G, owned, dt = field.window, field.G, i < field.owned, forcing.dt
    work = ledger.work
    axis, wall = side_of(faces, n)[0], wall_of(faces, n, frame)
    j0, j1, k0, k1 = box_of(faces, n, frame, window, i)
    for f in range(field_count(window)):
        rate = grid_rate(forcing.loads.relaxation, field.motion, f)
        holding = Holding(faces, frame, forcing, ledger.impulse[i], rate)
        first = i * window.stride[0] + f * field_size(window)
        for j in range(j0, j1):
            for k in range(k0, k1):
                r = first + j * window.stride[1] + k * window.stride[2]
                m = G[r + MASS]
                number = (i + window.lower[0], j + window.lower[1], k + window.lower[2])
                if not m > 0.0 or beyond_any(faces, n, frame, number):
                    continue
                if number[axis] != wall:
                    ledger.outside_mass[i, n] += m
                mass = m if owned else 0.0
                u = (G[r + VELOCITY], G[r + VELOCITY + 1], G[r + VELOCITY + 2])
                b = (G[r + ACCELERATION], G[r + ACCELERATION + 1], G[r + ACCELERATION + 2])
                v, a = hold(holding, number, r, u, b, mass)
                last = constrained_velocity(forcing.marked, r, v)
                held, done = 0.0, 0.0
                for d in range(3):
                    done += given(rate, mass, dt, u[d], b[d], v[d], a[d]) * last[d]
                    if v[d] != u[d] or a[d] != b[d]:
                        held = also_held(held, d)
                work[i] += done - book_losses(
                    holding, number, r, (u, b), last, mass, ledger.wall_energy[i]
                )
                G[r + HELD] = held
                for d in range(3):
                    G[r + VELOCITY + d] = v[d]
                    G[r + ACCELERATION + d] = a[d]
