"""Forces of lattice particles cell by cell, from the vertices' displacements.

In the initial configuration the particles of a lattice have the same weights in every cell, and
reach its corners only. So a cell's displacements are read once. Its particles' deformation
gradients

    F_p = 1 + sum_v u_v grad0 S_vp

follow by sums along one direction after the other, and the forces -V0 P grad0 S by their adjoint.
Four particles are computed in lanes. Elastic materials need no data of particles but V0.
"""

from typing import Any, NamedTuple

from numpy.typing import NDArray

from pgimp.jit.algebra import determinant
from pgimp.jit.kernel import inner_kernel, specialise
from pgimp.jit.tuples import scaled
from pgimp.jit.vectors.lanes import where_all
from pgimp.jit.vectors.rows import transpose
from pgimp.jit.vectors.simd import bits, lane, load, stack, store, vector
from pgimp.kernels.data.particles import FloatArray, IntArray
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.update.piola import keep_columns
from pgimp.kernels.update.speed import grid_speed
from pgimp.physics.materials.parameters.evaluate import evaluate_four

#: Offset of the vector with the forces in a record of the sums. Displacements are in the first
#: vector of a record of the motion.
_FORCES = 4

#: Most particles of a cell along a direction.
MOST = 4


class Cells(NamedTuple):
    """Cells of lattice particles, each of one body, in the order of their layers.

    Attributes
    ----------
    setting : KernelScene
        The scene, of hyperelastic materials.
    start : (layers + 1,) int64
        Beginning of each layer.
    place : (cells,) int64
        Offset of the lowest vertex in its plane.
    material : (cells,) int64
        Number of the material.
    volumes : (cells * slots,) float64
        Initial volumes by slot, 0 without a particle. In 3D each plane of a cell's particles begins
        with a multiple of four.
    weights, gradients : (D * MOST * 2,) float64
        S and its derivative of the particles along each direction, at the two vertices.
    per_cell : tuple of D tuples
        As long as there are particles along each direction.
    controlled : bool
        Whether to find the greatest speed.
    rate : (1,) float64
        Grows to the greatest speed over the cell, see `grid_speed`.
    wrong : (capacity + 1,) int64
        Number of particles at fault, then their slots up to the capacity.
    """

    setting: Any
    start: IntArray
    place: IntArray
    material: IntArray
    volumes: FloatArray
    weights: FloatArray
    gradients: FloatArray
    per_cell: tuple
    controlled: bool
    rate: FloatArray
    wrong: NDArray


def add_cells(cells, field, layer, span):
    """Add the forces of the cells of a layer to its planes.

    `span` is the range of a plane with sums so far, in float64, and is returned widened.
    """


@inner_kernel
def _note_wrong(cells, volume, sound, first):
    """List the particles of a group of four, from slot `first` on, that are not sound."""
    for j in range(4):
        if sound >> j & 1 == 0 and lane(volume, j) > 0.0:
            count = cells.wrong[0] + 1
            cells.wrong[0] = count
            if count < len(cells.wrong):
                cells.wrong[count] = first + j


@specialise(add_cells)
def _add_cells(cells, field, layer, span):
    if not hasattr(cells, "instance_class"):  # ()
        return lambda cells, field, layer, span: span
    counts = [len(each) for each in cells.types[cells.fields.index("per_cell")]]
    D = len(counts)
    three = D == 3
    # A slice: in 3D the particles of a plane across x, in 2D all; `first` and `second` direction.
    slices, rows, columns = counts[0] if three else 1, counts[-2], counts[-1]
    size = rows * columns
    groups, planes, first, second = -(-size // 4), 2 if three else 1, D - 2, D - 1
    identity = tuple(float(i == j) for i in range(D) for j in range(D))
    of_first, of_second = 2 * MOST * first, 2 * MOST * second

    def add(cells, field, layer, span):
        motion, scratch, window = field.motion.values, field.scratch, field.window
        W, G, place, setting = cells.weights, cells.gradients, cells.place, cells.setting
        sa, sb, sc = window.stride[0], window.stride[first], window.stride[second]
        inverse, fastest = 0.0, vector(0.0)
        for d in range(D):
            inverse = max(inverse, setting.frame.inverse[d])
        u, f = stack(32), stack(32)
        values, slopes = stack(16), stack(16)
        lines = stack(24)
        grads, P = stack(192), stack(192)
        low, high = sa, -1
        for pad in range(size, 4 * groups):
            for e in range(D):
                store(grads, 12 * pad + 4 * e, vector(0.0))
        for cell in range(cells.start[layer], cells.start[layer + 1]):
            at, k = place[cell], cells.material[cell]
            low, high = min(low, at), max(high, at)
            for a in range(planes):
                for i in range(4):
                    r = layer * sa + at + a * sa + (i // 2) * sb + (i % 2) * sc
                    store(u, 16 * a + 4 * i, load(motion, r))
                    store(f, 16 * a + 4 * i, vector(0.0))
            for q in range(slices):
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
                for group in range(groups):
                    slot = 4 * ((cell * slices + q) * groups + group)
                    V = load(cells.volumes, slot)
                    F = _deformations(identity, grads, 48 * group)
                    J = determinant(F)
                    sound = bits((V > 0.0) & (J > 0.0))
                    if sound != 15:
                        _note_wrong(cells, V, sound, slot)
                        F = where_all((V > 0.0) & (J > 0.0), F, _vectors(identity))
                        J = determinant(F)
                    material = (k, k, k, k)
                    stress = evaluate_four("piola", setting.materials, material, (F, J), (), F)
                    keep_columns(P, 48 * group, scaled(-V, stress))
                    if cells.controlled:
                        c = grid_speed(setting, True, material, ((), F, J, ()), inverse, 0.0)
                        fastest = max(c * inverse, fastest)
                # The adjoint: the same sums backwards.
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
            for a in range(planes):
                for i in range(4):
                    to = at + a * sa + (i // 2) * sb + (i % 2) * sc + _FORCES
                    store(scratch, to, load(scratch, to) + load(f, 16 * a + 4 * i))
        if cells.controlled:
            for j in range(4):
                cells.rate[0] = max(cells.rate[0], lane(fastest, j))
        if high < 0:
            return span
        high += RECORD
        for d in range(1, D):
            high += window.stride[d]
        return (low, high) if span[1] == 0 else (min(low, span[0]), max(high, span[1]))

    return add


def _vectors(numbers):
    """Vectors of numbers."""


@specialise(_vectors)
def _vectors_of(numbers):
    if len(numbers) == 1:
        return lambda numbers: (vector(numbers[0]),)
    return lambda numbers: (vector(numbers[0]), *_vectors(numbers[1:]))


def _derivatives(grads, at):
    """Components of four particles' displacements derived along one direction."""


@specialise(_derivatives)
def _derivatives_of(grads, at):
    return lambda grads, at: transpose(
        load(grads, at), load(grads, at + 12), load(grads, at + 24), load(grads, at + 36)
    )


def _deformations(identity, grads, at):
    """Deformation gradients of four particles, from derivatives of displacements at `at`."""


@specialise(_deformations)
def _deformations_of(identity, grads, at):
    def two(identity, grads, at):
        X, Y = _derivatives(grads, at), _derivatives(grads, at + 4)
        return 1.0 + X[1], Y[1], X[2], 1.0 + Y[2]

    def three(identity, grads, at):
        X, Y = _derivatives(grads, at), _derivatives(grads, at + 4)
        Z = _derivatives(grads, at + 8)
        return 1.0 + X[1], Y[1], Z[1], X[2], 1.0 + Y[2], Z[2], X[3], Y[3], 1.0 + Z[3]

    return two if len(identity) == 4 else three
