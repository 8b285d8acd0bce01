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
        return transpose(
            load_row(array, rows[0], i),
            load_row(array, rows[1], i),
            load_row(array, rows[2], i),
            load_row(array, rows[3], i),
        )
    if len(like) > 4:
        return (*take_row(array, rows, i, like[:4]), *take_row(array, rows, i + 4, like[4:]))
    if len(like) == 1:
        return (pack(array[rows[0], i], array[rows[1], i], array[rows[2], i], array[rows[3], i]),)
    return (
        pack(array[rows[0], i], array[rows[1], i], array[rows[2], i], array[rows[3], i]),
        *take_row(array, rows, i + 1, like[1:]),
    )


@inlined
def put(array, rows, values):
    """Set the entries of four rows to the elements of a vector."""
    array[rows[0]] = lane(values, 0)
    array[rows[1]] = lane(values, 1)
    array[rows[2]] = lane(values, 2)
    array[rows[3]] = lane(values, 3)


@inlined
def put_row(array, rows, i, values):
    """Set the entries i, i+1, ... of four rows to the vectors `values`."""
    if min(len(values), 5) == 1:
        array[rows[0], i] = lane(values[0], 0)
        array[rows[1], i] = lane(values[0], 1)
        array[rows[2], i] = lane(values[0], 2)
        array[rows[3], i] = lane(values[0], 3)
        return
    if min(len(values), 5) == 2:
        put_row(array, rows, i, values[:1])
        put_row(array, rows, i + 1, values[1:])
        return
    if min(len(values), 5) == 3:
        put_row(array, rows, i, values[:1])
        put_row(array, rows, i + 1, values[1:])
        return
    if min(len(values), 5) == 4:
        whole = transpose(values[0], values[1], values[2], values[3])
        store_row(array, rows[0], i, whole[0])
        store_row(array, rows[1], i, whole[1])
        store_row(array, rows[2], i, whole[2])
        store_row(array, rows[3], i, whole[3])
        return
    put_row(array, rows, i, values[:4])
    put_row(array, rows, i + 4, values[4:])


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
