"""Particles of the two configurations in one order, as separate lists."""

from pgimp.jit.kernel import kernel


@kernel
def split_order(lagrangian, body, rows, start, rank_in_order, ends):
    """Split the particles of a rank by the configuration of their body.

    Parameters
    ----------
    lagrangian : (bodies,) bool
        Mask of the bodies in the initial configuration.
    body : (capacity,) int
        The particles' bodies.
    rows, start
        See `Order`.
    rank_in_order : (2, n) int32
        Filled with the offsets in `rows`: of particles in the current configuration, then in the
        initial one.
    ends : (2, layers + 1) int64
        Set to the beginning of each layer in them.
    """
    found, more = 0, 0
    for layer in range(len(start) - 1):
        ends[0, layer], ends[1, layer] = found, more
        for k in range(start[layer], start[layer + 1]):
            if lagrangian[body[rows[k]]]:
                rank_in_order[1, more] = k
                more += 1
            else:
                rank_in_order[0, found] = k
                found += 1
    ends[0, len(start) - 1], ends[1, len(start) - 1] = found, more
