"""Mean dilatation in the initial configuration (``method.volumetric: mean``), against locking.

As in `pgimp.kernels.update.mean_dilatation` a particle has the volume change of the cells under its
box, here by deformation gradients in place of rates:

    G_p = 1 + integral of sum_v v_v dD_p/dv_v dt,    r_p^d = det G_p/det F_p.

The material gets r_p F_p, the F-bar of de Souza Neto et al. (1996) with means over cells in place
of their centres. With p the mean of the d normal components of its stress s, less viscosity's
pressure, the force is the adjoint,

    -V0_p (r_p (s - p 1) cof(r_p F_p) grad0 S_vp + p cof(G_p) dD_p/dv_v).

So its power is the power of the stress, and the energy of r_p F_p is its potential. A particle
whose cells are filled to less than `MIN_FILL`^d keeps r_p = 1. It shares them with no other, and
their vertices have hardly any mass. The filled part is the mean over them, sum_v a_v m_v over the
particle's density and the cell's volume. It is 1 inside bodies, and at least 0.5^d at surfaces
along the grid and in their corners. With two particles a cell and direction it is 0.25^d for an
isolated one. Weights are initial weights, and masses are constant until a stage removes a bonded
body. A particle that becomes isolated then keeps its r_p, and an isolated one stays so: a jump of
r_p would add strain. The particles' F is r_p F_p. G_p and r_p have columns of their own.

Of bodies that are exact to their surface G_p is the mean over what cells hold, found before
(`pgimp.solver.lagrangian.mean_dilatation`). None of their particles is isolated.
"""

from pgimp.jit.algebra import determinant, inverse, multiply, plus_diagonal
from pgimp.jit.kernel import inlined, is_empty
from pgimp.jit.tuples import plus_scaled, scaled
from pgimp.jit.vectors.simd import where
from pgimp.kernels.data.record import MASS, VELOCITY
from pgimp.kernels.transfer.first_vertex import is_axial, is_plate
from pgimp.kernels.transfer.gather import gather_products
from pgimp.kernels.transfer.gather_shared import gather_shared, row_major
from pgimp.kernels.transfer.lane_io import LANES, deformations, put_row, take, take_row
from pgimp.kernels.transfer.mean_dilatation_weights import (
    gradients_of_rings,
    means_of_parts,
    means_of_rings,
)
from pgimp.kernels.transfer.scatter import Share, scatter_products
from pgimp.kernels.transfer.supports import (
    first_offset,
    four_entries,
    keep_hoop,
    keep_support,
    share_support,
)
from pgimp.kernels.transfer.transfer import Support
from pgimp.kernels.transfer.transpose import (
    collected,
    gathered_mass,
    gradients,
    keep_sums,
    repeat_sums,
)
from pgimp.kernels.update.deformation import side, update_deformation, velocity_gradients
from pgimp.kernels.update.mean_dilatation import section
from pgimp.kernels.update.piola import BY_CELLS, kept_force, kept_hoop
from pgimp.kernels.update.plates import deform_plate
from pgimp.physics.shapes.base import by_parts

#: d-th root of the filled part of its cells from which a particle is not isolated.
MIN_FILL = 0.4


@inlined
def keep_mean_lagrangian(mean, shape, frame, buffer, weights):
    """Store supports of four particles with the weights of dD_p/dv_v in the buffer `weights`.

    Of `SUPPORT_SIZE`, from the supports in `buffer`. Nothing unless there is a `mean`, which is ()
    or a number, as everywhere here. Parts of cells need none.
    """
    if is_empty(mean):
        return None
    if by_parts(shape):
        return None
    if is_axial(frame):
        slopes, hoop = gradients_of_rings(shape, buffer)
        inverse = frame.inverse[0]
        keep_support(weights, 0, means_of_rings(shape, buffer)[0], scaled(inverse, slopes))
        keep_hoop(weights, scaled(inverse, hoop))
        _along(shape, frame, buffer, weights, 1)
    else:
        return _along(shape, frame, buffer, weights, 0)


@inlined
def _along(shape, frame, buffer, weights, first):
    """Store the weights along the directions from `first` on."""
    for d in range(first, len(frame.cell)):
        a = means_of_parts(shape, buffer, d, frame.cell[d])
        keep_support(weights, d, a, tuple(four_entries(buffer, d, 1, i) for i in range(len(a))))


@inlined
def take_mean_lagrangian(mean, layout, field, four, buffer, weights, sums):
    """Gather the input of `deform` from four particles' cells; () unless there is a `mean`.

    Parameters
    ----------
    layout, field, four, buffer, sums
        See `take_from_grid`, whose sums are overwritten.
    weights
        From `keep_mean_lagrangian`.

    Returns
    -------
    mass : Vec4
        Mean of the vertices' masses over their cells.
    C : tuple of D*D Vec4
        Gradients of the velocity, means over their cells; row-major, in axisymmetry with the hoop.
        Neither of parts of cells, for which something else is returned.
    """
    if is_empty(mean):
        return ()
    if by_parts(layout[0]):
        return (0.0,)
    if is_axial(layout[1]):
        (shape, frame), window = layout, field.window
        begin = four.layer * window.stride[0]
        for j in range(four.size):
            U, A, D, _ = gather_products(
                shape, field.G, Support(weights, j), begin + first_offset(buffer, j), window.stride,
                frame.origin, (), (0.0,),
            )  # fmt: skip
            keep_sums(sums, j, U, A, D)
        repeat_sums(sums, four.size, (0.0, 0.0, 0.0))
        hoop = collected(sums, 4, frame.origin)
        return gathered_mass(sums), (*gradients(sums, 2, frame.origin), hoop[0])
    (shape, frame), window = layout, field.window
    begin = four.layer * window.stride[0]
    if four.size == LANES and share_support(buffer):
        offset = begin + first_offset(buffer, 0) + MASS - VELOCITY
        U, _, D, _ = gather_shared(
            shape, field.G, weights, offset, window.stride, frame.origin, (0.0, *frame.origin)
        )
        return U[0], row_major(tuple(each[1:] for each in D))
    for j in range(four.size):
        U, A, D, _ = gather_products(
            shape, field.G, Support(weights, j), begin + first_offset(buffer, j), window.stride,
            frame.origin, (), (),
        )  # fmt: skip
        keep_sums(sums, j, U, A, D)
    repeat_sums(sums, four.size, frame.origin)
    return gathered_mass(sums), gradients(sums, 2, frame.origin)


@inlined
def scatter_mean_lagrangian(mean, layout, G, support, offset, stride, forces):
    """Add a particle's forces by cells to its support; nothing unless there is a `mean`.

    Parameters
    ----------
    layout
        The shape and the frame.
    G, support, offset, stride
        See `scatter`, with the weights from `keep_mean_lagrangian`.
    forces
        From `keep_forces`.
    """
    if is_empty(mean):
        return None
    if by_parts(layout[0]):
        return None
    if is_axial(layout[1]):
        shape, frame = layout
        P = kept_force(forces, BY_CELLS, support.j, frame.origin)
        H = kept_hoop(forces, BY_CELLS, support.j)
        scatter_products(shape, G, support, offset, stride, Share((), (), P, (), (), H))
        return
    shape, frame = layout
    P = kept_force(forces, BY_CELLS, support.j, frame.origin)
    scatter_products(shape, G, support, offset, stride, Share((), (), P, (), (), ()))


@inlined
def deform(cells, setting, forcing, particles, four, numbers, D):
    """Deform four particles by a step.

    Parameters
    ----------
    cells : tuple
        From `take_mean_lagrangian`.
    setting, forcing, particles, four, numbers, D
        See `update_deformation`.

    Returns
    -------
    L, F : tuple of D*D Vec4
        Velocity gradients by current positions, and F after the step, for the material. (1 + dt L)
        F is the new F, to rounding.
    """
    if is_plate(setting.frame):
        return deform_plate(setting, forcing, particles, four, numbers, D)
    if len(cells) == 0:
        return (
            velocity_gradients(setting.frame, particles, four, D),
            update_deformation(setting, forcing, particles, four, numbers, D),
        )
    frame, rows, dt = setting.frame, four.rows, forcing.dt
    fbar_ratio = take_row(particles.fbar_ratio, rows, 0, (0.0,))[0]
    before = scaled(1.0 / fbar_ratio, deformations(frame, particles, rows))
    after = plus_scaled(dt, D, before)
    G, isolation = _of_cells(cells, frame, particles, rows, dt, D)
    swelling = max(determinant(G) / determinant(after), 0.0)  # an inverted one has none
    now = where(isolation > 0.0, fbar_ratio, side(swelling, D))
    put_row(particles.fbar_ratio, rows, 0, (now,))
    L = multiply(D, inverse(before))
    e = (now / fbar_ratio - 1.0) / dt
    return plus_diagonal(scaled(1.0 + e * dt, L), e), scaled(now, after)


@inlined
def _of_cells(cells, frame, particles, rows, dt, D):
    """Deformation gradients of four particles' cells after a step, and isolation: their columns."""
    was = take_row(particles.isolation, rows, 0, (0.0,))[0]
    if len(cells) == 1:
        return take_row(particles.cell_F, rows, 0, D), was
    (mass, C), directions = cells, len(frame.origin)
    least = MIN_FILL**directions
    G = plus_scaled(dt, C, take_row(particles.cell_F, rows, 0, D))
    put_row(particles.cell_F, rows, 0, G)
    held = mass * take(particles.V0, rows)
    for d in range(directions):
        held = held * frame.inverse[d]
    held = section(frame, particles.origin, rows, held)
    isolation = where(held < least * take(particles.m, rows), 1.0, was)
    put_row(particles.isolation, rows, 0, (isolation,))
    return G, isolation
