"""Clearance of bodies from unilateral walls, at each vertex of a wall.

A vertex on a wall has weight on a body that is still a cell away. With w the distance from the
wall, along its normal, the divergence theorem turns the sum over the body's particles

    sum_p m_p (w . grad S_vp + S_vp div w)

into minus the density times the integral of w S over the body's lower surface. It is zero for a
body on the wall, for any filled part of the neighbourhood and any strain. For a surface along the
wall at the distance z it is -2 z/(h - z) times the vertex's mass, which gives z; for other
surfaces z is a mean. Away from the wall w falls to zero, so that walls of other directions are not
affected, except at edges, where both clearances add up.

The sum uses the entry of a vertex's record that is free until the momentum update.
"""

from typing import NamedTuple

from pgimp.jit.kernel import inlined, inner_kernel, is_array, is_record, kernel
from pgimp.kernels.data.record import CLEARANCE_SUM, MASS, RECORD
from pgimp.kernels.data.velocity_fields import field_count, field_size

#: Clearance, as part of a cell, that counts as none: greater than the strain of a closed one gives.
#: Otherwise bodies under pressure would yield into it again and again, and lose energy.
CLOSED = 0.01


class Sides(NamedTuple):
    """The walls across one direction; all numbers are 0 without any."""

    #: low, high: Coordinates of the low and the high wall; equal if there is only one.
    low: float
    high: float
    middle: float  #: Particles beyond it belong to the high wall.
    peak: float  #: Distance from the wall at which w is greatest.


class Wall(NamedTuple):
    """A face whose clearance is computed."""

    #: axis, side, number: As in `Images`.
    axis: int
    side: int
    number: int


@inner_kernel
def _distance(sides, x):
    """W along the walls' direction at the coordinate x, and its derivative."""
    z = x - (sides.low if x < sides.middle else sides.high)
    far = abs(z)
    w = min(far, max(2.0 * sides.peak - far, 0.0))
    slope = 1.0 if far < sides.peak else (-1.0 if w > 0.0 else 0.0)
    return (w if z > 0.0 else -w), slope


@inlined
def wall(walls, d):
    """The entry of `Loads.approached` for a direction; () without any."""
    if len(walls) == 0:
        return ()
    return walls[d]


@inlined
def moment(walls, particles, p, d):
    """m_p w_p along direction `d`; `walls` is the entry of `Loads.approached` for it, or ()."""
    if not is_record(walls):
        return 0.0
    return particles.m[p] * _distance(walls, particles.x[p, d])[0]


@inlined
def divergence(walls, particles, p, d):
    """Divergence of w from direction `d` on, which is the first in `walls`."""
    if len(walls) == 0:
        return 0.0
    return _distance(walls[0], particles.x[p, d])[1] + divergence(walls[1:], particles, p, d + 1)


@kernel
def find_clearances(frame, field, wall, joint, clearances):
    """Find the clearance, a length, at the vertices on a wall, also for the vertices beyond.

    Parameters
    ----------
    frame, field
        See `Frame`, `Field`, with the sums of particles.
    wall : Wall
        The face.
    joint : bool
        Whether all velocity fields at a vertex have one clearance, as tied bodies must.
    clearances : (faces, vertices) float64
        The face's row is set here, at the vertices with mass.
    """
    window, G, active, row = field.window, field.G, field.active, clearances[wall.number]
    axis = wall.axis
    step = window.stride[axis]
    face = (frame.ghost if wall.side < 0 else frame.ghost + frame.cells[axis]) - window.lower[axis]
    i0, i1 = _reached(window, wall, face, 0)
    j0, j1 = _reached(window, wall, face, 1)
    k0, k1 = _reached(window, wall, face, 2)
    for f in range(field_count(window)):
        begin = f * field_size(window)
        for i in range(i0, i1):
            if active[i] == 0:
                continue
            for j in range(j0, j1):
                for k in range(k0, k1):
                    offset = begin + i * window.stride[0] + j * window.stride[1]
                    offset += k * window.stride[2]
                    if not G[offset + MASS] > 0.0:
                        continue
                    on = offset + (face - (i if axis == 0 else (j if axis == 1 else k))) * step
                    mass, sums = 0.0, 0.0
                    if axis > 0 or active[face] != 0:
                        first = on - begin if joint else on
                        for g in range(field_count(window) if joint else 1):
                            mass += G[first + g * field_size(window) + MASS]
                            sums += G[first + g * field_size(window) + CLEARANCE_SUM]
                    deficit = max(-sums, 0.0)
                    part = deficit / (2.0 * mass + deficit) if mass > 0.0 else 0.0
                    row[offset // RECORD] = max(part - CLOSED, 0.0) * frame.cell[axis]


@inner_kernel
def _reached(window, wall, face, d):
    """Range of the window's vertices along direction `d` that may lie on the wall or beyond."""
    count = window.extent[d]
    if d != wall.axis:
        return 0, count
    if face < 0 or face >= count:  # none on the wall is stored, so none beyond: see `Scene.ends`
        return 0, 0
    return (0, face + 1) if wall.side < 0 else (face, count)


@inlined
def clear(clearances, G, r):
    """Clear the sum for the clearances in the record at `r`."""
    if not is_array(clearances):
        return None
    G[r + CLEARANCE_SUM] = 0.0


@inlined
def clearance_at(clearances, n, r):
    """Clearance from face `n` of the record at `r`."""
    if not is_array(clearances):
        return 0.0
    return clearances[n, r // RECORD]
