"""Mean dilatation by box overlap (``method.volumetric: mean``), against locking.

Nearly incompressible particles lock: each must keep its own volume, for which the vertices have too
few degrees of freedom. Here a cell has one rate of dilatation D_c, the mean divergence of the
multilinear velocity field of its corners. A particle has the mean rate of its cells, weighted with
the parts phi_cp of its box in them:

    D_p = sum_c phi_cp D_c,    L_p <- L_p + (D_p - tr L_p)/d 1,

after Nagtegaal, Parks and Rice (1974) and Hughes (1980), with d the number of directions (in plane
strain the correction lies in the plane; in axisymmetry d is 3). The force is the adjoint. The
stress less the mean of its d normal components acts through grad S_vp as before, the mean less the
viscous pressure through dD_p/dv_v. So the power of the forces on the vertices is the power of the
stresses, V_p sigma : L_p.

This needs neither sums over cells nor messages: parts in cells, and means over them, are products
by direction. Along one direction, a box's gradient g_i at vertex i is the mean over the box of the
tent's. So the parts are minus the sums of the gradients so far, times the cell's size L. A vertex
has half of each of the two parts beside it:

    phi_i = -L (g_0 + ... + g_i),    a_i = (phi_{i-1} + phi_i)/2.

Then dD_p/dv_v is grad S_vp with a in place of the weights of the other directions. The a of a
particle add up to one and its g to zero. So D_p of an affine field is its trace, and a particle's
forces have neither a sum nor a moment. The support is the support of S_vp.

An isolated particle shares its cells with no other, and its vertices have hardly any mass: in 3D it
would need steps several times shorter. The mass of the vertices around a particle is sum_v S_vp m_v
over its density and the cell's volume. It is 1 inside bodies, at least 0.6 at a plane surface, and
0.6^d in a corner. With two particles a cell and direction it is 0.4^d or less for an isolated one.
From `DENSE`^d down to `SPARSE`^d its rate becomes the rate at its own position. This holds from the
next step on, in the forces as in the deformation.

Under gravity liquids are always taken as isolated. With the means of cells they would compact, in
motions of the vertices that change no mean, and sink.
"""

from math import pi

from pgimp.jit.algebra import plus_diagonal, trace
from pgimp.jit.kernel import inlined, is_array, is_empty
from pgimp.jit.vectors.rows import transpose
from pgimp.jit.vectors.simd import load, pack, store, vector
from pgimp.kernels.transfer.first_vertex import is_axial, off_axis
from pgimp.kernels.transfer.lane_io import put_row, take, take_row
from pgimp.kernels.transfer.mean_dilatation_weights import GATHERED_RATES
from pgimp.kernels.transfer.transpose import gathered_mass
from pgimp.kernels.update.viscosity import viscous_pressure

#: d-th roots of the filled part from which a particle counts as not isolated, and as isolated.
DENSE, SPARSE = 0.58, 0.45


@inlined
def _average(particles, p, frame):
    """Mean of the normal components of the stress of particle `p` that do work."""
    if len(frame.origin) == 2 and not is_axial(frame):
        return 0.5 * (particles.sigma[p, 0] + particles.sigma[p, 1])
    return (particles.sigma[p, 0] + particles.sigma[p, 1] + particles.sigma[p, 2]) * (1.0 / 3.0)


@inlined
def set_apart(loads, frame, particles, p):
    """The normal stress of particle `p` that does not act through grad S_vp.

    It is the viscous pressure (45), which opposes it; with mean dilatation the one of `mean_force`.
    """
    if is_empty(loads.mean):
        return viscous_pressure(loads.viscosity, particles, p)
    s, isolation = _average(particles, p, frame), particles.isolation[p, 0]
    return s - isolation * (s - viscous_pressure(loads.viscosity, particles, p))


@inlined
def mean_force(loads, frame, particles, p):
    """-V_p (mean sigma - q_p) of particle `p`, which dD_p/dv_v turns into forces; () without.

    For an isolated particle, a part of it.
    """
    if is_empty(loads.mean):
        return ()
    third = float(len(frame.origin) == 3)
    q = viscous_pressure(loads.viscosity, particles, p)
    V = particles.V[p] * (particles.isolation[p, 0] - 1.0)
    f = V * (_average(particles, p, frame) - q)
    return pack(0.0, f, f, third * f)


@inlined
def with_means(mean, frame, particles, rows, buffer, sums, count, L):
    """Velocity gradients of four particles, as gathered, with the cells' rates as their traces.

    Sets the particles' isolation, for the next step.

    Parameters
    ----------
    frame, particles, rows
        See `Frame`, `Particles`; the four rows.
    buffer, sums
        As filled by `keep_rates` and `keep_sums`.
    count : int
        Particles, up to four; the last one replaces missing ones.
    L : tuple of D*D Vec4
        Row-major, as gathered.
    """
    if is_empty(mean):
        return L
    D, part = (3 if len(L) == 9 else 2), (0.5 if len(L) == 4 else 1.0 / 3)
    dense, sparse = DENSE**D, SPARSE**D
    isolation = take_row(particles.isolation, rows, 0, (0.0,))[0]
    e = part * (1.0 - isolation) * (_rates(buffer, count, frame.origin) - trace(L))
    reached = gathered_mass(sums) * take(particles.V, rows)
    for d in range(D):
        reached = reached * frame.inverse[d]
    reached = section(frame, particles.x, rows, reached)
    fill = reached / take(particles.m, rows)
    now = min(max((dense - fill) * (1.0 / (dense - sparse)), 0.0), 1.0)
    now = max(now, _always_alone(mean, particles, rows))
    put_row(particles.isolation, rows, 0, (now,))
    return plus_diagonal(L, e)


@inlined
def section(frame, x, rows, V):
    """Sections of four volumes V of rings at `x`; outside of axisymmetry V itself."""
    if not is_axial(frame):
        return V
    return V / (2.0 * pi * off_axis(frame, take_row(x, rows, 0, frame.origin))[0])


@inlined
def _always_alone(mean, particles, rows):
    """1 for each of four particles that always has the rate at its position, else 0."""
    if is_array(mean):
        return pack(*tuple(mean[particles.body[rows[j]]] for j in range(4)))
    return vector(0.0)


@inlined
def _rates(buffer, count, like):
    """D_p of four particles; `like` has an entry for each direction."""
    third = float(len(like) == 3)
    for j in range(count, 4):
        store(buffer, GATHERED_RATES + 4 * j, load(buffer, GATHERED_RATES + 4 * (count - 1)))
    rate = transpose(*tuple(load(buffer, GATHERED_RATES + 4 * j) for j in range(4)))
    return rate[1] + rate[2] + third * rate[3]
