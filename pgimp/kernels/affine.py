"""Affine transfer: what particles carry of the velocity's variation in space.

A particle keeps the velocity gradient L_p that it has seen (30), and gives the vertices
m_p (v_p + L_p (x_v - x_p)) S_vp instead of m_p v_p S_vp (22).

Where a face or a constraint holds a vertex, the gradient includes the jump from the material's
velocity to the prescribed one. The particle's own velocity knows nothing of that jump, since (27)
adds accelerations, and those of held vertices are prescribed as well. Extrapolated from the
particle, the jump would reach free vertices as momentum that nothing balances: kinetic energy from
nothing, up to a third of the total on coarse grids, whatever the step. So a particle that reaches
a held vertex does not carry the gradients of the components that are held there; its deformation
(29) has them all.
"""

from math import isqrt

from pgimp.kernels.batch import entry, extent, first_place, put_row
from pgimp.kernels.gathered import held_weights
from pgimp.kernels.grips import FIRM
from pgimp.kernels.jit import kernel, specialise
from pgimp.kernels.simd import bits, pack
from pgimp.kernels.transfer import HELD
from pgimp.kernels.tuples import scaled


def slopes(affine, frame, particles, p):
    """How a particle's momentum varies in space: m_p dv/dx_i for each direction; () if it does not.

    With it, a vertex gets m_p (v_p + L_p (x_v - x_p)) S_vp. The particle's momentum remains, since
    the arms' weighted sum is zero, and fields that are linear arrive as they are up to the surface.
    """


@specialise(slopes)
def _slopes(affine, frame, particles, p):
    D = len(frame.types[0])
    if hasattr(affine, "count"):  # ()
        return lambda affine, frame, particles, p: ()

    def slopes1(affine, frame, particles, p):
        return (pack(0.0, particles.m[p] * particles.L[p, 0], 0.0, 0.0),)

    def slopes2(affine, frame, particles, p):
        m, L = particles.m[p], particles.L
        return (
            pack(0.0, m * L[p, 0], m * L[p, 2], 0.0),
            pack(0.0, m * L[p, 1], m * L[p, 3], 0.0),
        )

    def slopes3(affine, frame, particles, p):
        m, L = particles.m[p], particles.L
        return (
            pack(0.0, m * L[p, 0], m * L[p, 3], m * L[p, 6]),
            pack(0.0, m * L[p, 1], m * L[p, 4], m * L[p, 7]),
            pack(0.0, m * L[p, 2], m * L[p, 5], m * L[p, 8]),
        )

    return (slopes1, slopes2, slopes3)[D - 1]


def keep_gradients(affine, shape, G, room, sums, begin, stride, particles, rows, L):
    """Let four particles keep the velocity gradients L that they carry, where they carry any.

    Parameters
    ----------
    room, sums
        The batch's supports, and what `gather` gave for it.
    begin : int
        Place of the layer's first plane in `G`.
    """


@specialise(keep_gradients)
def _keep_gradients(affine, shape, G, room, sums, begin, stride, particles, rows, L):
    if hasattr(affine, "count"):  # ()
        return lambda affine, shape, G, room, sums, begin, stride, particles, rows, L: None

    def keep(affine, shape, G, room, sums, begin, stride, particles, rows, L):
        touching = bits(held_weights(sums) > FIRM)
        if touching != 0:
            held = (
                _held(touching & 1, shape, G, room, 0, begin, stride, L),
                _held(touching & 2, shape, G, room, 1, begin, stride, L),
                _held(touching & 4, shape, G, room, 2, begin, stride, L),
                _held(touching & 8, shape, G, room, 3, begin, stride, L),
            )
            put_row(particles.L, rows, 0, _free(held, L))
        else:
            put_row(particles.L, rows, 0, L)

    return keep


def _held(touching, shape, G, room, j, begin, stride, L):
    """Components held at the vertices that particle `j` of a batch reaches: bit d is set."""


@specialise(_held)
def _held_any(touching, shape, G, room, j, begin, stride, L):
    like = (0,) * isqrt(len(L))

    def held(touching, shape, G, room, j, begin, stride, L):
        if touching == 0:
            return 0
        return _held_along(shape, G, room, j, 0, begin + first_place(room, j), stride, like)

    return held


def _held_along(shape, G, room, j, d, place, stride, like):
    """Likewise along as many directions from `d` on as `like` has, from the vertex at `place`."""


@specialise(_held_along)
def _held_line(shape, G, room, j, d, place, stride, like):
    if len(like) == 0:
        return lambda shape, G, room, j, d, place, stride, like: int(G[place + HELD])

    def line(shape, G, room, j, d, place, stride, like):
        held = 0
        for i in range(extent(shape, room, d, j)):
            if entry(room, d, 0, i, j) >= FIRM:
                at = place + i * stride[0]
                held |= _held_along(shape, G, room, j, d + 1, at, stride[1:], like[1:])
        return held

    return line


def _free(held, L):
    """Gradients of four particles, zero in the rows of the components that are held."""


@specialise(_free)
def _free_rows(held, L):
    if len(L) == 1:
        return lambda held, L: scaled(_unheld(held, 0), L)
    if len(L) == 4:
        return lambda held, L: (
            *scaled(_unheld(held, 0), L[:2]), *scaled(_unheld(held, 1), L[2:]),
        )  # fmt: skip
    return lambda held, L: (
        *scaled(_unheld(held, 0), L[:3]), *scaled(_unheld(held, 1), L[3:6]),
        *scaled(_unheld(held, 2), L[6:]),
    )  # fmt: skip


@kernel
def _unheld(held, d):
    """1 for those of four particles whose component `d` is free, 0 for the others."""
    return pack(
        1.0 - (held[0] >> d & 1), 1.0 - (held[1] >> d & 1),
        1.0 - (held[2] >> d & 1), 1.0 - (held[3] >> d & 1),
    )  # fmt: skip
