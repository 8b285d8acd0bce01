"""First vertices of supports: one set of functions for all kernels, exact to the bit."""

from math import floor

import pgimp.jit.functions  # noqa: F401  so that they work on vectors of four particles, too
from pgimp.jit.kernel import exact, inlined, of_types
from pgimp.jit.tuples import joined, read
from pgimp.jit.vectors.kinds import is_vector
from pgimp.jit.vectors.simd import vector
from pgimp.kernels.data.frame import (
    AxialFrame,
    AxialInitialFrame,
    InitialFrame,
    MixedAxialFrame,
    MixedExactAxialFrame,
    MixedExactFrame,
    MixedFrame,
    PlateFrame,
    PlateInitialFrame,
    identity,
)
from pgimp.physics.shapes.base import size

#: Part of a cell by which an initial support may begin before its first vertex:
#: rounding must not divide the lattice particles of a cell. Its weight there is below rounding.
NEAR = 1e-9

#: Least radius, in cells, of a particle's weights in axisymmetry: nearer they lose digits.
AXIS = 1e-3


@of_types
def is_initial(frame):
    """Whether a frame, given by its Numba type, belongs to the initial configuration."""
    return frame.instance_class in (InitialFrame, AxialInitialFrame, PlateInitialFrame)


@of_types
def is_mixed(frame):
    """Whether a frame, given by its Numba type, belongs to bodies of both configurations."""
    return issubclass(frame.instance_class, MixedFrame)


@of_types
def is_beside_parts(frame):
    """Whether a frame is mixed, with bodies exact to their surface in the initial configuration."""
    return issubclass(frame.instance_class, MixedExactFrame)


@of_types
def is_axial(frame):
    """Whether a frame, given by its Numba type, belongs to an axisymmetric scene."""
    mixed = MixedAxialFrame, MixedExactAxialFrame
    return frame.instance_class in (AxialFrame, AxialInitialFrame, *mixed)


@of_types
def is_plate(frame):
    """Whether a frame, given by its Numba type, belongs to a scene in plane stress."""
    return frame.instance_class in (PlateFrame, PlateInitialFrame)


@of_types
def undeformed(frame):
    """Undeformed deformation gradient of a frame, given by its Numba type."""
    return identity(len(frame.types[0]), is_axial(frame) or is_plate(frame))


@inlined
def coordinate(frame, particles, p, d):
    """Coordinate along `d` of the weights of particle `p`: current or initial."""
    if is_initial(frame):
        return particles.origin[p, d]
    now = particles.x[p, d]
    if is_axial(frame):
        now = off_axis(frame, (now,))[0] if d == 0 else now
    if is_mixed(frame):
        return particles.origin[p, d] if frame.lagrangian[particles.body[p]] else now
    return now


@exact
def off_axis(frame, x):
    """Coordinates of the weights of particles at `x`: in axisymmetry never on the axis itself.

    `x` has one entry a direction, or those of the first directions alone.
    """
    if is_axial(frame):
        return joined(max(x[0], AXIS * frame.cell[0]), x[1:])
    return x


@exact  # all kernels must find the same layer, in any code
def box(shape, frame, F, x):
    """Half-widths of chi_p by direction, in cells, and the largest before clamping.

    In axisymmetry no particle reaches beyond the axis: with a half-width of at most the radius all
    sums of weights stay exact. `x` is as of `coordinates`.
    """
    if is_axial(frame):
        if is_vector(x[0]):
            half, most = size(shape, frame.cell, F)
            return (min(half[0], x[0] * frame.inverse[0]), vector(half[1])), most
        half, most = size(shape, frame.cell, F)
        return (min(half[0], x[0] * frame.inverse[0]), half[1]), most
    return size(shape, frame.cell, F)


@exact  # all kernels must find the same layer, in any code
def first_vertex(frame, d, half, x):
    """Number of the first vertex, along direction `d`, of particles at coordinate `x`.

    An int of a number; of a vector a vector.
    """
    if is_initial(frame):
        return floor((x - frame.origin[d]) * frame.inverse[d] - half + NEAR) + frame.ghost
    return floor((x - frame.origin[d]) * frame.inverse[d] - half) + frame.ghost


@inlined
def deformation(frame, particles, p):
    """Deformation gradient of particle `p`, a row-major tuple."""
    like = undeformed(frame)
    if is_mixed(frame):
        return like if frame.lagrangian[particles.body[p]] else read(particles.F, p, 0, like)
    return read(particles.F, p, 0, like)


@inlined
def half_widths(shape, frame, particles, p):
    """Half-widths of particle `p` in cells; costs nothing where the shape keeps its size."""
    F = deformation(frame, particles, p)
    if is_axial(frame):
        half = box(shape, frame, F, (coordinate(frame, particles, p, 0),))[0]
    else:
        half = size(shape, frame.cell, F)[0]
    if is_beside_parts(frame):
        part = 0.0 if frame.lagrangian[particles.body[p]] else 1.0
        return tuple(part * h for h in half)
    return half
