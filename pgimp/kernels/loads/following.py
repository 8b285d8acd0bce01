"""Deformation gradient by positions, which areas of loaded surfaces follow.

F of particles that a free surface cuts is integrated from rates, and falls behind their motion.
Positions are right. So every few steps the displacement u = x_p - X_p is summed at the vertices,

    u_v = sum_p m_p S_vp (u_p + G_p (x_v - x_p))/sum_p m_p S_vp,    G_p = sum_v grad S_vp u_v,

with the gradient G_p from the time before. Where u is linear in space the true gradient is a fixed
point of this, up to free surfaces. Then (1 - G_p)^-1 is the deformation gradient. Particles store
it as R_p, with (1 - G_p)^-1 = R_p F_p. Between two sums it therefore moves with F_p.

In axisymmetry the hoop's stretch is x_p/X_p along the radius. In plane stress that of the thickness
is F's.
"""

from math import isqrt
from typing import NamedTuple

from pgimp.jit.algebra import determinant, inverse, multiply, one_plus
from pgimp.jit.kernel import inlined, inner_kernel, is_empty, kernel
from pgimp.jit.tuples import read, scaled, squared, three, write
from pgimp.jit.vectors.lanes import zeros
from pgimp.jit.vectors.simd import lane, pack, stack
from pgimp.kernels.data.record import MASS, MOMENTUM, RECORD
from pgimp.kernels.data.used_rows import is_used
from pgimp.kernels.data.velocity_fields import field_count, field_size
from pgimp.kernels.sums.sums import unwrapped
from pgimp.kernels.transfer.first_vertex import (
    deformation,
    half_widths,
    is_axial,
    is_initial,
    off_axis,
)
from pgimp.kernels.transfer.gather import gather
from pgimp.kernels.transfer.lane_io import LANES, four_rows
from pgimp.kernels.transfer.scatter import Share
from pgimp.kernels.transfer.supports import SUPPORT_SIZE, first_offset, supports
from pgimp.kernels.transfer.transfer import Support

#: Least determinant and greatest squared norm of R_p^-1 that count; else the surface follows F_p.
_MIN_DETERMINANT, _MAX_SQUARE = 0.05, 25.0


class DisplacementSums(NamedTuple):
    """Sums of displacements, in place of mass and momentum; see `Quantity`."""

    @staticmethod
    def supports(quantity, shape, frame, window, particles, rows, layer, buffer):
        """See `Quantity`; with arms for the gradient of u."""
        supports(shape, frame, window, particles, rows, layer, buffer, 1.0)

    @staticmethod
    def share(quantity, shape, frame, particles, p):
        """(m, m u) of a particle, and the gradient of m u; see `Quantity`.

        Of rings u is at the centroid, from which arms are counted.
        """
        m, G = particles.m[p], _carried_gradient(frame, particles, p)
        x = m * _displacement(frame, particles, p, 0)
        y = m * _displacement(frame, particles, p, 1)
        z = m * _displacement(frame, particles, p, 2)
        if is_axial(frame):
            half = half_widths(shape, frame, particles, p)[0] * frame.cell[0]
            arm = half * half / (3.0 * off_axis(frame, (particles.x[p, 0],))[0])
            x, y = x + arm * G[0], y + arm * G[2]
        return Share(pack(m, x, y, z), (), zeros(frame.origin), _columns(G), (), ())


@inner_kernel
def _displacement(frame, particles, p, d):
    """Displacement since the undeformed state along `d`; 0 where there is no such direction."""
    if d < len(frame.origin):
        return unwrapped(frame, particles, p, d) - particles.place[p, d]
    return 0.0


@inner_kernel
def _carried_gradient(frame, particles, p):
    """Displacement gradient G_p that particle `p` has from the time before, times its mass."""
    F = deformation(frame, particles, p)
    F = multiply(read(particles.surface_F_correction, p, 0, F), F)
    return scaled(particles.m[p], one_plus(-1.0, inverse(_plane(F, frame.origin))))


@inlined
def _plane(F, D):
    """The part of a matrix in the directions of the scene; `D` has one entry each."""
    n = len(D) ** 2
    return F[:n]


@inlined
def _columns(G):
    """Columns of a matrix, as vectors (0, column)."""
    D = isqrt(len(G))
    return tuple(pack(0.0, *three(G[d::D])) for d in range(D))


@kernel
def find_displacements(field):
    """Divide the sums of displacements at the vertices by their masses."""
    window, G = field.window, field.G
    for i in range(len(field.active)):
        for f in range(field_count(window)):
            if field.active[i] == 0 or not is_used(field, i, f):
                continue
            first = i * window.stride[0] + f * field_size(window)
            for r in range(first, first + field_size(window), RECORD):
                part = 1.0 / G[r + MASS] if G[r + MASS] > 0.0 else 0.0
                for d in range(3):
                    G[r + MOMENTUM + d] *= part


@inlined
def _gradient(slopes):
    """Displacement gradient, row by row, of gathered vectors (., du_x, du_y, du_z) by direction."""
    return tuple(lane(each, 1 + i) for i in range(len(slopes)) for each in slopes)


@inlined
def _with_hoop(frame, particles, p, F, R):
    """The matrix R in the scene's directions with the out-of-plane entry that F has, if any."""
    if len(F) == len(R):
        return R
    if not is_axial(frame):
        return (*R, 1.0)
    return (*R, particles.x[p, 0] / (particles.place[p, 0] * F[4]))


@inner_kernel
def _is_loaded(particles, p):
    """1 if particle `p` has a part of a loaded surface, else 0."""
    for c in range(particles.surface.shape[1]):
        if particles.surface[p, c] != 0.0:
            return 1
    return 0


@kernel
def find_surface_corrections(setting, field, particles, order, identity) -> int:
    """Find R_p from the displacements at the vertices.

    Parameters
    ----------
    setting, field, particles, order
        See `KernelScene`, `Field`, `Particles`, `Order`; the field is from `find_displacements`.
    identity : tuple of float
        The matrix 1.

    Returns
    -------
    int
        Number of particles at a loaded surface that follow F_p alone: their R_p does not count.
    """
    fallbacks = 0
    shape, frame, window, start = setting.shape, setting.frame, field.window, order.start
    buffer = stack(SUPPORT_SIZE)
    for layer in range(len(start) - 1):
        for k in range(start[layer], start[layer + 1], LANES):
            rows = four_rows(order.rows, k, start[layer + 1])
            number = layer + window.lower[0]
            supports(shape, frame, window, particles, rows, number, buffer, ())
            for j in range(min(LANES, start[layer + 1] - k)):
                p = order.rows[k + j]
                at = layer * window.stride[0] + first_offset(buffer, j)
                slopes = gather(
                    shape, field.G, Support(buffer, j), at, window.stride, frame.origin, (), ()
                )[2]
                F = deformation(frame, particles, p)
                back = multiply(_plane(F, frame.origin), one_plus(-1.0, _gradient(slopes)))
                R = identity
                if squared(back) < _MAX_SQUARE and determinant(back) > _MIN_DETERMINANT:
                    R = _with_hoop(frame, particles, p, F, inverse(back))
                else:
                    fallbacks += _is_loaded(particles, p)
                write(particles.surface_F_correction, p, 0, R)
    return fallbacks


@inlined
def surface_F(corrected, frame, particles, p):
    """Deformation gradient that loaded surfaces follow: R_p F_p, with () for `corrected` F_p."""
    if is_empty(corrected) or is_initial(frame):
        return deformation(frame, particles, p)
    F = deformation(frame, particles, p)
    return multiply(read(particles.surface_F_correction, p, 0, F), F)
