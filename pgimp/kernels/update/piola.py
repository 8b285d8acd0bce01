"""Internal forces of the initial configuration: -V0 P grad0 S with P = J s F^-T in place of (16).

P, the first Piola-Kirchhoff stress, is the force per unit of initial area. J F^-T is the cofactor
matrix of F, which needs no division. It is computed for four particles at a time, and kept on the
stack for the transfers, which take one after the other.
"""

from math import isqrt

from pgimp.jit.algebra import cofactor, full, multiply, trace
from pgimp.jit.kernel import inlined, is_empty, is_record
from pgimp.jit.tuples import plus_scaled, scaled
from pgimp.jit.vectors.rows import transpose
from pgimp.jit.vectors.simd import load, number, pack, store, vector
from pgimp.kernels.transfer.first_vertex import is_axial, is_initial, is_plate, undeformed
from pgimp.kernels.transfer.lane_io import deformations, take, take_row
from pgimp.physics.shapes.base import by_parts

#: Offset in the buffer of the forces by cells, see
#: `pgimp.kernels.update.mean_dilatation_lagrangian`.
BY_CELLS = 48

#: Offset of the forces of hoops, behind the columns of two directions.
_HOOP = 32

#: Numbers in the buffer: for each direction a vector a particle, and as many by cells.
PIOLA_SIZE = 96


@inlined
def less_pressure(viscosity, particles, rows, sigma):
    """Stresses of four particles less the viscous pressure (45)."""
    if not is_record(viscosity):
        return sigma
    q = take_row(particles.q, rows, 0, (0.0,))[0]
    return (sigma[0] - q, sigma[1] - q, sigma[2] - q, *sigma[3:])


@inlined
def keep_vectors(buffer, at, first, second, third):
    """Store the vectors (0, first, second, third) of four particles in the buffer."""
    V = transpose(vector(0.0), vector(first), vector(second), vector(third))
    for j, each in enumerate(V):
        store(buffer, at + 4 * j, each)


@inlined
def keep_columns(buffer, at, P):
    """Store the columns of row-major matrices of four particles in the buffer, from `at` on."""
    if len(P) == 5:
        store(buffer, at + _HOOP, P[4])
    D = isqrt(len(P))
    columns = tuple(P[d : D * D : D] + (0.0,) * (3 - D) for d in range(D))
    for d, column in enumerate(columns):
        keep_vectors(buffer, at + 16 * d, *column)


@inlined
def keep_forces(loads, layout, particles, rows, buffer):
    """Store -V0 P of four particles, less viscosity's, in a buffer of `PIOLA_SIZE` float64.

    With `mean_lagrangian` also the forces by cells; those of parts of cells are among the others.
    Nothing is done in the current configuration. `layout` is the shape and the frame.
    """
    shape, frame = layout
    if not is_initial(frame):
        return None
    D = len(frame.origin)
    like, matrix = (0.0,) * (3, 4, 6)[D - 1], (0.0,) * len(undeformed(frame))
    sigma = take_row(particles.sigma, rows, 0, like)
    sigma = less_pressure(loads.viscosity, particles, rows, sigma)
    if is_empty(loads.mean_lagrangian):
        P = multiply(stresses(frame, sigma), cofactor(deformations(frame, particles, rows)))
        keep_columns(buffer, 0, scaled(-take(particles.V0, rows), P))
        return
    part = 1.0 / (3 if len(matrix) > 4 else D)
    in_company = part * (1.0 - take_row(particles.isolation, rows, 0, (0.0,))[0])
    mean = in_company * trace(stresses(frame, sigma))
    rest = (sigma[0] - mean, sigma[1] - mean, sigma[2] - mean, *sigma[3:])
    fbar_ratio, V = take_row(particles.fbar_ratio, rows, 0, (0.0,))[0], -take(particles.V0, rows)
    P = multiply(stresses(frame, rest), cofactor(deformations(frame, particles, rows)))
    if by_parts(shape):
        G = take_row(particles.cell_F, rows, 0, matrix)
        whole = take_row(particles.mean_stress, rows, 0, (0.0,))[0]
        P = plus_scaled(V * whole, cofactor(G), scaled(V * fbar_ratio, P))
        keep_columns(buffer, 0, P)
        return
    keep_columns(buffer, 0, scaled(V * fbar_ratio, P))
    G = take_row(particles.cell_F, rows, 0, matrix)
    keep_columns(buffer, BY_CELLS, scaled(V * mean, cofactor(G)))


@inlined
def stresses(frame, sigma):
    """Stresses as matrices, with zz where F has it."""
    if is_axial(frame) or is_plate(frame):
        return (*full(sigma), sigma[2])
    return full(sigma)


@inlined
def kept_hoop(buffer, at, j):
    """The vector (0, -V0 P_zz, 0, 0) of ring number `j` of four; `at` as in `kept_force`."""
    return pack(0.0, number(buffer, at + _HOOP + j), 0.0, 0.0)


@inlined
def kept_force(buffer, at, j, like):
    """For each direction the vector (0, -V0 P_xi, -V0 P_yi, -V0 P_zi) of number `j` of four.

    From the offset `at` on, 0 or `BY_CELLS`.
    """
    return tuple(load(buffer, at + 16 * d + 4 * j) for d in range(len(like)))
