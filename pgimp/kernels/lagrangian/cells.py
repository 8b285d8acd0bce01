"""Forces of lattice particles cell by cell, from the vertices' displacements.

In the initial configuration the particles of a lattice have the same weights in every cell, and
reach its corners only. So a cell's displacements are read once. Its particles' deformation
gradients

    F_p = 1 + sum_v u_v grad0 S_vp

follow by sums along one direction after the other, and the forces -V0 P grad0 S by their adjoint.
Stresses are computed for eight particles at once, of several cells. Elastic materials need no data
of particles but V0. Others keep F, stress and state in the particles' columns, see
`pgimp.kernels.lagrangian.advance`.
"""

from typing import Any, NamedTuple

from numpy.typing import NDArray

from pgimp.jit.algebra import determinant
from pgimp.jit.kernel import inlined, inner_kernel, is_record
from pgimp.jit.tuples import scaled
from pgimp.jit.vectors.lanes import half_of, lanes_of, where_all
from pgimp.jit.vectors.simd import bits, join, lane, load, stack, store, vector, where
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
from pgimp.kernels.lagrangian.cell_forces import cell_forces, stress_buffers
from pgimp.kernels.lagrangian.cell_matrices import (
    groups_of,
    keep_eight,
    keep_four,
    matrices,
    most_together,
    of_eight,
)
from pgimp.kernels.lagrangian.stored_stress import add_mean_forces, mean_total, stored_stresses
from pgimp.kernels.update.speed import grid_speed
from pgimp.physics.materials.parameters.evaluate import evaluate_four

#: Vertices of a cell along a direction.
CELL_VERTICES = 2

#: Offset of the vector with the forces in a record of the sums. Displacements are in the first
#: vector of a record of the motion.
_FORCES = 4


class Cells(NamedTuple):
    """Cells of lattice particles, each of one body, in the order of their layers."""

    setting: Any  #: KernelScene.
    #: Loads or (): Viscosity and mean dilatation of materials with a memory; () if all are elastic,
    #: without either.
    loads: Any
    start: IntArray  #: (layers + 1,) int64: Beginning of each layer.
    place: IntArray  #: (cells,) int64: Offset of the lowest vertex in its plane.
    material: IntArray  #: (cells,) int64: Number of the material.
    #: (cells * slots,) float64: Initial volumes by slot, 0 without a particle. In 3D each plane of
    #: a cell's particles begins with a multiple of four.
    volumes: FloatArray
    #: (cells * slots,) int64: Rows of the particles with a memory; of four slots those without a
    #: particle repeat another one's, or are -1 if all are.
    rows: IntArray
    #: fractions, distances: (D * MOST,) float64: Distances of the particles from the lower vertex
    #: along each direction, over its cell's length, and themselves.
    fractions: FloatArray
    distances: FloatArray
    per_cell: tuple  #: tuple of D tuples: As long as there are particles along each direction.
    parts: Any  #: PartCells or (): Those of bodies that are exact to their surface.
    controlled: bool  #: Whether to find the greatest speed.
    rate: FloatArray  #: (1,) float64: Grows to the greatest speed over the cell, see `grid_speed`.
    #: (capacity + 1,) int64: Number of particles at fault, then their slots up to the capacity.
    wrong: NDArray


@inner_kernel
def note_errors(cells, volume, sound, first):
    """List the particles of a group of four, from slot `first` on, that are not sound."""
    for j in range(4):
        if sound >> j & 1 == 0 and lane(volume, j) > 0.0:
            count = cells.wrong[0] + 1
            cells.wrong[0] = count
            if count < len(cells.wrong):
                cells.wrong[count] = first + j


@inlined
def raise_rate(cells, fastest):
    """Raise the greatest rate to the greatest of a vector, if it is looked for."""
    lanes = lanes_of(fastest)
    if cells.controlled:
        for j in range(lanes):
            cells.rate[0] = max(cells.rate[0], lane(fastest, j))


@inlined
def add_cells(cells, field, particles, layer, span):
    """Add the forces of the cells of a layer to its planes.

    `span` is the range of a plane with sums so far, in float64, and is returned widened.
    """
    if not is_record(cells):
        return span
    D, _, _, _, _, _, first, second = sizes_of(cells)
    groups, window = groups_of(sizes_of(cells)), field.window
    strides = window.stride[0], window.stride[first], window.stride[second]
    fastest = join(vector(0.0), vector(0.0))
    f, P, buffers = stack(32), matrices(cells), stress_buffers()
    low, high = strides[0], -1
    cell, end = cells.start[layer], cells.start[layer + 1]
    while cell < end:
        count = _together(cells, cell, end)
        fastest, total = _find_stresses(
            cells, field, particles, (layer, cell, count), strides, P, fastest
        )
        for k in range(count):
            cell_forces(cells, P, k * groups, buffers, f)
            add_mean_forces(cells, particles, cell + k, total, f)
            at = cells.place[cell + k]
            low, high = min(low, at), max(high, at)
            add_corners(cells, field.scratch, at, strides, f)
        cell += count
    raise_rate(cells, fastest)
    return widened(window, D, low, high, span)


@inlined
def add_corners(cells, scratch, at, strides, f):
    """Add the forces `f` at a cell's corners to the sums, of which those at `at` are the first."""
    planes = sizes_of(cells).planes
    for a in range(planes):
        for i in range(4):
            to = at + a * strides[0] + i // 2 * strides[1] + i % 2 * strides[2] + _FORCES
            store(scratch, to, load(scratch, to) + load(f, 16 * a + 4 * i))


@inlined
def widened(window, D, low, high, span):
    """A span with the vertices of cells from `low` to `high`, which is -1 without any."""
    if high < 0:
        return span
    high += RECORD
    for d in range(1, D):
        high += window.stride[d]
    return (low, high) if span[1] == 0 else (min(low, span[0]), max(high, span[1]))


@inlined
def _together(cells, cell, end):
    """Number of cells from `cell` on, below `end`, whose stresses are found together."""
    most = most_together(sizes_of(cells))
    if not is_record(cells.loads):  # elastic
        count, end = 1, min(cell + most, end)
        while cell + count < end and cells.material[cell + count] == cells.material[cell]:
            count += 1
        return count
    return 1


@inlined
def _find_stresses(cells, field, particles, which, strides, P, fastest):
    """Find -V0 P of the particles of some cells; greatest speeds, and sums for mean dilatation.

    `which` are their layer, the first cell, and how many they are.
    """
    D = sizes_of(cells).dimension
    groups = groups_of(sizes_of(cells))
    if not is_record(cells.loads):  # elastic
        layer, cell, count = which
        setting, material, inverse = cells.setting, cells.material[cell], 0.0
        for d in range(D):
            inverse = max(inverse, setting.frame.inverse[d])
        buffers = derivative_buffers()
        for k in range(count):
            at = layer * strides[0] + cells.place[cell + k]
            _derive_cell(cells, field.motion.values, at, strides, buffers, k * groups, P)
        every = count * groups
        for pair in range((every + 1) // 2):
            slot = 4 * (cell * groups + 2 * pair)
            low, high = load(cells.volumes, slot), vector(0.0)
            if 2 * pair + 1 < every:
                high = load(cells.volumes, slot + 4)
            stress, fastest = elastic_stresses(
                cells, material, slot, join(low, high), of_eight(cells, P, pair), inverse, fastest
            )
            keep_eight(P, pair, stress)
        return fastest, ()
    total = mean_total(cells.loads)
    for group in range(groups):
        slot = 4 * (which[1] * groups + group)
        stress, total = stored_stresses(cells, particles, slot, total)
        keep_four(P, group, stress)
    return fastest, total


@inlined
def _derive_cell(cells, motion, at, strides, buffers, group, F):
    """Deformation gradients of the particles of a cell, as groups of four from `group` on."""
    _, slices, _, _, groups, _, _, _ = sizes_of(cells)
    load_corners(cells, motion, at, strides, buffers.u)
    derive_across(cells, buffers)
    for q in range(slices):
        derive_slice(cells, q, buffers)
        for i in range(groups):
            keep_four(F, group + q * groups + i, deformations_of_four(cells, buffers, i))


@inlined
def elastic_stresses(cells, material, slot, V, F, inverse, fastest):
    """-V0 P of eight elastic particles with volumes `V`, from slot `slot` on; greatest speeds."""
    D = sizes_of(cells).dimension
    identity = tuple(float(i == j) for i in range(D) for j in range(D))
    J = determinant(F)
    sound = (V > 0.0) & (J > 0.0)
    if bits(sound) != 255:  # materials must not see any F that missing particles may have
        note_errors(cells, half_of(V, 0), bits(sound) & 15, slot)
        note_errors(cells, half_of(V, 1), bits(sound) >> 4, slot + 4)
        F = where_all(sound, F, identity)
        J = determinant(F)
    setting = cells.setting
    P = scaled(-V, evaluate_four("piola", setting.materials, material, (F, J), (), F))
    if cells.controlled:
        c = grid_speed(setting, True, material, ((), F, J, ()), inverse, 0.0)
        fastest = max(where(V > 0.0, c * inverse, 0.0), fastest)
    return P, fastest
