"""Supports of cut boxes of particles at their current positions.

For contact of bodies in the initial configuration, as `pgimp.kernels.contact.volumes` in the
current one.
"""

from pgimp.jit.kernel import kernel, specialise
from pgimp.jit.tuples import read
from pgimp.kernels.contact.lagrangian.supports import keep_values
from pgimp.kernels.contact.volumes import LEAST, cut_weights


def _narrow(shape, frame, half, x, offset, supports, i, d):
    """Set the weights of a cut box in support `i`, along the directions from `d` on."""


@specialise(_narrow)
def _narrow_along(shape, frame, half, x, offset, supports, i, d):
    def last(shape, frame, half, x, offset, supports, i, d):
        inverse, first = frame.inverse[d], supports.first[i, d]
        f = (x[0] + offset[0] - frame.origin[d]) * inverse - (first - frame.ghost)
        values, slopes = cut_weights(shape, max(half[0] - abs(offset[0]) * inverse, LEAST), f)
        keep_values(supports.w[i, d], 0, values)
        keep_values(supports.g[i, d], 0, slopes)

    def more(shape, frame, half, x, offset, supports, i, d):
        _narrow(shape, frame, half[:1], x[:1], offset[:1], supports, i, d)
        _narrow(shape, frame, half[1:], x[1:], offset[1:], supports, i, d + 1)

    return last if len(x) == 1 else more


@kernel
def narrow_supports(shape, frame, table, motion, whole, supports):
    """Set the supports of cut boxes; uncut particles keep their whole supports.

    Parameters
    ----------
    table, motion : (n,) NEAR_PARTICLE, (n,) NEAR_MOTION
        Particles at their current positions.
    whole : Supports
        Supports of their whole boxes.
    supports : Supports
        Set, except `at`.
    """
    zero = frame.origin
    for i in range(len(table)):
        row = table[i]
        for d in range(3):
            supports.first[i, d] = whole.first[i, d]
            for k in range(4):
                supports.w[i, d, k], supports.g[i, d, k] = whole.w[i, d, k], whole.g[i, d, k]
        if row.cut != 0:
            half, x = read(table.half_width, i, 0, zero), read(motion.position, i, 0, zero)
            offset = read(motion.centroid_offset, i, 0, zero)
            _narrow(shape, frame, half, x, offset, supports, i, 0)
