"""Forces of lattice particles cell by cell, from the vertices' displacements.

In the initial configuration the particles of a lattice have the same weights in every cell, and
reach its corners only. So a cell's displacements are read once, its particles' deformation gradients

    F_p = 1 + sum_v u_v grad0 S_vp

follow by sums along one direction after the other, and the forces -V0 P grad0 S by their adjoint.
Four particles are computed in lanes. Elastic materials need no data of particles but V0.
"""

from typing import NamedTuple

from numpy.typing import NDArray
import numpy as np

from pgimp.jit.algebra import cofactor, determinant, full, multiply
from pgimp.jit.kernel import kernel, specialise
from pgimp.jit.tuples import scaled
from pgimp.jit.vectors.lanes import where_all
from pgimp.jit.vectors.rows import transpose
from pgimp.jit.vectors.simd import bits, load, number, stack, store, vector
from pgimp.kernels.data.particles import FloatArray, IntArray
from pgimp.physics.materials.parameters.evaluate import evaluate_four
from pgimp.kernels.update.piola import keep_columns


class Cells(NamedTuple):
    """Cells of lattice particles of one body each, in the order of their layers.

    Attributes
    ----------
    start : (layers + 1,) int64
        Beginning of each layer.
    place : (cells,) int64
        Offset of the lowest vertex in its plane.
    material : (cells,) int64
        Number of the material.
    volumes : (cells * slots,) float64
        Initial volumes, 0 where there is no particle; slots are rounded up to fours.
    weights, gradients : (D * 4 * 2,) float64
        S and its derivative of up to four particles along a direction at the two vertices.
    per_cell : tuple of D tuples of float
        As long as there are particles along each direction.
    """

    start: IntArray
    place: IntArray
    material: IntArray
    volumes: FloatArray
    weights: FloatArray
    gradients: FloatArray
    per_cell: tuple


def add_cells(setting, field, cells, layer):
    """Add the forces of the cells of a layer to its planes; returns the range of a plane."""


@specialise(add_cells)
def _add_cells(setting, field, cells, layer):
    counts = [len(each) for each in cells.types[cells.fields.index("per_cell")]]
    D = len(counts)
    outer = counts[0] if D == 3 else 1
    rows, columns = counts[-2], counts[-1]
    planes = 2 if D == 3 else 1
    slice_size = rows * columns
    groups = -(-slice_size // 4)
    first, second = D - 2, D - 1
    identity = tuple(float(i == j) for i in range(D) for j in range(D))
    zeros = (0.0,) * (4, 6)[D - 2]
    three = D == 3

    def add(setting, field, cells, layer):
        motion, scratch, window = field.motion.values, field.scratch, field.window
        W, G, place = cells.weights, cells.gradients, cells.place
        plane = window.stride[0]
        su = plane if three else 0
        sb, sc = window.stride[first], window.stride[second]
        begin = layer * plane
        u, f = stack(32), stack(32)
        values, slopes = stack(16), stack(16)
        value_sums, slope_sums = stack(16), stack(16)
        B = stack(24)
        grads, P = stack(192), stack(192)
        low, high = plane, 0
        for pad in range(slice_size, 4 * groups):
            for e in range(D):
                store(grads, 12 * pad + 4 * e, vector(0.0))
        for cell in range(cells.start[layer], cells.start[layer + 1]):
            at = place[cell]
            low, high = min(low, at), max(high, at)
            k = cells.material[cell]
            for a in range(planes):
                for b in range(2):
                    for c in range(2):
                        store(u, 16 * a + 8 * b + 4 * c,
                              load(motion, begin + at + a * su + b * sb + c * sc + 4))
                        store(f, 16 * a + 8 * b + 4 * c, vector(0.0))
            for q in range(outer):
                if three:
                    for i in range(4):
                        u0, u1 = load(u, 4 * i), load(u, 16 + 4 * i)
                        store(values, 4 * i, W[2 * q] * u0 + W[2 * q + 1] * u1)
                        store(slopes, 4 * i, G[2 * q] * u0 + G[2 * q + 1] * u1)
                else:
                    for i in range(4):
                        store(values, 4 * i, load(u, 4 * i))
                for r in range(rows):
                    w0, w1 = W[8 * first + 2 * r], W[8 * first + 2 * r + 1]
                    g0, g1 = G[8 * first + 2 * r], G[8 * first + 2 * r + 1]
                    for c in range(2):
                        v0, v1 = load(values, 4 * c), load(values, 8 + 4 * c)
                        store(B, 8 + 4 * c, g0 * v0 + g1 * v1)
                        store(B, 16 + 4 * c, w0 * v0 + w1 * v1)
                        if three:
                            x0, x1 = load(slopes, 4 * c), load(slopes, 8 + 4 * c)
                            store(B, 4 * c, w0 * x0 + w1 * x1)
                    for s in range(columns):
                        w0, w1 = W[8 * second + 2 * s], W[8 * second + 2 * s + 1]
                        g0, g1 = G[8 * second + 2 * s], G[8 * second + 2 * s + 1]
                        to = 12 * (r * columns + s)
                        if three:
                            store(grads, to, w0 * load(B, 0) + w1 * load(B, 4))
                        store(grads, to + 4 * (D - 2), w0 * load(B, 8) + w1 * load(B, 12))
                        store(grads, to + 4 * (D - 1), g0 * load(B, 16) + g1 * load(B, 20))
                for group in range(groups):
                    V = load(cells.volumes, 4 * ((cell * outer + q) * groups + group))
                    F = _deformation(identity, grads, 48 * group)
                    if bits(V == 0.0) != 0:
                        F = where_all(V == 0.0, _vectors(identity), F)
                    J = determinant(F)
                    nothing = _vectors(zeros)
                    args = (F, J, nothing, _vectors(identity), 0.0)
                    sigma = evaluate_four(
                        "stress", setting.materials, (k, k, k, k), args, (), nothing
                    )
                    keep_columns(P, 48 * group, scaled(-V, multiply(full(sigma), cofactor(F))))
                for i in range(4):
                    store(value_sums, 4 * i, vector(0.0))
                    if three:
                        store(slope_sums, 4 * i, vector(0.0))
                for r in range(rows):
                    for c in range(2):
                        b0, b1, b2 = vector(0.0), vector(0.0), vector(0.0)
                        for s in range(columns):
                            p = r * columns + s
                            of = 48 * (p // 4) + 4 * (p % 4)
                            w, g = W[8 * second + 2 * s + c], G[8 * second + 2 * s + c]
                            if three:
                                b0 = w * load(P, of) + b0
                            b1 = w * load(P, of + 16 * (D - 2)) + b1
                            b2 = g * load(P, of + 16 * (D - 1)) + b2
                        for b in range(2):
                            w, g = W[8 * first + 2 * r + b], G[8 * first + 2 * r + b]
                            i = 8 * b + 4 * c
                            store(value_sums, i, load(value_sums, i) + (g * b1 + w * b2))
                            if three:
                                store(slope_sums, i, load(slope_sums, i) + w * b0)
                for i in range(4):
                    v = load(value_sums, 4 * i)
                    if three:
                        x = load(slope_sums, 4 * i)
                        store(f, 4 * i, load(f, 4 * i) + (W[2 * q] * v + G[2 * q] * x))
                        store(f, 16 + 4 * i,
                              load(f, 16 + 4 * i) + (W[2 * q + 1] * v + G[2 * q + 1] * x))
                    else:
                        store(f, 4 * i, v)
            for a in range(planes):
                for b in range(2):
                    for c in range(2):
                        to = at + a * su + b * sb + c * sc + 4
                        store(scratch, to, load(scratch, to) + load(f, 16 * a + 8 * b + 4 * c))
        return low, high

    return add


def _vectors(numbers):
    """Vectors of numbers."""


@specialise(_vectors)
def _vectors_of(numbers):
    if len(numbers) == 1:
        return lambda numbers: (vector(numbers[0]),)
    return lambda numbers: (vector(numbers[0]), *_vectors(numbers[1:]))


def _deformation(identity, grads, at):
    """Deformation gradients of four particles from the displacements' derivatives."""


@specialise(_deformation)
def _deformation_of(identity, grads, at):
    def two(identity, grads, at):
        X = transpose(
            load(grads, at), load(grads, at + 12), load(grads, at + 24), load(grads, at + 36)
        )
        Y = transpose(
            load(grads, at + 4), load(grads, at + 16), load(grads, at + 28), load(grads, at + 40)
        )
        return 1.0 + X[1], Y[1], X[2], 1.0 + Y[2]

    def three(identity, grads, at):
        X = transpose(
            load(grads, at), load(grads, at + 12), load(grads, at + 24), load(grads, at + 36)
        )
        Y = transpose(
            load(grads, at + 4), load(grads, at + 16), load(grads, at + 28), load(grads, at + 40)
        )
        Z = transpose(
            load(grads, at + 8), load(grads, at + 20), load(grads, at + 32), load(grads, at + 44)
        )
        return (
            1.0 + X[1], Y[1], Z[1], X[2], 1.0 + Y[2], Z[2], X[3], Y[3], 1.0 + Z[3],
        )  # fmt: skip

    return two if len(identity) == 4 else three


@kernel
def cells_to_scratch(setting, field, cells, layers):
    """Sum the cells of some layers (for measurements)."""
    n = 0
    for layer in layers:
        low, high = add_cells(setting, field, cells, layer)
        n += high
    return n
