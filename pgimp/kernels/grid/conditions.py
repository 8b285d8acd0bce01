"""Conditions on a vertex: faces and constraints, one after the other."""

from typing import NamedTuple

from pgimp.jit.kernel import class_of, inlined
from pgimp.kernels.data.arguments import Forcing
from pgimp.kernels.data.frame import Frame
from pgimp.kernels.data.ledger import WALL_HEAT, WALL_LOSS
from pgimp.kernels.data.particles import FloatArray
from pgimp.kernels.grid.constraints import constrained_velocity, former_velocity
from pgimp.kernels.grid.faces import KIND, Faces, constrained, is_beyond, side_of, unilateral_walls
from pgimp.kernels.loads.loads import given
from pgimp.kernels.loads.wall_gap import clearance_at


class Holding(NamedTuple):
    """Faces and constraints that may hold vertices."""

    faces: Faces | tuple[()]  #: Faces or (): The conditions of the domain's faces.
    frame: Frame  #: Position of the grid, and so of the faces.
    forcing: Forcing  #: Its constraints come after the faces.
    #: (faces, 3) float64: Grows by each face's impulse: a part of the ledger, or scratch where
    #: nothing is booked.
    impulse: FloatArray
    #: float or (): Rate at which the vertex's field takes the grid's velocity, see `grid_rate`.
    rate: float | tuple[()]


@inlined
def hold(holding, number, r, v, a, mass):
    """Apply the conditions of all faces that a vertex is on or beyond, one after the other.

    A face's part of the momentum that the particles gain in a step is its condition's addition,
    see `given`; `impulse` grows by it. The vertex's record is at `r`. Returns its velocity
    and acceleration.
    """
    if len(holding.faces) == 0:
        return (v, a)
    faces, forcing, impulse = holding.faces, holding.forcing, holding.impulse
    rate, dt = holding.rate, forcing.dt
    for n in range(len(faces.rows)):
        if is_beyond(faces, n, holding.frame, number):
            u, b = v, a
            clearance = clearance_at(forcing.clearances, n, r)
            v, a = constrained(faces.kinds, 0, faces.rows, n, v, a, clearance)
            for d in range(3):
                impulse[n, d] += given(rate, mass, dt, u[d], b[d], v[d], a[d])
    return v, a


@inlined
def book_losses(holding, number, r, motion, last, mass, lost):
    """Book the energy that unilateral faces take at a vertex, as contact books do for pairs.

    They are at rest and do no work. Their impulses, each as `hold` finds it, times the velocity
    after all conditions are heat, across the normal, and loss, along it.

    Parameters
    ----------
    motion : tuple
        Velocity and acceleration before all conditions.
    last : tuple
        The velocity after them.
    lost : (faces, WALL_BOOKED) float64
        Grows by heat and loss.

    Returns
    -------
    float
        Impulses times the velocity, summed over these faces.
    """
    faces, forcing, done = holding.faces, holding.forcing, 0.0
    if len(faces) == 0 or not any(hasattr(class_of(k), "approach") for k in faces.kinds):
        return 0.0
    rate, dt = holding.rate, forcing.dt
    v, a = motion
    for n in range(len(faces.rows)):
        if not is_beyond(faces, n, holding.frame, number):
            continue
        u, b = v, a
        clearance = clearance_at(forcing.clearances, n, r)
        v, a = constrained(faces.kinds, 0, faces.rows, n, v, a, clearance)
        if not unilateral_walls(faces.kinds, 0, int(faces.rows[n, KIND])):
            continue
        for d in range(3):
            one = given(rate, mass, dt, u[d], b[d], v[d], a[d]) * last[d]
            lost[n, WALL_LOSS if d == side_of(faces, n)[0] else WALL_HEAT] -= one
            done += one
    return done


@inlined
def held_velocity(holding, number, r, v, last):
    """Velocity v of the vertex at `r` after faces and constraints.

    Conditions are taken at the step's end (`last`), or at its beginning.
    """
    u, _ = hold(holding, number, r, v, (0.0, 0.0, 0.0), 0.0)
    if last:
        return constrained_velocity(holding.forcing.marked, r, u)
    return former_velocity(holding.forcing.marked, r, u, holding.forcing.dt)
