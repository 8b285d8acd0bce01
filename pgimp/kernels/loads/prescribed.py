"""Prescribed motion of constraints at a place: velocity, acceleration, moment.

Where no constraint depends on the place, see `PlacedConstraint`, no place is found.
"""

from typing import Any, NamedTuple

from pgimp.jit.kernel import inlined, inner_kernel, specialise
from pgimp.jit.tuples import plus_scaled, scaled
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


def _is_placed(constraints):
    """Whether the velocities of constraints, a type of a tuple of them, depend on the place."""
    return len(constraints) > 0 and hasattr(constraints.types[0].instance_class, "centre")


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


def _coordinates(places, r, number, like):
    """Coordinates of a vertex, zero along missing directions; `like` has D numbers."""


@specialise(_coordinates)
def _coordinates_of(places, r, number, like):
    D = len(like)

    def in_space(places, r, number, like):
        return (
            _along(places, r, number, 0),
            _along(places, r, number, 1),
            _along(places, r, number, 2),
        )

    if D == 3:
        return in_space
    if D == 2:
        return lambda places, r, number, like: (
            _along(places, r, number, 0),
            _along(places, r, number, 1),
            0.0,
        )
    return lambda places, r, number, like: (_along(places, r, number, 0), 0.0, 0.0)


def _along(places, r, number, d):
    """Coordinate `d` of a vertex."""


@specialise(_along)
def _along_grid(places, r, number, d):
    def at_rest(places, r, number, d):
        frame = places.frame
        at = number[d] + places.window.lower[d] - frame.ghost
        return frame.origin[d] + at * frame.cell[d]

    def moved(places, r, number, d):
        frame = places.frame
        at = number[d] + places.window.lower[d] - frame.ghost
        x = frame.origin[d] + at * frame.cell[d]
        return x + places.motion.values[r + DISPLACEMENT + d]

    motion = places.types[places.fields.index("motion")]
    return moved if hasattr(motion, "instance_class") else at_rest


def places_of_four(constraints, particles, rows, like):
    """Places of four particles, D vectors as `like`; () where no constraint depends on them."""


@specialise(places_of_four)
def _places_of_four(constraints, particles, rows, like):
    if not _is_placed(constraints):
        return lambda constraints, particles, rows, like: ()
    return lambda constraints, particles, rows, like: take_row(particles.x, rows, 0, like)


def _has_fields(one):
    """Whether a constraint, given by its type, may have a function of one's own."""
    return hasattr(one.types[one.fields.index("fields")], "instance_class")


def velocity_at(one, x):
    """Velocity that a constraint prescribes at a vertex's place, (3,)."""


@specialise(velocity_at)
def _velocity_at(one, x):
    def by_function(one, x):
        if one.field < 0:
            return _linear(one.velocity, one.gradient, one.centre, x)
        return _three(_mean(one, _first(x, one.fields.like)))

    if len(x) == 0:
        return lambda one, x: one.velocity
    if _has_fields(one):
        return by_function
    return lambda one, x: _linear(one.velocity, one.gradient, one.centre, x)


def velocities_at(one, x, chosen):
    """Velocities that a constraint prescribes for `chosen` ones of four particles, D vectors.

    For all of them where the place does not matter; then three numbers.
    """


@specialise(velocities_at)
def _velocities_at(one, x, chosen):
    def by_function(one, x, chosen):
        w = _linear(one.velocity, one.gradient, one.centre, x)
        if one.field >= 0:
            mask = bits(chosen)
            for j in range(4):
                if mask >> j & 1:
                    w = with_lanes(w, j, _mean(one, of_lane(x, j)))
        return w

    if len(x) == 0:
        return lambda one, x, chosen: one.velocity
    if _has_fields(one):
        return by_function
    return lambda one, x, chosen: _linear(one.velocity, one.gradient, one.centre, x)


def rate_at(one, x):
    """Mean acceleration that a constraint prescribes at a vertex's place, (3,)."""


@specialise(rate_at)
def _rate_at(one, x):
    def by_function(one, x):
        if one.field < 0 or not one.fields.end > one.fields.start:
            return _linear(one.rate, one.rate_gradient, one.centre, x)
        f, y = one.fields, _first(x, one.fields.like)
        dt = f.end - f.start
        last = _own(f.functions, one.field, plus_scaled(dt, _mean(one, y), y), f.end)
        first = _own(f.functions, one.field, y, f.start)
        return _three(scaled(1.0 / dt, plus_scaled(-1.0, first, last)))

    if len(x) == 0:
        return lambda one, x: one.rate
    if _has_fields(one):
        return by_function
    return lambda one, x: _linear(one.rate, one.rate_gradient, one.centre, x)


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
    if len(functions) == 1:
        return call(functions[0], (x, t))
    if number == 0:
        return call(functions[0], (x, t))
    return _own(functions[1:], number - 1, x, t)


def _first(x, like):
    """The first entries of three, as many as `like` has."""


@specialise(_first)
def _first_of(x, like):
    return (lambda x, like: (x[0],), lambda x, like: (x[0], x[1]), lambda x, like: x)[len(like) - 1]


def _three(x):
    """A vector of the scene as three numbers."""


@specialise(_three)
def _three_of(x):
    return (lambda x: (x[0], 0.0, 0.0), lambda x: (x[0], x[1], 0.0), lambda x: x)[len(x) - 1]


def _linear(value, W, c, x):
    """Vector ``value + W (x - c)`` with as many components as `x`."""


@specialise(_linear)
def _linear_in(value, W, c, x):
    def in_space(value, W, c, x):
        a, b, e = x[0] - c[0], x[1] - c[1], x[2] - c[2]
        return (
            value[0] + (W[0] * a + W[1] * b + W[2] * e),
            value[1] + (W[3] * a + W[4] * b + W[5] * e),
            value[2] + (W[6] * a + W[7] * b + W[8] * e),
        )

    def in_plane(value, W, c, x):
        a, b = x[0] - c[0], x[1] - c[1]
        return value[0] + (W[0] * a + W[1] * b), value[1] + (W[3] * a + W[4] * b)

    def on_line(value, W, c, x):
        return (value[0] + W[0] * (x[0] - c[0]),)

    return (on_line, in_plane, in_space)[len(x) - 1]


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
    else:
        return None
