"""Velocities of soil that no vertex sees, which fade: what else would not come to rest.

Particles keep, by (27), the part of their velocity that is finer than a cell. It exerts no force,
strains nothing, and so is never lost: a heap that has come to rest is still at work by its books.

In loose soil and grains it is relaxed, at the rate CALM c/h, to the field of the vertices

    w_v = sum_p m_p S_vp v_p/sum_p m_p S_vp,    v_p += part (sum_v S_vp w_v - v_p).

Both are of the step's beginning. The sums are those of `filling`, every few steps, over the
particles of one body alone (without contact, of all such bodies of a material): so walls, contact
and other bodies have no part in it, and momentum stays as it is; angular momentum does inside, and
is lost by surfaces that turn. With P the map of v to
sum_v S_vp w_v, whose eigenvalues in the product of the masses are from 0 to 1, a mode loses energy
at the rate 2 CALM (1 - P) c/h: none gains any, and long waves lose next to none. What is lost is
dissipated energy, as all that a method loses.

Particles that a constraint holds move as prescribed, and have no part in it either.
"""

from typing import NamedTuple

from pgimp.jit.kernel import inner_kernel, specialise
from pgimp.jit.tuples import plus_first
from pgimp.jit.vectors.rows import transpose
from pgimp.jit.vectors.simd import lane, load, pack, store
from pgimp.kernels.data.particles import FloatArray
from pgimp.kernels.data.velocity_fields import is_used

#: Entries of a vertex's record: mass of what is calmed, and momentum in three components; after
#: that momentum over mass.
WEIGHT, MOTION = 4, 5


class Calming(NamedTuple):
    """Which bodies are calmed.

    Attributes
    ----------
    part : (bodies,) float64
        Part of what no vertex sees that velocities lose; 0 for other bodies.
    """

    part: FloatArray


@inner_kernel
def part_of(calming, particles, p):
    """Part of the velocity of particle `p` that is relaxed; 0 for one that a constraint holds."""
    if particles.constraint.shape[1] > 0 and particles.constraint[p, 0] > 0:
        return 0.0
    return calming.part[particles.body[p]]


def motion_share(calming, frame, particles, p):
    """The vector (m, m v) of a particle that is calmed, zero for others; () without any."""


@specialise(motion_share)
def _motion_share(calming, frame, particles, p):
    if not hasattr(calming, "instance_class"):  # ()
        return lambda calming, frame, particles, p: ()
    D = len(frame.types[0])

    def share(calming, frame, particles, p):
        if not part_of(calming, particles, p) > 0.0:
            return pack(0.0, 0.0, 0.0, 0.0)
        m, v = particles.m[p], particles.v
        y = v[p, 1] if D > 1 else 0.0
        z = v[p, 2] if D > 2 else 0.0
        return pack(m, m * v[p, 0], m * y, m * z)

    return share


def find_motion(calming, field, i, first, count, size):
    """Turn momenta at a vertex of plane `i`, whose first record is at `first`, into velocities."""


@specialise(find_motion)
def _find_motion(calming, field, i, first, count, size):
    if not hasattr(calming, "instance_class"):  # ()
        return lambda calming, field, i, first, count, size: None

    def find(calming, field, i, first, count, size):
        G = field.G
        for f in range(count):
            if is_used(field, i, f):
                r = first + f * size
                inverse = 1.0 / G[r + WEIGHT] if G[r + WEIGHT] > 0.0 else 0.0
                for d in range(3):
                    G[r + MOTION + d] *= inverse

    return find


def keep_gain(calming, frame, particles, p, A, scratch, place):
    """Store at a `place` what the velocity of particle `p` gains; `A` is what it sees of (1, w)."""


@specialise(keep_gain)
def _keep_gain(calming, frame, particles, p, A, scratch, place):
    if not hasattr(calming, "instance_class"):  # ()
        return lambda calming, frame, particles, p, A, scratch, place: None
    D = len(frame.types[0])

    def keep(calming, frame, particles, p, A, scratch, place):
        part, v = part_of(calming, particles, p), particles.v
        y = part * (lane(A, 2) - v[p, 1]) if D > 1 else 0.0
        z = part * (lane(A, 3) - v[p, 2]) if D > 2 else 0.0
        store(scratch, place, pack(part * (lane(A, 1) - v[p, 0]), y, z, 0.0))

    return keep


def with_gains(calming, v, scratch, place):
    """Velocities v of four particles with what `keep_gain` has stored from `place` on."""


@specialise(with_gains)
def _with_gains(calming, v, scratch, place):
    if not hasattr(calming, "instance_class"):  # ()
        return lambda calming, v, scratch, place: v

    def gained(calming, v, scratch, place):
        gain = transpose(
            load(scratch, place), load(scratch, place + 4), load(scratch, place + 8),
            load(scratch, place + 12),
        )  # fmt: skip
        return plus_first(v, gain)

    return gained
