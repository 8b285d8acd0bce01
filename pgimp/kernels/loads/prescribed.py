"""Prescribed motion of constraints at a place: velocity, acceleration, moment.

Where no constraint depends on the place, see `PlacedConstraint`, no place is found.
"""

from typing import Any, NamedTuple

from pgimp.jit.kernel import class_of, inlined, inner_kernel, is_record
from pgimp.jit.tuples import plus_scaled, scaled, three
from pgimp.jit.vectors.lanes import of_lane, with_lanes
from pgimp.jit.vectors.simd import bits
from pgimp.kernels.data.frame import Frame, Window
from pgimp.kernels.data.motion import DISPLACEMENT
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.data.velocity_fields import field_size
from pgimp.kernels.transfer.lane_io import take_row
from pgimp.physics.functions.call import call


class Places(NamedTuple):
    """What gives the places of vertices: frame, window, motion; see `Frame`, `Field`."""

    frame: Frame
    window: Window
    motion: Any


@inlined
def _is_placed(constraints):
    """Whether the velocities of constraints depend on the place."""
    return len(constraints) > 0 and hasattr(class_of(constraints[0]), "centre")


@inlined
def place_of(marked, r):
    """Present place of the vertex at `r`, (3,); () where no constraint depends on it.

    Vertices that keep their motion are where that has brought them.

    Parameters
    ----------
    marked : (constraints, mask) or (constraints, mask, Places)
        See `constrained_velocity`.
    """
    if len(marked) < 3:
        return ()
    window = marked[2].window
    plane = r // window.stride[0]
    within = (r - plane * window.stride[0]) % field_size(window)
    row = within // window.stride[1]
    number = (plane, row, (within - row * window.stride[1]) // RECORD)
    return _coordinates(marked[2], r, number, marked[2].frame.origin)


@inlined
def _coordinates(places, r, number, like):
    """Coordinates of a vertex, zero along missing directions; `like` has D numbers."""
    return three(tuple(_along(places, r, number, d) for d in range(len(like))))


@inlined
def _along(places, r, number, d):
    """Coordinate `d` of a vertex."""
    motion = places.motion
    if is_record(motion):
        frame = places.frame
        at = number[d] + places.window.lower[d] - frame.ghost
        x = frame.origin[d] + at * frame.cell[d]
        return x + places.motion.values[r + DISPLACEMENT + d]
    frame = places.frame
    at = number[d] + places.window.lower[d] - frame.ghost
    return frame.origin[d] + at * frame.cell[d]


@inlined
def places_of_four(constraints, particles, rows, like):
    """Places of four particles, D vectors as `like`; () where no constraint depends on them."""
    if not _is_placed(constraints):
        return ()
    return take_row(particles.x, rows, 0, like)


@inlined
def velocity_at(one, x):
    """Velocity that a constraint prescribes at a vertex's place, (3,)."""
    if len(x) == 0:
        return one.velocity
    if is_record(one.fields):
        if one.field < 0:
            return _linear(one.velocity, one.gradient, one.centre, x)
        return three(_mean(one, x[: len(one.fields.like)]))
    return _linear(one.velocity, one.gradient, one.centre, x)


@inlined
def velocities_at(one, x, chosen):
    """Velocities that a constraint prescribes for `chosen` ones of four particles, D vectors.

    For all of them where the place does not matter; then three numbers.
    """
    if len(x) == 0:
        return one.velocity
    if is_record(one.fields):
        w = _linear(one.velocity, one.gradient, one.centre, x)
        if one.field >= 0:
            mask = bits(chosen)
            for j in range(4):
                if mask >> j & 1:
                    w = with_lanes(w, j, _mean(one, of_lane(x, j)))
        return w
    return _linear(one.velocity, one.gradient, one.centre, x)


@inlined
def rate_at(one, x):
    """Mean acceleration that a constraint prescribes at a vertex's place, (3,)."""
    if len(x) == 0:
        return one.rate
    if is_record(one.fields):
        if one.field < 0 or not one.fields.end > one.fields.start:
            return _linear(one.rate, one.rate_gradient, one.centre, x)
        f, y = one.fields, x[: len(one.fields.like)]
        dt = f.end - f.start
        last = _own(f.functions, one.field, plus_scaled(dt, _mean(one, y), y), f.end)
        first = _own(f.functions, one.field, y, f.start)
        return three(scaled(1.0 / dt, plus_scaled(-1.0, first, last)))
    return _linear(one.rate, one.rate_gradient, one.centre, x)


@inner_kernel
def _mean(one, x):
    """Mean velocity of what is at `x`, D numbers, as a step begins: by the midpoint rule."""
    f = one.fields
    v = _own(f.functions, one.field, x, f.start)
    if f.end > f.start:
        y = plus_scaled(0.5 * (f.end - f.start), v, x)
        v = _own(f.functions, one.field, y, 0.5 * (f.start + f.end))
    return v


@inlined
def _own(functions, number, x, t):
    """Value of one of the functions at a place, D numbers, and a time."""
    if len(functions) == 1 or number == 0:
        return call(functions[0], (x, t))
    return _own(functions[1:], number - 1, x, t)


@inlined
def _linear(value, W, c, x):
    """Vector ``value + W (x - c)`` with as many components as `x`."""
    D = len(x)
    arm = tuple(x[d] - c[d] for d in range(D))
    return tuple(value[i] + sum(W[3 * i + k] * arm[k] for k in range(D)) for i in range(D))


@inlined
def add_moment(one, x, d, given, impulse):
    """Add the moment about the centre of an impulse along direction `d` at `x`, where booked.

    Parameters
    ----------
    given : float
        The impulse.
    impulse : (rows, 3) float64
        A plane's rows of `Ledger.constraint_impulse`.
    """
    if len(x) > 0:
        if one.moment >= 0:
            after, before = (d + 1) % 3, (d + 2) % 3
            impulse[one.moment, after] += (x[before] - one.centre[before]) * given
            impulse[one.moment, before] -= (x[after] - one.centre[after]) * given
