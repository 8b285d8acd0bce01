"""Relaxation of null modes in soil: velocities of particles without effect on any vertex.

Particles keep, by (27), the part of their velocity that is finer than a cell. It exerts no force,
strains nothing, and is never lost: a heap at rest still has kinetic energy in its books.

In loose soil and grains it is relaxed, at the rate CALM c/h, to the field of the vertices

    w_v = sum_p m_p S_vp v_p/sum_p m_p S_vp,    v_p += part (sum_v S_vp w_v - v_p).

Both are taken at the step's beginning. The sums are accumulated with `filling`, every few steps,
over one body (without contact, over all such bodies of a material). So walls, contact and other
bodies have no part in it. Momentum is conserved; angular momentum is conserved inside, and lost at
surfaces that turn. Let P be the map of v to sum_v S_vp w_v; its eigenvalues in the mass-weighted
product are from 0 to 1. A mode loses energy at the rate 2 CALM (1 - P) c/h. No mode gains any, and
long waves lose next to none. The loss is booked as dissipated energy, like all losses of a method.

Constrained particles move as prescribed, and have no part in it either.
"""

from typing import NamedTuple

from pgimp.jit.kernel import inlined, inner_kernel, is_record
from pgimp.jit.tuples import plus_first
from pgimp.jit.vectors.rows import transpose
from pgimp.jit.vectors.simd import lane, load, pack, store
from pgimp.kernels.data.particles import FloatArray
from pgimp.kernels.data.used_rows import is_used

#: Entries of a vertex's record: mass of relaxed particles, and momentum in three components; after
#: that momentum over mass.
WEIGHT, MOTION = 4, 5


class Calming(NamedTuple):
    """Relaxed bodies."""

    #: (bodies,) float64: Part of the null-mode velocity lost by each body; 0 for other bodies.
    part: FloatArray


@inner_kernel
def part_of(calming, particles, p):
    """Part of the velocity of particle `p` that is relaxed; 0 for a constrained one."""
    if particles.constraint.shape[1] > 0 and particles.constraint[p, 0] > 0:
        return 0.0
    return calming.part[particles.body[p]]


@inlined
def motion_share(calming, frame, particles, p):
    """The vector (m, m v) of a relaxed particle, zero for others; () without any."""
    if not is_record(calming):
        return ()
    D = len(frame.origin)
    if not part_of(calming, particles, p) > 0.0:
        return pack(0.0, 0.0, 0.0, 0.0)
    m, v = particles.m[p], particles.v
    y = v[p, 1] if D > 1 else 0.0
    z = v[p, 2] if D > 2 else 0.0
    return pack(m, m * v[p, 0], m * y, m * z)


@inlined
def find_motion(calming, field, i, first, count, size):
    """Turn momenta at a vertex of plane `i`, whose first record is at `first`, into velocities."""
    if not is_record(calming):
        return None
    G = field.G
    for f in range(count):
        if is_used(field, i, f):
            r = first + f * size
            inverse = 1.0 / G[r + WEIGHT] if G[r + WEIGHT] > 0.0 else 0.0
            for d in range(3):
                G[r + MOTION + d] *= inverse


@inlined
def keep_gain(calming, frame, particles, p, A, scratch, offset):
    """Store the velocity gain of particle `p` at `offset`; `A` is its gathered (1, w)."""
    if not is_record(calming):
        return None
    D = len(frame.origin)
    part, v = part_of(calming, particles, p), particles.v
    y = part * (lane(A, 2) - v[p, 1]) if D > 1 else 0.0
    z = part * (lane(A, 3) - v[p, 2]) if D > 2 else 0.0
    store(scratch, offset, pack(part * (lane(A, 1) - v[p, 0]), y, z, 0.0))


@inlined
def with_gains(calming, v, scratch, offset):
    """Velocities v of four particles with the gains that `keep_gain` stored from `offset` on."""
    if not is_record(calming):
        return v
    gain = transpose(
        load(scratch, offset),
        load(scratch, offset + 4),
        load(scratch, offset + 8),
        load(scratch, offset + 12),
    )
    return plus_first(v, gain)
