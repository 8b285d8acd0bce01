"""Forces per mass on particles: of exact solutions, of the case, of water in the ground."""

from pgimp.jit.kernel import inlined, inner_kernel, is_record, specialise
from pgimp.jit.tuples import read
from pgimp.jit.vectors.lanes import of_lane
from pgimp.jit.vectors.simd import number, pack, store
from pgimp.kernels.grid.wall_gap import divergence
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
    return (
        a if water.axis == 0 else 0.0,
        a if water.axis == 1 else 0.0,
        a if water.axis == 2 else 0.0,
    )


def _three(V):
    """A vector of the scene as three numbers, zero in missing directions."""


@specialise(_three)
def _three_of(V):
    return (lambda V: (V[0], 0.0, 0.0), lambda V: (V[0], V[1], 0.0), lambda V: V)[len(V) - 1]


def _force(force, frame, particles, p):
    """Body force per mass of particle `p` as three numbers, (17)."""


def _own_force(kind):
    """`_force` by a function of one's own, which may take the initial position."""

    def force_by_place(force, frame, particles, p):
        x, v = read(particles.x, p, 0, frame.origin), read(particles.v, p, 0, frame.origin)
        return _three(call(force.source, (x, x, v, force.time)))

    def force_by_origin(force, frame, particles, p):
        X = read(particles.origin, p, 0, frame.origin)
        x, v = read(particles.x, p, 0, frame.origin), read(particles.v, p, 0, frame.origin)
        return _three(call(force.source, (X, x, v, force.time)))

    return force_by_origin if 0 in kind.taken else force_by_place


def _with_water(kind):
    """`_force` with water in the ground."""

    def water_alone(force, frame, particles, p):
        return buoyancy(force.source, particles, p)

    def water_besides(force, frame, particles, p):
        b = _force(BodyForce(force.source.other, force.time), frame, particles, p)
        a = buoyancy(force.source, particles, p)
        return b[0] + a[0], b[1] + a[1], b[2] + a[2]

    other = kind.types[kind.instance_class._fields.index("other")]
    return water_besides if hasattr(other, "instance_class") else water_alone


@specialise(_force)
def _force_of(force, frame, particles, p):
    D, source = len(frame.types[0]), force.types[0].instance_class
    if "lift" in getattr(source, "_fields", ()):
        return _with_water(force.types[0])
    if hasattr(source, "taken"):
        return _own_force(source)
    if hasattr(source, "acceleration"):

        def force_here(force, frame, particles, p):
            x = _three(read(particles.x, p, 0, frame.origin))
            v = _three(read(particles.v, p, 0, frame.origin))
            return acceleration(force.source, x, v, force.time)

        return force_here

    def force1(force, frame, particles, p):
        X = read(particles.origin, p, 0, frame.origin)
        return body_force(force.source, X, force.time)[0], 0.0, 0.0

    def force2(force, frame, particles, p):
        X = read(particles.origin, p, 0, frame.origin)
        b = body_force(force.source, X, force.time)
        return b[0], b[1], 0.0

    def force3(force, frame, particles, p):
        X = read(particles.origin, p, 0, frame.origin)
        return body_force(force.source, X, force.time)

    return (force1, force2, force3)[D - 1]


def weight(force, walls, frame, particles, p):
    """Vector (0, m_p b_p), which (17) adds to the force on the support's vertices, or ().

    With walls its first component is for `pgimp.kernels.grid.wall_gap`.
    """


@specialise(weight)
def _weight(force, walls, frame, particles, p):
    forced, near = hasattr(force, "instance_class"), len(walls) > 0
    if not forced and not near:
        return lambda force, walls, frame, particles, p: ()

    def near_walls(force, walls, frame, particles, p):
        return pack(particles.m[p] * divergence(walls, particles, p, 0), 0.0, 0.0, 0.0)

    def weight_of(force, walls, frame, particles, p):
        m = particles.m[p]
        b = _force(force, frame, particles, p)
        return pack(0.0, m * b[0], m * b[1], m * b[2])

    def weight_near_walls(force, walls, frame, particles, p):
        m = particles.m[p]
        b = _force(force, frame, particles, p)
        div = divergence(walls, particles, p, 0)
        return pack(m * div, m * b[0], m * b[1], m * b[2])

    if not forced:
        return near_walls
    return weight_near_walls if near else weight_of


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
