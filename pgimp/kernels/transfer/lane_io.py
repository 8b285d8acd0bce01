"""Four particles at once: their rows, and reads and writes of their columns.

Weights, deformation and stress are computed for four particles in one vector register. A short
group at the end of a layer repeats its last particle: a particle's results do not depend on its
group and lane.
"""

from pgimp.jit.kernel import inlined
from pgimp.jit.vectors.rows import load_row, store_row, transpose
from pgimp.jit.vectors.simd import lane, pack
from pgimp.kernels.transfer.first_vertex import is_initial, off_axis, undeformed

#: Particles computed together.
LANES = 4


@inlined
def four_rows(order, k, end):
    """Rows of the particles ``order[k:k + 4]``; the last before `end` replaces missing ones."""
    return (
        order[k],
        order[min(k + 1, end - 1)],
        order[min(k + 2, end - 1)],
        order[min(k + 3, end - 1)],
    )


@inlined
def take(array, rows):
    """Vector of the entries of four rows."""
    return pack(array[rows[0]], array[rows[1]], array[rows[2]], array[rows[3]])


@inlined
def take_row(array, rows, i, like):
    """Vectors of the entries i, i+1, ... of four rows, as many as `like` has."""
    if len(like) == 4:
        return transpose(*tuple(load_row(array, rows[j], i) for j in range(4)))
    if len(like) > 4:
        return (*take_row(array, rows, i, like[:4]), *take_row(array, rows, i + 4, like[4:]))
    return tuple(pack(*tuple(array[rows[j], i + k] for j in range(4))) for k in range(len(like)))


@inlined
def put(array, rows, values):
    """Set the entries of four rows to the elements of a vector."""
    for j in range(4):
        array[rows[j]] = lane(values, j)


@inlined
def put_row(array, rows, i, values):
    """Set the entries i, i+1, ... of four rows to the vectors `values`."""
    if len(values) > 4:
        put_row(array, rows, i, values[:4])
        put_row(array, rows, i + 4, values[4:])
    elif len(values) == 4:
        for j, row in enumerate(transpose(*values)):
            store_row(array, rows[j], i, row)
    else:
        for k, value in enumerate(values):
            for j in range(4):
                array[rows[j], i + k] = lane(value, j)


@inlined
def deformations(frame, particles, rows):
    """Deformation gradients of four particles, a row-major tuple of vectors."""
    like = undeformed(frame)
    return take_row(particles.F, rows, 0, like)


@inlined
def coordinates(frame, particles, rows):
    """Positions of four particles' weights, a tuple of vectors; see `coordinate`."""
    like = (0.0,) * len(frame.origin)
    if is_initial(frame):
        return take_row(particles.origin, rows, 0, like)
    return off_axis(frame, take_row(particles.x, rows, 0, like))
