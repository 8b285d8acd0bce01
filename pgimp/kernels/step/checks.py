"""Checks of particles after a step: errors, walls, changes of layer, outflow."""

from math import isfinite

from pgimp.jit.kernel import inlined, inner_kernel
from pgimp.jit.tuples import read, squared
from pgimp.jit.vectors.lanes import and_finite, and_positive, of_lane
from pgimp.jit.vectors.simd import bits, lane, vector
from pgimp.kernels.data.particles import OUTFLOW
from pgimp.kernels.grid.position_limits import hold_inside
from pgimp.kernels.transfer.first_vertex import box, first_vertex, is_initial, off_axis
from pgimp.kernels.update.turns import is_periodic
from pgimp.physics.shapes.stretch import LARGEST

#: Errors of a particle.
NOT_FINITE, INVERTED, TOO_FAST, OUTSIDE, OUT_OF_RANGE = 1, 2, 3, 4, 5

#: Result of `_outside` for a particle that has left through an open face.
_LEAVES = -1


@inlined
def within(bounds, x):
    """Whether each coordinate lies within its bounds; false for NaN, never branches."""
    inside = (x[0] >= bounds[0][0]) & (x[0] <= bounds[0][1])
    for d in range(1, len(x)):
        inside = inside & ((x[d] >= bounds[d][0]) & (x[d] <= bounds[d][1]))
    return inside


@inlined
def _all_finite(values):
    """Bit j is set where all of the vectors are finite for particle j."""
    return bits(and_finite(vector(0.0) == 0.0, values))


@inner_kernel
def _broken(x, v, J, finite):
    """Return a particle's error, regardless of position and displacement; 0 for none."""
    for d in range(len(x)):
        if not (isfinite(x[d]) and isfinite(v[d])):
            return NOT_FINITE
    if not isfinite(J):
        return NOT_FINITE
    if not J > 0.0:
        return INVERTED
    return 0 if finite else NOT_FINITE


@inner_kernel
def _unsound(frame, x, v, u, J, finite, valid, dt):
    """Return the error of a particle that failed the combined check, at any position; else 0."""
    error = _broken(x, v, J, finite)
    if error != 0:
        return error
    for d in range(len(x)):
        if not abs(u[d]) * dt * frame.inverse[d] <= 1.0:
            return TOO_FAST
    return 0 if valid else OUT_OF_RANGE


@inner_kernel
def _outside(frame, exits, x):
    """Return whether a particle has left the domain, and whether it may."""
    error = 0
    for d in range(len(x)):
        xi = (x[d] - frame.origin[d]) * frame.inverse[d]
        if not ((xi >= 0.0 and xi <= frame.cells[d]) or is_periodic(exits, d)):
            if exits >> (2 * d + (xi > 0.0)) & 1 == 0:
                return OUTSIDE
            error = _LEAVES
    return error


@inlined
def check(limits, field, particles, four, found, report, ledger, counts):
    """Check four particles, and examine those that fail the combined check.

    In the initial configuration they keep their layers, and may be anywhere except beyond a wall.

    Parameters
    ----------
    limits : tuple
        See `limits_of`.
    field, particles, four, report, ledger
        See `Field`, `Particles`, `FourParticles`, `Report`, `Ledger`.
    found : tuple
        u, v, x, F, J, state and margin of the four.
    counts : tuple of 5 int
        As in `examine`.

    Returns
    -------
    tuple of 5 int
        The counts with these particles.
    """
    if is_initial(limits[0]):
        _, v, x, _, J, state, margin = found
        sound = and_finite(and_finite(within(field.bounds, x) & (J > 0.0), state), v)
        usual = bits(and_positive(sound, margin))
        if usual != 15:
            good = (usual, _all_finite(state))
            counts = _count_errors(field.bounds, four, good, (v, x, J), report, counts)
        return counts
    frame, shape, limit, number = limits[0], limits[1], limits[2], four.number
    u, v, x, F, J, state, margin = found
    # One branch for all rare events, NaN included; its speed limit is stricter.
    at = off_axis(frame, x)
    half, most = box(shape, frame, F, at)
    now = first_vertex(frame, 0, half[0], at[0])
    sound = and_finite(within(field.bounds, x) & (J > 0.0), state)
    sound = and_positive(sound, margin)
    slower = (squared(u) + squared(v)) * limit <= 1.0
    usual = bits(sound & slower & (now == number) & (vector(most) <= LARGEST))
    if usual != 15:
        good = (usual, _all_finite(state), bits(and_positive(vector(0.0) == 0.0, margin)))
        counts = examine(
            (frame, *limits[3:]), particles, four, good, (u, v, x, J, half, now, most),
            report, ledger, counts,
        )  # fmt: skip
    return counts


@inlined
def limits_of(setting, forcing, inverse):
    """The part of a scene for `check`: without its materials, of which there are many.

    Parameters
    ----------
    setting, forcing
        See `KernelScene`, `Forcing`.
    inverse : float
        The greatest 1/L.

    Returns
    -------
    tuple
        The frame; the shape; (dt/L)^2, with which the greatest speed squared of a slow particle is
        1; the exit faces; dt; walls; constraints.
    """
    return (
        setting.frame, setting.shape, (forcing.dt * inverse) ** 2, setting.exits, forcing.dt,
        forcing.position_limits, forcing.constraints,
    )  # fmt: skip


@inlined
def _count_errors(bounds, four, good, found, report, counts):
    """As `examine`, in the initial configuration: errors alone."""
    usual, finite = good
    v, x, J = found
    failed, outflow, moved, clamped, held = counts
    for j in range(four.size):
        if usual >> j & 1:
            continue
        xj = of_lane(x, j)
        error = _broken(xj, of_lane(v, j), lane(J, j), finite >> j & 1)
        if error == 0:
            error = OUT_OF_RANGE if within(bounds, xj) else OUTSIDE
        if failed < len(report.errors):
            report.errors[failed, 0] = four.rows[j]
            report.errors[failed, 1] = error
        failed += 1
    return failed, outflow, moved, clamped, held


@inlined
def examine(limits, particles, four, good, found, report, ledger, counts):
    """Examine the particles of four that failed the combined check.

    Parameters
    ----------
    limits : tuple
        From `limits_of` without the shape and the speed of a slow particle, so that many shapes
        share this part of the kernels.
    particles, four, report, ledger
        As in `check`.
    good : tuple of 3 int
        In turn, bit j is set if particle j passed the check, has a finite state, is in its
        material's range.
    found : tuple
        u, v, x, J, half-widths, first vertex along x and greatest stretch of the four.
    counts : tuple of 5 int
        Particles at fault, particles that left, that left or changed their layer, with clamped
        half-width, held in by walls.

    Returns
    -------
    tuple of 5 int
        The counts with these particles.
    """
    frame, exits, dt, walls, constraints = limits
    number, bounds = four.number, report.vertex_bounds
    usual, finite, valid = good
    u, v, x, J, half, now, most = found
    failed, outflow, moved, clamped, held = counts
    for j in range(four.size):
        if usual >> j & 1:
            continue
        p = four.rows[j]
        clamped += lane(vector(most), j) > LARGEST
        xj = of_lane(x, j)
        layer_now = int(lane(now, j))
        error = _unsound(
            frame, xj, of_lane(v, j), of_lane(u, j), lane(J, j), finite >> j & 1,
            valid >> j & 1, dt,
        )  # fmt: skip
        if error == 0:
            error = _outside(frame, exits, xj)
        if error == OUTSIDE and hold_inside(
            walls, frame, constraints, particles, p,
            ledger.impulse[four.layer], ledger.work[four.layer : four.layer + 1],
        ):  # fmt: skip
            held += 1
            xj = read(particles.x, p, 0, frame.origin)
            at = off_axis(frame, xj)
            layer_now = int(first_vertex(frame, 0, lane(vector(half[0]), j), at[0]))
            error = _outside(frame, exits, xj)
        if error == _LEAVES:
            particles.layer[p] = OUTFLOW
            report.changed[moved] = four.first + j
            moved += 1
            outflow += 1
            continue
        if error == 0 and abs(layer_now - number) > 1:
            error = TOO_FAST  # a cell, but for rounding: past a slab of one layer
        if error != 0:
            if failed < len(report.errors):
                report.errors[failed, 0] = p
                report.errors[failed, 1] = error
            failed += 1
            continue
        for d in range(1, len(xj)):
            i = first_vertex(frame, d, lane(vector(half[d]), j), xj[d])
            bounds[0, d - 1] = min(bounds[0, d - 1], i)
            bounds[1, d - 1] = max(bounds[1, d - 1], i)
        if layer_now != number:
            particles.layer[p] = layer_now
            report.changed[moved] = four.first + j
            moved += 1
    return failed, outflow, moved, clamped, held
