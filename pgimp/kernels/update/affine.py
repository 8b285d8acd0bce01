"""Affine transfer: the velocity gradient that particles carry.

A particle keeps its velocity gradient L_p (30), moved with its material. It gives the vertices
m_p (v_p + L_p (x_v - x_p)) S_vp instead of m_p v_p S_vp (22).

Where a face or a constraint holds a vertex, the gradient includes the jump from the material's
velocity to the prescribed one. The particle's own velocity does not include that jump, since (27)
adds accelerations, which are prescribed at held vertices as well. Extrapolated from the particle,
the jump would reach free vertices as unbalanced momentum. That is spurious kinetic energy, up to a
third of the total on coarse grids, for any step. So a particle that reaches a held vertex does not
carry the gradients of the components held there; its deformation (29) has them all.
"""

from math import isqrt, sqrt

from pgimp.jit.algebra import inverse, multiply, one_plus
from pgimp.jit.kernel import inlined, is_empty
from pgimp.jit.tuples import scaled, squared, three
from pgimp.jit.vectors.simd import pack, where
from pgimp.kernels.grid.constraint_flags import held_codes
from pgimp.kernels.transfer.lane_io import put_row


@inlined
def affine_momentum(affine, frame, particles, p):
    """Gradient of a particle's momentum: m_p dv/dx_i for each direction; () without any.

    With it, a vertex gets m_p (v_p + L_p (x_v - x_p)) S_vp. The particle's momentum remains, since
    the arms' weighted sum is zero, and linear fields are transferred exactly up to the surface.
    """
    if is_empty(affine):
        return ()
    D, m, L = len(frame.origin), particles.m[p], particles.L
    columns = tuple(tuple(m * L[p, D * j + i] for j in range(D)) for i in range(D))
    return tuple(pack(0.0, *three(column)) for column in columns)


@inlined
def when_moved(affine, dt, L):
    """Gradients L of four particles at the end of the step, L (1 + dt L)^-1, but no greater.

    The field moves with its own velocity. The gradient is by the material's positions at the end,
    dx' = (1 + dt L) dx, as for the next step's vertices.

    Compression alone makes the gradient greater, as if nothing resisted it. That increase is not
    followed, for the resistance is at work only in the next step. A particle that vibrates freely
    would be turned inside out. So a result that exceeds the Frobenius norm of L is scaled to it.
    """
    if is_empty(affine):
        return L
    after = multiply(L, inverse(one_plus(dt, L)))
    most, found = squared(L), squared(after)
    return scaled(where(found > most, sqrt(most / found), 1.0), after)


@inlined
def keep_gradients(affine, particles, rows, L, held):
    """Store the velocity gradients L that four particles carry, if they carry any.

    `held` is from `take_from_grid`.
    """
    if is_empty(affine):
        return None
    D = isqrt(len(L))
    free = tuple(_free(held, d) for d in range(D))
    kept = tuple(free[min(k // D, D - 1)] * each for k, each in enumerate(L))
    put_row(particles.L, rows, 0, kept)


@inlined
def _free(held, d):
    """1 for each of four particles without held component `d` at a vertex in reach, else 0.

    The greatest of the codes in a particle's reach decides, see `also_held`. A particle that
    reaches vertices of two walls also reaches their edge, which holds several components (except an
    edge that a separating wall has released).
    """
    low, high = held_codes(d)
    one = where(held > high, 1.0, where(held > low, 0.0, 1.0))
    return where(held > held_codes(3)[0], 0.0, one)
