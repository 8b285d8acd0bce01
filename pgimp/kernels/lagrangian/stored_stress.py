"""Forces of lattice particles from stresses in their columns: materials with a memory.

With mean dilatation (`pgimp.kernels.update.mean_dilatation_lagrangian`) the cells under a particle
are its cell alone, whose G is the deformation gradient at its centre.
"""

from pgimp.jit.algebra import cofactor, full, multiply, trace
from pgimp.jit.kernel import inlined, is_empty, is_record
from pgimp.jit.tuples import read, scaled
from pgimp.jit.vectors.lanes import vectors
from pgimp.jit.vectors.simd import lane, load, pack, store, vector
from pgimp.kernels.lagrangian.cell_derivatives import sizes_of
from pgimp.kernels.transfer.lane_io import deformations, take_row
from pgimp.kernels.update.piola import less_pressure


@inlined
def mean_total(loads):
    """Beginning of the sum of -V0 p over the particles of a cell, p the mean stress.

    () without mean dilatation.
    """
    if not averages(loads):
        return ()
    return (vector(0.0),)


@inlined
def averages(loads):
    """Whether `Cells.loads` have mean dilatation."""
    return is_record(loads) and not is_empty(loads.mean_lagrangian)


@inlined
def four_slots(rows, slot):
    """The rows of four slots."""
    return (rows[slot], rows[slot + 1], rows[slot + 2], rows[slot + 3])


@inlined
def stored_stresses(cells, particles, slot, total):
    """-V0 P of four particles, from slot `slot` on; the sum of `mean_total` with them."""
    D = sizes_of(cells).dimension
    like, part = (0.0,) * (3, 4, 6)[D - 1], 1.0 / D
    nothing = (0.0,) * D**2
    if len(total):
        if cells.rows[slot] < 0:
            return vectors(nothing), total
        rows = four_slots(cells.rows, slot)
        sigma = take_row(particles.sigma, rows, 0, like)
        sigma = less_pressure(cells.loads.viscosity, particles, rows, sigma)
        in_company = part * (1.0 - take_row(particles.isolation, rows, 0, (0.0,))[0])
        mean = in_company * trace(full(sigma))
        rest = (sigma[0] - mean, sigma[1] - mean, sigma[2] - mean, *sigma[3:])
        fbar_ratio = take_row(particles.fbar_ratio, rows, 0, (0.0,))[0]
        V = -load(cells.volumes, slot)
        P = multiply(full(rest), cofactor(deformations(cells.setting.frame, particles, rows)))
        return scaled(V * fbar_ratio, P), (total[0] + V * mean,)
    if cells.rows[slot] < 0:
        return vectors(nothing), total
    rows = four_slots(cells.rows, slot)
    sigma = take_row(particles.sigma, rows, 0, like)
    sigma = less_pressure(cells.loads.viscosity, particles, rows, sigma)
    P = multiply(full(sigma), cofactor(deformations(cells.setting.frame, particles, rows)))
    return scaled(-load(cells.volumes, slot), P), total


@inlined
def add_mean_forces(cells, particles, cell, total, f):
    """Add the forces by the mean stress of a cell, -V0 p cof G grad, to its corners'."""
    D, slices, _, _, groups, planes, first, second = sizes_of(cells)
    if len(total) == 0:
        return None
    three, slots, matrix = D == 3, 4 * groups * slices, (0.0,) * D**2
    share = 0.5 ** (D - 1)
    slot = slots * cell
    while cells.rows[slot] < 0:
        slot += 4
    G = read(particles.cell_F, cells.rows[slot], 0, matrix)
    V, inverse = total[0], cells.setting.frame.inverse
    factor = share * ((lane(V, 0) + lane(V, 1)) + (lane(V, 2) + lane(V, 3)))
    C = scaled(factor, cofactor(G))
    y = inverse[first] * _column(C, first)
    z = inverse[second] * _column(C, second)
    for a in range(planes):
        for i in range(4):
            to = 16 * a + 4 * i
            v = (-y if i < 2 else y) + (-z if i % 2 == 0 else z)
            if three:
                x = inverse[0] * _column(C, 0)
                v = v + (-x if a == 0 else x)
            store(f, to, load(f, to) + v)


@inlined
def _column(C, j):
    """Column `j` of a row-major matrix, as a vector behind a zero."""
    if len(C) == 4:
        return pack(0.0, C[j], C[2 + j], 0.0)
    return pack(0.0, C[j], C[3 + j], C[6 + j])
