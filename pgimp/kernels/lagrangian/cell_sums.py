"""Sums over the particles of a lattice cell along one direction after the other, and their adjoint.

A slice is the particles of a plane across x in 3D, and all particles in 2D. Vectors hold a number
that is not used and three components.
"""

from typing import NamedTuple

from pgimp.jit.kernel import specialise
from pgimp.jit.vectors.rows import transpose
from pgimp.jit.vectors.simd import load, stack, store, vector

#: Most particles of a cell along a direction.
MOST = 4

#: Numbers in the buffers of a slice's derivatives, and of its stresses: 16 particles.
_SLICE = 192


class CellSizes(NamedTuple):
    """Numbers of particles of a cell, known to the compiler.

    Attributes
    ----------
    slices, rows, columns : int
        Slices of a cell, and particles of a slice along its `first` and `second` direction.
    groups : int
        Groups of four particles of a slice.
    planes : int
        Planes of the cell's vertices in a slice's sums: 2 in 3D, else 1.
    """

    dimension: int
    slices: int
    rows: int
    columns: int
    groups: int
    planes: int
    first: int
    second: int


def sizes(per_cell) -> CellSizes:
    """Return the sizes for the Numba type of `Cells.per_cell`."""
    counts = [len(each) for each in per_cell]
    D = len(counts)
    groups = -(-counts[-2] * counts[-1] // 4)
    return CellSizes(
        D, counts[0] if D == 3 else 1, counts[-2], counts[-1], groups, D - 1, D - 2, D - 1
    )


def slice_buffers():
    """Buffers for `derive_slice` and `add_slice`: values, slopes, lines and derivatives."""


@specialise(slice_buffers)
def _slice_buffers():
    return lambda: (stack(16), stack(16), stack(24), stack(_SLICE))


def stress_buffer():
    """Buffer for the stresses of a slice, a vector a particle and direction."""


@specialise(stress_buffer)
def _stress_buffer():
    return lambda: stack(_SLICE)


def corner_displacements(per_cell, motion, at, strides, u):
    """Load the records of the corners of a cell, whose first is at `at`, into the buffer `u`."""


@specialise(corner_displacements)
def _corner_displacements(per_cell, motion, at, strides, u):
    planes = sizes(per_cell).planes

    def corners(per_cell, motion, at, strides, u):
        sa, sb, sc = strides
        for a in range(planes):
            for i in range(4):
                r = at + a * sa + (i // 2) * sb + (i % 2) * sc
                store(u, 16 * a + 4 * i, load(motion, r))

    return corners


def derive_slice(cells, u, q, buffers):
    """Derivatives of the displacements `u` of a cell's corners at the particles of slice `q`.

    Three vectors a particle, by direction, in the last buffer.
    """


@specialise(derive_slice)
def _derive_slice(cells, u, q, buffers):
    D, _, rows, columns, groups, _, first, second = sizes(
        cells.types[cells.fields.index("per_cell")]
    )
    three = D == 3
    size, of_first, of_second = rows * columns, 2 * MOST * first, 2 * MOST * second

    def derive(cells, u, q, buffers):
        W, G = cells.weights, cells.gradients
        values, slopes, lines, grads = buffers
        for pad in range(size, 4 * groups):
            for e in range(D):
                store(grads, 12 * pad + 4 * e, vector(0.0))
        for i in range(4):
            if three:
                u0, u1 = load(u, 4 * i), load(u, 16 + 4 * i)
                store(values, 4 * i, W[2 * q] * u0 + W[2 * q + 1] * u1)
                store(slopes, 4 * i, G[2 * q] * u0 + G[2 * q + 1] * u1)
            else:
                store(values, 4 * i, load(u, 4 * i))
        for r in range(rows):
            w0, w1 = W[of_first + 2 * r], W[of_first + 2 * r + 1]
            g0, g1 = G[of_first + 2 * r], G[of_first + 2 * r + 1]
            for c in range(2):
                v0, v1 = load(values, 4 * c), load(values, 8 + 4 * c)
                store(lines, 8 + 4 * c, g0 * v0 + g1 * v1)
                store(lines, 16 + 4 * c, w0 * v0 + w1 * v1)
                if three:
                    x0, x1 = load(slopes, 4 * c), load(slopes, 8 + 4 * c)
                    store(lines, 4 * c, w0 * x0 + w1 * x1)
            for s in range(columns):
                w0, w1 = W[of_second + 2 * s], W[of_second + 2 * s + 1]
                g0, g1 = G[of_second + 2 * s], G[of_second + 2 * s + 1]
                to = 12 * (r * columns + s)
                if three:
                    store(grads, to, w0 * load(lines, 0) + w1 * load(lines, 4))
                store(grads, to + 4 * first, w0 * load(lines, 8) + w1 * load(lines, 12))
                store(grads, to + 4 * second, g0 * load(lines, 16) + g1 * load(lines, 20))

    return derive


def add_slice(cells, P, q, buffers, f):
    """Add the forces of the particles of slice `q` to the corners' in `f`: the adjoint.

    `P` is -V0 times their stresses, see `pgimp.kernels.update.piola.keep_columns`.
    """


@specialise(add_slice)
def _add_slice(cells, P, q, buffers, f):
    D, _, rows, columns, _, planes, first, second = sizes(
        cells.types[cells.fields.index("per_cell")]
    )
    three = D == 3
    of_first, of_second = 2 * MOST * first, 2 * MOST * second

    def add(cells, P, q, buffers, f):
        W, G = cells.weights, cells.gradients
        values, slopes, _, _ = buffers
        for r in range(rows):
            for c in range(2):
                of = 48 * (r * columns // 4) + 4 * (r * columns % 4)
                w, g = W[of_second + c], G[of_second + c]
                x = w * load(P, of)
                y, z = w * load(P, of + 16 * first), g * load(P, of + 16 * second)
                for s in range(1, columns):
                    of = 48 * ((r * columns + s) // 4) + 4 * ((r * columns + s) % 4)
                    w, g = W[of_second + 2 * s + c], G[of_second + 2 * s + c]
                    x = w * load(P, of) + x
                    y = w * load(P, of + 16 * first) + y
                    z = g * load(P, of + 16 * second) + z
                for b in range(2):
                    w, g = W[of_first + 2 * r + b], G[of_first + 2 * r + b]
                    i = 8 * b + 4 * c
                    v = g * y + w * z
                    if r > 0:
                        v, x0 = load(values, i) + v, load(slopes, i) + w * x
                    else:
                        x0 = w * x
                    store(values, i, v)
                    store(slopes, i, x0)
        for a in range(planes):
            for i in range(4):
                v = load(values, 4 * i)
                if three:
                    v = W[2 * q + a] * v + G[2 * q + a] * load(slopes, 4 * i)
                store(f, 16 * a + 4 * i, load(f, 16 * a + 4 * i) + v)

    return add


def deformations_of_four(identity, buffers, group):
    """Deformation gradients of four particles of a slice, from `derive_slice`."""


@specialise(deformations_of_four)
def _deformations_of_four(identity, buffers, group):
    def two(identity, buffers, group):
        grads, at = buffers[3], 48 * group
        X, Y = _derivatives(grads, at), _derivatives(grads, at + 4)
        return 1.0 + X[1], Y[1], X[2], 1.0 + Y[2]

    def three(identity, buffers, group):
        grads, at = buffers[3], 48 * group
        X, Y = _derivatives(grads, at), _derivatives(grads, at + 4)
        Z = _derivatives(grads, at + 8)
        return 1.0 + X[1], Y[1], Z[1], X[2], 1.0 + Y[2], Z[2], X[3], Y[3], 1.0 + Z[3]

    return two if len(identity) == 4 else three


def _derivatives(grads, at):
    """Components of four particles' displacements derived along one direction."""


@specialise(_derivatives)
def _derivatives_of(grads, at):
    return lambda grads, at: transpose(
        load(grads, at), load(grads, at + 12), load(grads, at + 24), load(grads, at + 36)
    )


def broadcast(numbers):
    """Vectors of numbers."""


@specialise(broadcast)
def _broadcast(numbers):
    if len(numbers) == 1:
        return lambda numbers: (vector(numbers[0]),)
    return lambda numbers: (vector(numbers[0]), *broadcast(numbers[1:]))
