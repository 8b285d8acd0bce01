"""First vertices of supports: one set of functions for all kernels, exact to the bit."""

from math import floor

import pgimp.jit.functions  # noqa: F401  so that they work on vectors of four particles, too
from pgimp.jit.kernel import exact, inlined, of_types, specialise
from pgimp.jit.tuples import joined, read
from pgimp.jit.vectors.kinds import is_vector
from pgimp.jit.vectors.simd import vector
from pgimp.kernels.data.frame import (
    AxialFrame,
    AxialInitialFrame,
    InitialFrame,
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


def is_mixed(frame):
    """Whether a frame, given by its Numba type, belongs to bodies of both configurations."""
    return frame.instance_class is MixedFrame


@of_types
def is_axial(frame):
    """Whether a frame, given by its Numba type, belongs to an axisymmetric scene."""
    return frame.instance_class in (AxialFrame, AxialInitialFrame)


@of_types
def is_plate(frame):
    """Whether a frame, given by its Numba type, belongs to a scene in plane stress."""
    return frame.instance_class in (PlateFrame, PlateInitialFrame)


def undeformed(frame):
    """Return the undeformed deformation gradient of a frame, given by its Numba type."""
    return identity(len(frame.types[0]), is_axial(frame) or is_plate(frame))


def coordinate(frame, particles, p, d):
    """Coordinate along `d` of the weights of particle `p`: current or initial."""


@specialise(coordinate)
def _coordinate(frame, particles, p, d):
    if is_initial(frame):
        return lambda frame, particles, p, d: particles.origin[p, d]
    if is_axial(frame):
        return lambda frame, particles, p, d: (
            off_axis(frame, (particles.x[p, 0],))[0] if d == 0 else particles.x[p, d]
        )
    if is_mixed(frame):
        return lambda frame, particles, p, d: (
            particles.origin[p, d] if frame.lagrangian[particles.body[p]] else particles.x[p, d]
        )
    return lambda frame, particles, p, d: particles.x[p, d]


def off_axis(frame, x):
    """Coordinates of the weights of particles at `x`: in axisymmetry never on the axis itself.

    `x` has one entry a direction, or those of the first directions alone.
    """


@exact(off_axis)
def _off_axis(frame, x):
    if is_axial(frame):
        return lambda frame, x: joined(max(x[0], AXIS * frame.cell[0]), x[1:])
    return lambda frame, x: x


def box(shape, frame, F, x):
    """Half-widths of chi_p by direction, in cells, and the largest before clamping.

    In axisymmetry no particle reaches beyond the axis: with a half-width of at most the radius all
    sums of weights stay exact. `x` is as of `coordinates`.
    """


@exact(box)  # all kernels must find the same layer, in any code
def _box(shape, frame, F, x):
    if is_axial(frame):

        def beside_axis(shape, frame, F, x):
            half, most = size(shape, frame.cell, F)
            return (min(half[0], x[0] * frame.inverse[0]), half[1]), most

        def four_beside_axis(shape, frame, F, x):
            half, most = size(shape, frame.cell, F)
            return (min(half[0], x[0] * frame.inverse[0]), vector(half[1])), most

        return four_beside_axis if is_vector(x[0]) else beside_axis
    return lambda shape, frame, F, x: size(shape, frame.cell, F)


def first_vertex(frame, d, half, x):
    """Number of the first vertex, along direction `d`, of particles at coordinate `x`.

    An int of a number; of a vector a vector.
    """


@exact(first_vertex)  # all kernels must find the same layer, in any code
def _first_vertex(frame, d, half, x):
    if is_initial(frame):
        return lambda frame, d, half, x: (
            floor((x - frame.origin[d]) * frame.inverse[d] - half + NEAR) + frame.ghost
        )
    return lambda frame, d, half, x: (
        floor((x - frame.origin[d]) * frame.inverse[d] - half) + frame.ghost
    )


def deformation(frame, particles, p):
    """Deformation gradient of particle `p`, a row-major tuple."""


@specialise(deformation)
def _deformation(frame, particles, p):
    like = undeformed(frame)
    if is_mixed(frame):  # reference weights belong to undeformed particles
        return lambda frame, particles, p: (
            like if frame.lagrangian[particles.body[p]] else read(particles.F, p, 0, like)
        )
    return lambda frame, particles, p: read(particles.F, p, 0, like)


@inlined
def half_widths(shape, frame, particles, p):
    """Half-widths of particle `p` in cells; costs nothing where the shape keeps its size."""
    if is_axial(frame):
        return box(
            shape, frame, deformation(frame, particles, p), (coordinate(frame, particles, p, 0),)
        )[0]
    return size(shape, frame.cell, deformation(frame, particles, p))[0]
