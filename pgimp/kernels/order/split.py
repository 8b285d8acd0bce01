"""Particles of the two configurations in one order, each a list of its own."""

from pgimp.jit.kernel import kernel


@kernel
def split_order(lagrangian, body, rows, start, places, ends):
    """Split the particles of a rank by whether their body is in the initial configuration.

    Parameters
    ----------
    lagrangian : (bodies,) bool
        Which bodies are.
    body : (capacity,) int
        The particles' bodies.
    rows, start
        See `Order`.
    places : (2, n) int32
        Filled with the places in `rows`: of the other particles, and of those.
    ends : (2, layers + 1) int64
        Set to where each layer begins in them.
    """
    found, more = 0, 0
    for layer in range(len(start) - 1):
        ends[0, layer], ends[1, layer] = found, more
        for k in range(start[layer], start[layer + 1]):
            if lagrangian[body[rows[k]]]:
                places[1, more] = k
                more += 1
            else:
                places[0, found] = k
                found += 1
    ends[0, len(start) - 1], ends[1, len(start) - 1] = found, more
