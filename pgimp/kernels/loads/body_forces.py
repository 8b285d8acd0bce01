"""Forces per mass on particles: of exact solutions, of the case, of water in the ground."""

from pgimp.jit.kernel import class_of, inlined, inner_kernel, is_record
from pgimp.jit.tuples import read, three
from pgimp.jit.vectors.lanes import of_lane
from pgimp.jit.vectors.simd import number, pack, store
from pgimp.kernels.loads.wall_gap import divergence
from pgimp.physics.exact.base import BodyForce, body_force
from pgimp.physics.functions.call import call
from pgimp.physics.loads.bodyforce import acceleration

#: Numbers of a buffer with the forces on four particles.
FORCES = 16


@inner_kernel
def submerged(level, up, half, x):
    """Part of a particle's height that is below the level of the water."""
    return min(max(0.5 + 0.5 * (level - up * x) / half, 0.0), 1.0)


@inner_kernel
def buoyancy(water, particles, p):
    """Force of the water per mass of particle `p` as three numbers; `water` is a `Buoyancy`."""
    body = particles.body[p]
    volume = water.inverse[body]
    if water.column[body] >= 0:
        volume = 1.0 / particles.own[p, water.column[body]]
    a = volume * water.lift
    a *= submerged(water.level, water.up, water.half, particles.x[p, water.axis])
    return tuple(a if water.axis == d else 0.0 for d in range(3))


@inlined
def _force(force, frame, particles, p):
    """Body force per mass of particle `p` as three numbers, (17)."""
    source, t = force.source, force.time
    kind = class_of(source)
    if hasattr(kind, "lift"):
        a = buoyancy(source, particles, p)
        if not is_record(source.other):
            return a
        b = _force(BodyForce(source.other, t), frame, particles, p)
        return b[0] + a[0], b[1] + a[1], b[2] + a[2]
    x, v = read(particles.x, p, 0, frame.origin), read(particles.v, p, 0, frame.origin)
    if hasattr(kind, "acceleration"):
        return acceleration(source, three(x), three(v), t)
    if hasattr(kind, "taken") and all(number > 0 for number in kind.taken):
        return three(call(source, (x, x, v, t)))
    X = read(particles.origin, p, 0, frame.origin)
    if hasattr(kind, "taken"):
        return three(call(source, (X, x, v, t)))
    return three(body_force(source, X, t))


@inlined
def weight(force, walls, frame, particles, p):
    """Vector (0, m_p b_p), which (17) adds to the force on the support's vertices, or ().

    With walls its first component is for `pgimp.kernels.loads.wall_gap`.
    """
    forced, near = is_record(force), len(walls) > 0
    if not forced and not near:
        return ()
    if not forced:
        return pack(particles.m[p] * divergence(walls, particles, p, 0), 0.0, 0.0, 0.0)
    m, b = particles.m[p], _force(force, frame, particles, p)
    if near:
        return pack(m * divergence(walls, particles, p, 0), m * b[0], m * b[1], m * b[2])
    return pack(0.0, m * b[0], m * b[1], m * b[2])


@inlined
def add_force_power(force, frame, particles, four, u, forces, power):
    """Power so far plus the power of the body force on four particles, which moves at `u`.

    `forces`, a buffer on the stack of `FORCES` numbers, is for `book_shifts`.
    """
    if not is_record(force):
        return power
    for j in range(four.size):
        p, w = four.rows[j], of_lane(u, j)
        b, m = _force(force, frame, particles, p), particles.m[p]
        rate = 0.0
        for d in range(len(w)):
            rate += b[d] * w[d]
        power += m * rate
        store(forces, 4 * j, pack(m * b[0], m * b[1], m * b[2], 0.0))
    return power


@inlined
def book_shifts(force, forces, particles, four, x, ledger):
    """Book the work of the body force where particles are not at `x`, to which the grid moved them.

    Walls and rigid bodies hold them, and flows shift them to free space. As of gravity, the work is
    then the force times the whole way.
    """
    if not is_record(force):
        return None
    work = 0.0
    for j in range(four.size):
        p, at = four.rows[j], of_lane(x, j)
        for d in range(len(at)):
            work += number(forces, 4 * j + d) * (particles.x[p, d] - at[d])
    ledger.work[four.layer] += work
