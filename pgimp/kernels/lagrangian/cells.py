"""Forces of lattice particles cell by cell, from the vertices' displacements.

In the initial configuration the particles of a lattice have the same weights in every cell, and
reach its corners only. So a cell's displacements are read once. Its particles' deformation
gradients

    F_p = 1 + sum_v u_v grad0 S_vp

follow by sums along one direction after the other, and the forces -V0 P grad0 S by their adjoint.
Four particles are computed in lanes. Elastic materials need no data of particles but V0. Others
keep F, stress and state in the particles' columns, see `pgimp.kernels.lagrangian.advance`.
"""

from typing import Any, NamedTuple

from numpy.typing import NDArray

from pgimp.jit.algebra import determinant
from pgimp.jit.kernel import inner_kernel, specialise
from pgimp.jit.tuples import scaled
from pgimp.jit.vectors.lanes import half_of, joined_lanes, lanes_of, where_all
from pgimp.jit.vectors.simd import bits, join, lane, load, stack, store, vector
from pgimp.kernels.data.particles import FloatArray, IntArray
from pgimp.kernels.data.record import RECORD
from pgimp.kernels.lagrangian.cell_derivatives import (
    deformations_of_four,
    derivative_buffers,
    derive_across,
    derive_slice,
    load_corners,
    sizes_of,
)
from pgimp.kernels.lagrangian.cell_forces import (
    add_slice,
    cell_forces,
    keep_stresses,
    stress_buffers,
)
from pgimp.kernels.lagrangian.stored_stress import add_mean_forces, keep_stored, mean_total
from pgimp.kernels.update.speed import grid_speed
from pgimp.physics.materials.parameters.evaluate import evaluate_four

#: Offset of the vector with the forces in a record of the sums. Displacements are in the first
#: vector of a record of the motion.
_FORCES = 4


class Cells(NamedTuple):
    """Cells of lattice particles, each of one body, in the order of their layers.

    Attributes
    ----------
    setting : KernelScene
        The scene.
    loads : Loads or ()
        Viscosity and mean dilatation of materials with a memory; () if all are elastic, without
        either.
    start : (layers + 1,) int64
        Beginning of each layer.
    place : (cells,) int64
        Offset of the lowest vertex in its plane.
    material : (cells,) int64
        Number of the material.
    volumes : (cells * slots,) float64
        Initial volumes by slot, 0 without a particle. In 3D each plane of a cell's particles begins
        with a multiple of four.
    rows : (cells * slots,) int64
        Rows of the particles with a memory; of four slots those without a particle repeat another
        one's, or are -1 if all are.
    fractions, distances : (D * MOST,) float64
        Distances of the particles from the lower vertex along each direction, over its cell's
        length, and themselves.
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
    loads: Any
    start: IntArray
    place: IntArray
    material: IntArray
    volumes: FloatArray
    rows: IntArray
    fractions: FloatArray
    distances: FloatArray
    per_cell: tuple
    controlled: bool
    rate: FloatArray
    wrong: NDArray


@inner_kernel
def note_wrong(cells, volume, sound, first):
    """List the particles of a group of four, from slot `first` on, that are not sound."""
    for j in range(4):
        if sound >> j & 1 == 0 and lane(volume, j) > 0.0:
            count = cells.wrong[0] + 1
            cells.wrong[0] = count
            if count < len(cells.wrong):
                cells.wrong[count] = first + j


def raise_rate(cells, fastest):
    """Raise the greatest rate to the greatest of a vector, if it is looked for."""


@specialise(raise_rate)
def _raise_rate(cells, fastest):
    lanes = lanes_of(fastest)

    def raised(cells, fastest):
        if cells.controlled:
            for j in range(lanes):
                cells.rate[0] = max(cells.rate[0], lane(fastest, j))

    return raised


def add_cells(cells, field, particles, layer, span):
    """Add the forces of the cells of a layer to its planes.

    `span` is the range of a plane with sums so far, in float64, and is returned widened.
    """


@specialise(add_cells)
def _add_cells(cells, field, particles, layer, span):
    if not hasattr(cells, "instance_class"):  # ()
        return lambda cells, field, particles, layer, span: span
    D, slices, _, _, _, planes, first, second = sizes_of(cells)
    step = 2 if _in_pairs(cells) else 1

    def add(cells, field, particles, layer, span):
        scratch, window = field.scratch, field.window
        sa, sb, sc = window.stride[0], window.stride[first], window.stride[second]
        inverse, fastest = 0.0, _no_rates(cells)
        for d in range(D):
            inverse = max(inverse, cells.setting.frame.inverse[d])
        f, derivatives, stresses = stack(32), derivative_buffers(), stress_buffers()
        low, high = sa, -1
        for cell in range(cells.start[layer], cells.start[layer + 1]):
            at = cells.place[cell]
            low, high = min(low, at), max(high, at)
            _begin_cell(cells, field.motion.values, layer * sa + at, (sa, sb, sc), derivatives)
            total = mean_total(cells.loads)
            for q in range(0, slices, step):
                fastest, total = _add_slices(
                    cells, particles, cell, q, (derivatives, stresses), inverse, fastest, total
                )
            cell_forces(cells, stresses, f)
            add_mean_forces(cells, particles, cell, total, f)
            for a in range(planes):
                for i in range(4):
                    to = at + a * sa + (i // 2) * sb + (i % 2) * sc + _FORCES
                    store(scratch, to, load(scratch, to) + load(f, 16 * a + 4 * i))
        raise_rate(cells, fastest)
        if high < 0:
            return span
        high += RECORD
        for d in range(1, D):
            high += window.stride[d]
        return (low, high) if span[1] == 0 else (min(low, span[0]), max(high, span[1]))

    return add


def _elastic(cells):
    """Whether the Numba type of cells is of elastic materials."""
    return not hasattr(cells.types[cells.fields.index("loads")], "instance_class")


def _in_pairs(cells):
    """Whether cells of this Numba type have pairs of slices, whose stresses are found together."""
    return _elastic(cells) and sizes_of(cells).slices % 2 == 0


def _no_rates(cells):
    """Rates of no particles, a vector as long as those of `_add_slices`."""


@specialise(_no_rates)
def _no_rates_of(cells):
    if _in_pairs(cells):
        return lambda cells: join(vector(0.0), vector(0.0))
    return lambda cells: vector(0.0)


def _begin_cell(cells, motion, at, strides, derivatives):
    """Begin the derivatives of the displacements in a cell, of elastic materials."""


@specialise(_begin_cell)
def _begin_cell_of(cells, motion, at, strides, derivatives):
    def begin(cells, motion, at, strides, derivatives):
        load_corners(cells, motion, at, strides, derivatives.u)
        derive_across(cells, derivatives)

    if _elastic(cells):
        return begin
    return lambda cells, motion, at, strides, derivatives: None


def _add_slices(cells, particles, cell, q, buffers, inverse, fastest, total):
    """Add the forces of slice `q`, or of a pair; greatest speeds, and sums for mean dilatation.

    `buffers` are `Derivatives` and `Stresses`.
    """


@specialise(_add_slices)
def _add_slices_of(cells, particles, cell, q, buffers, inverse, fastest, total):
    _, slices, _, _, groups, _, _, _ = sizes_of(cells)

    def pair(cells, particles, cell, q, buffers, inverse, fastest, total):
        derivatives, stresses = buffers
        derive_slice(cells, q, derivatives)
        derive_slice(cells, q + 1, derivatives)
        for group in range(groups):
            slot = 4 * ((cell * slices + q) * groups + group)
            V = join(load(cells.volumes, slot), load(cells.volumes, slot + 4 * groups))
            F = joined_lanes(
                deformations_of_four(cells, derivatives, q, group),
                deformations_of_four(cells, derivatives, q + 1, group),
            )
            P, fastest = _elastic_stresses(cells, cell, slot, V, F, inverse, fastest)
            keep_stresses(stresses, q, group, half_of(P, 0))
            keep_stresses(stresses, q + 1, group, half_of(P, 1))
        add_slice(cells, q, stresses)
        add_slice(cells, q + 1, stresses)
        return fastest, total

    def one(cells, particles, cell, q, buffers, inverse, fastest, total):
        derivatives, stresses = buffers
        derive_slice(cells, q, derivatives)
        for group in range(groups):
            slot = 4 * ((cell * slices + q) * groups + group)
            V, F = load(cells.volumes, slot), deformations_of_four(cells, derivatives, q, group)
            P, fastest = _elastic_stresses(cells, cell, slot, V, F, inverse, fastest)
            keep_stresses(stresses, q, group, P)
        add_slice(cells, q, stresses)
        return fastest, total

    def stored(cells, particles, cell, q, buffers, inverse, fastest, total):
        for group in range(groups):
            slot = 4 * ((cell * slices + q) * groups + group)
            total = keep_stored(cells, particles, slot, buffers[1], q, group, total)
        add_slice(cells, q, buffers[1])
        return fastest, total

    if not _elastic(cells):
        return stored
    return pair if _in_pairs(cells) else one


def _elastic_stresses(cells, cell, slot, V, F, inverse, fastest):
    """-V0 P of elastic particles with volumes `V`, from slot `slot` on; greatest speeds.

    Those of a second slice are as many slots further as a slice has.
    """


@specialise(_elastic_stresses)
def _elastic_stresses_of(cells, cell, slot, V, F, inverse, fastest):
    D, every = sizes_of(cells).dimension, 2 ** lanes_of(V) - 1
    identity = tuple(float(i == j) for i in range(D) for j in range(D))

    def stresses(cells, cell, slot, V, F, inverse, fastest):
        setting, k = cells.setting, cells.material[cell]
        J = determinant(F)
        sound = bits((V > 0.0) & (J > 0.0))
        if sound != every:
            _note_groups(cells, V, sound, slot)
            F = where_all((V > 0.0) & (J > 0.0), F, identity)
            J = determinant(F)
        P = scaled(-V, evaluate_four("piola", setting.materials, k, (F, J), (), F))
        if cells.controlled:
            c = grid_speed(setting, True, k, ((), F, J, ()), inverse, 0.0)
            fastest = max(c * inverse, fastest)
        return P, fastest

    return stresses


def _note_groups(cells, V, sound, slot):
    """As `note_wrong`, also of a group and the same of the next slice."""


@specialise(_note_groups)
def _note_each_group(cells, V, sound, slot):
    behind = 4 * sizes_of(cells).groups

    def both(cells, V, sound, slot):
        note_wrong(cells, half_of(V, 0), sound & 15, slot)
        note_wrong(cells, half_of(V, 1), sound >> 4, slot + behind)

    if lanes_of(V) == 8:
        return both
    return lambda cells, V, sound, slot: note_wrong(cells, V, sound, slot)
