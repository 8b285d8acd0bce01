"""Weights along the radius of an axisymmetric scene, where particles and vertices are rings.

After Nairn and Guilkey, Axisymmetric form of the generalized interpolation material point method,
Int. J. Numer. Meth. Engng 101, 127-147 (2015). A particle's box of half-width l about the radius r
has the mean s0 of a vertex's tent N, and the first moment s1, the mean of N (x - r). As rings
weigh with their radius,

    S = s0 + s1/r,    dS/dr = g0 + ((N(r + l) + N(r - l))/2 - s0)/r,    T = s0/r,

with the box's own gradient g0. T gives the rate of the hoop strain, sum T v_r. For l <= r their
sums over the vertices are exact: S 1, dS/dr 0, T 1/r, r_v dS/dr 1, r_v T 1.

The mass of a ring has its centroid at r + l^2/(3 r): there its velocity is the grid's, and from
there the arms of affine transfers are counted. Its box moves with the mean s0, r sum T v: the
radius then grows as the hoop stretch does, to rounding.
"""

from pgimp.jit.kernel import inlined
from pgimp.jit.tuples import plus_scaled, scaled
from pgimp.kernels.transfer.first_vertex import is_axial
from pgimp.kernels.transfer.lane_io import coordinates
from pgimp.physics.shapes.base import moments, weights


@inlined
def ring_weights(shape, half, f, r):
    """Weights along the radius, in cells.

    Parameters
    ----------
    shape, half, f
        As of `weights`.
    r : float or Vec4
        Radius, in cells.

    Returns
    -------
    S, G, T : tuple
        Weights, gradients, weights of the hoop.
    centroid : float or Vec4
        Distance of the mass's centroid from r.
    plain : tuple
        Gradients of the box itself.
    """
    by = 1.0 / r
    w, g = weights(shape, half, f)
    first, ends = moments(shape, half, f, g)
    return (
        plus_scaled(by, first, w),
        plus_scaled(by, ends, g),
        scaled(by, w),
        half * half * (1.0 / 3.0) * by,
        g,
    )


@inlined
def ring_motion(frame, particles, four, hoop, u):
    """Velocities at which four particles' positions move.

    Parameters
    ----------
    frame, particles, four
        See `Frame`, `Particles`, `FourParticles`.
    hoop : tuple of 2 Vec4 or ()
        Sums of T times velocities.
    u : tuple of D Vec4
        The grid's velocities at their centroids; returned outside of axisymmetry.
    """
    if not is_axial(frame):
        return u
    return scaled(coordinates(frame, particles, four.rows)[0], hoop)
