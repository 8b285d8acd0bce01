"""First vertices of supports: one set of functions for all kernels, exact to the bit."""

from math import floor

import pgimp.jit.functions  # noqa: F401  so that they work on vectors of four particles, too
from pgimp.jit.kernel import exact, specialise
from pgimp.jit.tuples import read
from pgimp.kernels.data.frame import InitialFrame, MixedFrame
from pgimp.physics.shapes.base import size

#: Part of a cell by which an initial support may begin before its first vertex:
#: rounding must not divide the lattice particles of a cell. Its weight there is below rounding.
NEAR = 1e-9


def is_initial(frame):
    """Whether a frame, given by its Numba type, belongs to the initial configuration."""
    return frame.instance_class is InitialFrame


def is_mixed(frame):
    """Whether a frame, given by its Numba type, belongs to bodies of both configurations."""
    return frame.instance_class is MixedFrame


def coordinate(frame, particles, p, d):
    """Coordinate along `d` of the weights of particle `p`: current or initial."""


@specialise(coordinate)
def _coordinate(frame, particles, p, d):
    if is_initial(frame):
        return lambda frame, particles, p, d: particles.origin[p, d]
    if is_mixed(frame):
        return lambda frame, particles, p, d: (
            particles.origin[p, d] if frame.lagrangian[particles.body[p]] else particles.x[p, d]
        )
    return lambda frame, particles, p, d: particles.x[p, d]


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
    D = len(frame.types[0])
    like = tuple(float(i == j) for i in range(D) for j in range(D))
    if is_mixed(frame):  # reference weights belong to undeformed particles
        return lambda frame, particles, p: (
            like if frame.lagrangian[particles.body[p]] else read(particles.F, p, 0, like)
        )
    return lambda frame, particles, p: read(particles.F, p, 0, like)


def half_widths(shape, frame, particles, p):
    """Half-widths of particle `p` in cells; costs nothing where the shape keeps its size."""


@specialise(half_widths)
def _half_widths(shape, frame, particles, p):
    return lambda shape, frame, particles, p: size(
        shape, frame.cell, deformation(frame, particles, p)
    )[0]
