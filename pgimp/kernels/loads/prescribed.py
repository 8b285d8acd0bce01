"""Prescribed motion of constraints at a place: velocity, acceleration, moment.

Where no constraint depends on the place, see `PlacedConstraint`, no place is found.
"""

from typing import Any, NamedTuple

from pgimp.jit.kernel import specialise
from pgimp.kernels.data.frame import Frame, Window
from pgimp.kernels.data.motion import DISPLACEMENT
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.data.velocity_fields import field_size
from pgimp.kernels.transfer.lane_io import take_row


class Places(NamedTuple):
    """What gives the places of vertices: frame, window, motion; see `Frame`, `Field`."""

    frame: Frame
    window: Window
    motion: Any


def _is_placed(constraints):
    """Whether the velocities of constraints, a type of a tuple of them, depend on the place."""
    return len(constraints) > 0 and hasattr(constraints.types[0].instance_class, "centre")


def place_of(marked, r):
    """Present place of the vertex at `r`, (3,); () where no constraint depends on it.

    Vertices that keep their motion are where that has brought them.

    Parameters
    ----------
    marked : (constraints, mask) or (constraints, mask, Places)
        See `constrained_velocity`.
    """


@specialise(place_of)
def _place_of(marked, r):
    if len(marked) < 3:
        return lambda marked, r: ()

    def place(marked, r):
        window = marked[2].window
        plane = r // window.stride[0]
        within = (r - plane * window.stride[0]) % field_size(window)
        row = within // window.stride[1]
        number = (plane, row, (within - row * window.stride[1]) // RECORD)
        return _coordinates(marked[2], r, number, marked[2].frame.origin)

    return place


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


def velocity_at(one, x):
    """Velocity that a constraint prescribes at a place, at least D components."""


@specialise(velocity_at)
def _velocity_at(one, x):
    if len(x) == 0:
        return lambda one, x: one.velocity
    return lambda one, x: _linear(one.velocity, one.gradient, one.centre, x)


def rate_at(one, x):
    """Mean acceleration that a constraint prescribes at a place."""


@specialise(rate_at)
def _rate_at(one, x):
    if len(x) == 0:
        return lambda one, x: one.rate
    return lambda one, x: _linear(one.rate, one.rate_gradient, one.centre, x)


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

    return in_space if len(x) == 3 else in_plane


def add_moment(one, x, d, given, impulse):
    """Add the moment about the centre of an impulse along direction `d` at `x`, where booked.

    Parameters
    ----------
    given : float
        The impulse.
    impulse : (rows, 3) float64
        A plane's rows of `Ledger.constraint_impulse`.
    """


@specialise(add_moment)
def _add_moment(one, x, d, given, impulse):
    def add(one, x, d, given, impulse):
        if one.moment >= 0:
            after, before = (d + 1) % 3, (d + 2) % 3
            impulse[one.moment, after] += (x[before] - one.centre[before]) * given
            impulse[one.moment, before] -= (x[after] - one.centre[after]) * given

    return add if len(x) > 0 else lambda one, x, d, given, impulse: None
