"""Grid to particles: positions and velocities (26, 27), deformation (29, 30), volume and stress."""

from math import isfinite, sqrt

from pgimp.kernels.algebra import determinant, multiply, one_plus, symmetric
from pgimp.kernels.grips import gripped
from pgimp.kernels.jit import kernel, specialise
from pgimp.kernels.loads import add_power, keep_gradient, relaxed
from pgimp.kernels.transfer import components, first_vertex, gather, gradient, support
from pgimp.kernels.tuples import plus_scaled, read, write
from pgimp.kernels.viscosity import stiffened, thicken
from pgimp.materials.base import evaluate
from pgimp.shapes.base import size

#: What is wrong with a particle at fault.
NOT_FINITE, INVERTED, TOO_FAST, OUTSIDE = 1, 2, 3, 4

#: What `_fault` says of a particle that has left through a face that lets it go.
_LEAVES = -1

#: The layer of such a particle.
GONE = -1


def within(bounds, x):
    """Whether each coordinate lies within its bounds; false for NaN, never branches."""


@specialise(within)
def _within(bounds, x):
    if len(x) == 1:
        return lambda bounds, x: (x[0] >= bounds[0][0]) & (x[0] <= bounds[0][1])
    return lambda bounds, x: (
        (x[0] >= bounds[0][0]) & (x[0] <= bounds[0][1]) & within(bounds[1:], x[1:])
    )


def squared(v):
    """Square of the length of a tuple."""


@specialise(squared)
def _squared(v):
    if len(v) == 1:
        return lambda v: v[0] * v[0]
    return lambda v: v[0] * v[0] + squared(v[1:])


@kernel
def _fault(frame, exits, x, v, u, J, dt):
    """Name the fault of a particle that failed the combined check; 0 if there is none."""
    for d in range(len(x)):
        if not (isfinite(x[d]) and isfinite(v[d])):
            return NOT_FINITE
    if not isfinite(J):
        return NOT_FINITE
    if not J > 0.0:
        return INVERTED
    for d in range(len(x)):
        if not abs(u[d]) * dt * frame.inverse[d] <= 1.0:
            return TOO_FAST
    fault = 0
    for d in range(len(x)):
        xi = (x[d] - frame.origin[d]) * frame.inverse[d]
        if not (xi >= 0.0 and xi <= frame.cells[d]):
            if exits >> (2 * d + (xi > 0.0)) & 1 == 0:
                return OUTSIDE
            fault = _LEAVES
    return fault


@kernel
def grid_to_particles(
    shape, materials, frame, window, particles, loads, grips, order, start, first, last,
    material_of, G, dt, tracked, controlled, bounds, exits, reach, movers, faults, impulse, work,
):  # fmt: skip
    """Advance the particles of some layers by one step, and notice what happened to them.

    A particle at fault is left as it was computed, in its layer; the others go on.

    Parameters
    ----------
    shape, materials, frame, window, particles, loads, order, start, G
        As in `particles_to_grid`; `G` holds velocities and accelerations.
    grips : tuple of Grip
        See `pgimp.kernels.grips`.
    first, last : int
        The layers, counted from the rank's first one; `last` is behind the last.
    material_of : (bodies,) int64
        Material of each body.
    tracked : bool
        Whether V follows det(F) V0.
    controlled : bool
        Whether the next step depends on the particles' speeds.
    bounds : tuple of D pairs
        Coordinates within which a particle is sure to stay in the domain and in the window.
    exits : int
        Bit 2 d + s is set for a face, of direction d at the low (s = 0) or high end (1), through
        which particles may leave; one that has left through such faces alone gets the layer `GONE`.
    reach : (2, 2) int64
        Grown to the first vertices (least, greatest; y, z) of particles, at least of those beyond
        `bounds`.
    movers : (n,) int32
        Filled with the places, in `order`, of the particles that changed their layer or left.
    faults : (room, 2) int64
        Filled with row and fault of the particles at fault, of the first ones if there are more.
    impulse : (planes, grips, 3) float64
        Grows by the momentum that the grips give to particles, layer by layer.
    work : (planes,) float64
        Grows by the work of the loads and grips on particles, layer by layer.

    Returns
    -------
    faults, leavers, movers : int
        Number of particles at fault, of those that left, of those that left or changed their layer.
    rate : float
        Largest (c_p + |v_p|)/L, if controlled.
    clamped : int
        Number of particles whose half-width is clamped.
    """
    failed = 0
    leavers = 0
    found = 0
    clamped = 0
    rate = 0.0
    inverse = 0.0
    for d in range(len(frame.inverse)):
        inverse = max(inverse, frame.inverse[d])
    limit = (dt * inverse) ** 2
    for layer in range(first, last):
        number = layer + window.lower[0]
        for k in range(start[layer], start[layer + 1]):
            p = order[k]
            place, W = support(shape, frame, window, particles, p, number)
            place += layer * window.stride[0]
            U, A, D = gather(G, place, W[0][0], W[0][1], W[0][2], W[1:])
            u = components(frame.origin, U)
            a = components(frame.origin, A)
            add_power(
                loads, shape, frame, window, particles, p, number, W,
                layer * window.stride[0], G, u, dt, work, layer,
            )  # fmt: skip
            v = plus_scaled(dt, a, read(particles.v, p, 0, u))  # (27)
            v = relaxed(loads.relaxation, dt, v, u)
            u, v = gripped(grips, particles, p, u, v, impulse, work, layer)
            x = plus_scaled(dt, u, read(particles.x, p, 0, u))  # (26)
            L = gradient(D)  # (30)
            keep_gradient(loads.affine, particles, p, L)
            F = multiply(one_plus(dt, L), read(particles.F, p, 0, L))
            J = determinant(F)
            m = material_of[particles.body[p]]
            sigma = read(particles.sigma, p, 0, symmetric(L))
            sigma = evaluate("stress", materials, m, (F, J, sigma, L, dt))
            write(particles.x, p, 0, x)
            write(particles.v, p, 0, v)
            write(particles.F, p, 0, F)
            write(particles.sigma, p, 0, sigma)
            if tracked:
                particles.V[p] = J * particles.V0[p]
            slow = thicken(loads.viscosity, materials, m, particles, p, F, L)  # (45)
            if controlled:
                c = stiffened(loads.viscosity, evaluate("speed", materials, m, (F, J)), slow)
                rate = max(rate, (c + sqrt(squared(v))) * inverse)
            # One branch for all that rarely happens, NaN included; its speed limit is sharper.
            half, clamp = size(shape, frame.cell, F)
            clamped += clamp
            now = first_vertex(frame, 0, half[0], x[0])
            if not (
                within(bounds, x)
                & (J > 0.0)
                & ((squared(u) + squared(v)) * limit <= 1.0)
                & (now == number)
            ):
                fault = _fault(frame, exits, x, v, u, J, dt)
                if fault == _LEAVES:
                    particles.layer[p] = GONE
                    movers[found] = k
                    found += 1
                    leavers += 1
                    continue
                if fault == 0 and abs(now - number) > 1:
                    fault = TOO_FAST  # a cell, but for rounding: past a slab of one layer
                if fault != 0:
                    if failed < len(faults):
                        faults[failed, 0] = p
                        faults[failed, 1] = fault
                    failed += 1
                    continue
                for d in range(1, len(x)):
                    j = first_vertex(frame, d, half[d], x[d])
                    reach[0, d - 1] = min(reach[0, d - 1], j)
                    reach[1, d - 1] = max(reach[1, d - 1], j)
                if now != number:
                    particles.layer[p] = now
                    movers[found] = k
                    found += 1
    return failed, leavers, found, rate, clamped
