"""Filled part of a vertex's neighbourhood, where bodies flow; `refill` corrects the particles.

The J of liquids, of grains and of loose soil is integrated from rates, and nothing ties it to the
space of the particles. In motion both drift apart: particles crowd, and the flow sinks. So every
few steps volumes are summed at the vertices, V_v = sum_p S_vp V_p. With the part V_c of the
neighbourhood within the walls, phi_v = V_v/V_c. Where it is overfull, particles are shifted down
the gradient of the excess:

    x_p -= eps c h t sum_v grad S_vp max(phi_v - 1, 0),

with the wave speed c and the time t since the last shift. Calm bodies fill their space and are not
shifted; free surfaces, phi < 1, are not pushed. Velocities do not change. Lind et al. (J. Comput.
Phys. 231, 2012) shift the particles of SPH likewise, down the gradient of concentration.

J also gathers null modes, noise finer than a cell, which exert no force on any vertex and are
therefore never removed. In liquids and grains J is relaxed, at the rate delta c/h, to the field of
the vertices,

    J_v = sum_p m_p S_vp (J_p + g_p . (x_v - x_p))/sum_p m_p S_vp,    g_p = sum_v grad S_vp J_v.

That is exact for linear fields, so that hydrostatic pressure does not change.

Voids close at the rate eps c/h. In overfull neighbourhoods J of liquids and grains is reduced
towards 1.01; in full ones the opening gap of loose soil is reduced. Both are without stress, so
that nothing else changes. Otherwise soil that was torn apart in motion would come to rest with
excess volume.
"""

from typing import NamedTuple

from pgimp.jit.algebra import determinant
from pgimp.jit.kernel import inlined, inner_kernel, is_record, kernel
from pgimp.jit.tuples import read, scaled
from pgimp.jit.vectors.lanes import zeros
from pgimp.jit.vectors.simd import pack
from pgimp.kernels.contact.fill import fill
from pgimp.kernels.data.frame import Window
from pgimp.kernels.data.particles import FloatArray, IntArray
from pgimp.kernels.data.used_rows import is_used, use
from pgimp.kernels.data.velocity_fields import field_count, field_size
from pgimp.kernels.flows.calming import Calming, find_motion, motion_share
from pgimp.kernels.transfer.first_vertex import deformation
from pgimp.kernels.transfer.scatter import Share
from pgimp.kernels.transfer.supports import supports

#: Entries of a vertex's record during the sums: volume of all bodies; mass of the bodies with
#: relaxed J, and this mass times J.
VOLUME, MASS, RATIO = 0, 1, 2

#: Entries after that: max(phi - 1, 0), J_v, phi - 1, and max(phi - 1, 0)/phi.
EXCESS, FIELD, SURPLUS, OVERLAP = 0, 1, 2, 3

#: Those that images have beyond walls, as bits.
REFLECTED = 1 << EXCESS | 1 << SURPLUS | 1 << OVERLAP


class FillingSums(NamedTuple):
    """Sums of the filling, in place of mass and momentum; see `Quantity`."""

    #: (bodies,) float64: The greatest J without voids where J is relaxed; 0 for other bodies, which
    #: only fill.
    most: FloatArray
    calming: Calming | tuple[()] = ()  #: Calming or (): See `pgimp.kernels.flows.calming`.

    @staticmethod
    def supports(quantity, shape, frame, window, particles, rows, layer, buffer):
        """See `Quantity`; with arms for the gradient of J."""
        supports(shape, frame, window, particles, rows, layer, buffer, 1.0)

    @staticmethod
    def share(quantity, shape, frame, particles, p):
        """(V, m, m J, 0) of a particle, the gradient of m J, and its motion; see `Quantity`."""
        V, m, J = particles.V0[p], particles.m[p], determinant(deformation(frame, particles, p))
        most = quantity.most[particles.body[p]]
        motion = motion_share(quantity.calming, frame, particles, p)
        nothing, A, C = zeros(frame.origin), pack(V * J, 0.0, 0.0, 0.0), zeros(frame.origin)
        if most > 0.0:
            J = min(J, most)
            A = pack(V * J, m, m * J, 0.0)
            slopes = scaled(m, read(particles.slope, p, 0, frame.origin))
            C = tuple(pack(0.0, 0.0, each, 0.0) for each in slopes)  # at RATIO
        return Share(A, motion, nothing, C, (), ())


class Filling(NamedTuple):
    """The filling for a step's particles; () where nothing flows."""

    due: bool  #: Whether this step uses it.
    window: Window  #: Of the records.
    G: FloatArray  #: (planes * plane,) float64: EXCESS, FIELD, SURPLUS of the vertices, by field.
    shift: FloatArray  #: (bodies,) float64: eps c t/h, 0 for bodies that do not flow.
    #: (bodies,) float64: Part of the difference between J and the vertices' field that J loses.
    relaxed: FloatArray
    #: (bodies,) float64: Part of gaps and of voids that closes in full neighbourhoods.
    closed: FloatArray
    most: FloatArray  #: (bodies,) float64: See `FillingSums`.
    #: (bodies,) int64: Column of the state with the gap of loose soil; -1 for other bodies.
    gap: IntArray
    calming: Calming | tuple[()] = ()  #: Calming or (): Relaxation of velocities.


@kernel
def find_filling(frame, field, walls, rigid_bodies, fills, calming):
    """Turn the sums of `FillingSums` into EXCESS, FIELD and SURPLUS.

    Parameters
    ----------
    frame, field
        See `Frame`, `Field`; the field holds the sums of `FillingSums`, with those beyond walls.
    walls : (6,) bool
        Which faces are walls: the low and the high end of x, y, z.
    rigid_bodies
        RigidBodies or ().
    fills : (rigid bodies,) bool
        Which of them count as filled.
    calming : Calming or ()
        As in the sums.
    """
    window, G, size = field.window, field.G, field_size(field.window)
    volume = 1.0
    for d in range(len(frame.cell)):
        volume *= frame.cell[d]
    for i in range(len(field.active)):
        if field.active[i] == 0:
            continue
        for j in range(window.extent[1]):
            for k in range(window.extent[2]):
                first = i * window.stride[0] + j * window.stride[1] + k * window.stride[2]
                filled = 0.0
                for f in range(field_count(window)):
                    if is_used(field, i, f):
                        filled += G[first + f * size + VOLUME]
                number = (i + window.lower[0], j + window.lower[1], k + window.lower[2])
                sides = _sides(frame, walls, number)
                inside = volume
                for d in range(3):
                    inside *= 1.0 if sides[d] == 0 else 0.5
                surplus = (
                    filled / inside + _rigid_part(rigid_bodies, fills, frame, number, sides) - 1.0
                )
                for f in range(field_count(window)):
                    if is_used(field, i, f):
                        r = first + f * size
                        m = G[r + MASS]
                        G[r + FIELD] = G[r + RATIO] / m if m > 0.0 else 1.0
                        G[r + EXCESS], G[r + SURPLUS] = max(surplus, 0.0), surplus
                        G[r + OVERLAP] = max(surplus, 0.0) / max(1.0 + surplus, 1.0)
                find_motion(calming, field, i, first, field_count(window), size)
        for f in range(field_count(window)):
            if is_used(field, i, f):  # now everywhere
                use(field, i, f * size, (f + 1) * size)


@inner_kernel
def _sides(frame, walls, number):
    """-1 or 1 where a vertex is on a low or a high wall, by direction, else 0."""
    x, y, z = 0, 0, 0
    for d in range(len(frame.cell)):
        side = 0
        if walls[2 * d] and number[d] == frame.ghost:
            side = -1
        elif walls[2 * d + 1] and number[d] == frame.ghost + frame.cells[d]:
            side = 1
        x, y, z = (side if d == 0 else x), (side if d == 1 else y), (side if d == 2 else z)
    return x, y, z


@inlined
def _rigid_part(rigid_bodies, fills, frame, number, sides):
    """Part of a vertex's neighbourhood that rigid bodies fill."""
    if not is_record(rigid_bodies):
        return 0.0
    filled = 0.0
    for t in range(len(rigid_bodies.motion)):
        if fills[t] and fill(rigid_bodies, t, frame, number, sides):
            filled += rigid_bodies.point[0].filled
    return filled
