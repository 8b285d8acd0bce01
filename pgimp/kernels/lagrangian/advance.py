"""Deformation, stress and state of lattice particles after a step: materials with a memory.

F follows from the vertices' displacements, and L from its change: (1 + dt L) F is the new F.
"""

from typing import Any, NamedTuple

from pgimp.jit.algebra import determinant, inverse, multiply
from pgimp.jit.kernel import inlined, kernel
from pgimp.jit.tuples import plus_scaled, scaled
from pgimp.jit.vectors.lanes import and_finite, and_positive, of_lane, vectors, with_lanes
from pgimp.jit.vectors.simd import bits, lane, load, vector, where
from pgimp.kernels.data.motion import KEPT_MASS
from pgimp.kernels.lagrangian.cell_derivatives import (
    deformations_of_four,
    derivative_buffers,
    derive_across,
    derive_slice,
    load_corners,
    sizes_of,
)
from pgimp.kernels.lagrangian.cells import note_errors, raise_rate
from pgimp.kernels.lagrangian.stored_stress import averages, four_slots
from pgimp.kernels.transfer.lane_io import deformations, put, put_row, take, take_row
from pgimp.kernels.update.deformation import side
from pgimp.kernels.update.mean_dilatation_lagrangian import MIN_FILL
from pgimp.kernels.update.speed import grid_speed
from pgimp.kernels.update.stress import keep_state, margins, update_stress
from pgimp.kernels.update.varying import substitute_parameters
from pgimp.kernels.update.viscosity import update_viscous_pressure


class _Past(NamedTuple):
    """Length of the step that has ended, and the loads; as `Forcing` for `update_stress`."""

    dt: float
    loads: Any


@kernel
def advance_cells(cells, field, particles, dt):
    """Set F, V, stress and state of the particles in cells at the end of a step.

    Parameters
    ----------
    cells, field, particles
        See `Cells`, `Field`, `Particles`; the field has the vertices' motion after the step.
    dt : float
        Length of the step.
    """
    _advance(cells, field, particles, dt)


@inlined
def _advance(cells, field, particles, dt):
    """See `advance_cells`."""
    D, slices, _, _, groups, _, first, second = sizes_of(cells)
    setting, loads, window = cells.setting, cells.loads, field.window
    strides = window.stride[0], window.stride[first], window.stride[second]
    past = _Past(dt, loads)
    h, fastest = 0.0, vector(0.0)
    for d in range(D):
        h = max(h, setting.frame.inverse[d])
    buffers = derivative_buffers()
    for layer in range(len(cells.start) - 1):
        for cell in range(cells.start[layer], cells.start[layer + 1]):
            at, k = layer * strides[0] + cells.place[cell], cells.material[cell]
            material = (k, k, k, k)
            load_corners(cells, field.motion.values, at, strides, buffers.u)
            derive_across(cells, buffers)
            centre = _centre(loads, setting.frame, buffers.u)
            for q in range(slices):
                derive_slice(cells, q, buffers)
                for group in range(groups):
                    slot = 4 * ((cell * slices + q) * groups + group)
                    if cells.rows[slot] < 0:
                        continue
                    rows, V = four_slots(cells.rows, slot), load(cells.volumes, slot)
                    F = deformations_of_four(cells, buffers, group)
                    present = bits(V > 0.0)
                    if present != 15:
                        F = _repeated(F, present)
                    F = _swollen(centre, setting.frame, particles, rows, F)
                    before = deformations(setting.frame, particles, rows)
                    change = plus_scaled(-1.0, before, F)
                    L = multiply(scaled(1.0 / dt, change), inverse(before))
                    J = determinant(F)
                    own = substitute_parameters(setting, particles, rows)
                    sigma, state = update_stress(own, past, particles, rows, material, F, J, L)
                    put_row(particles.F, rows, 0, F)
                    put_row(particles.sigma, rows, 0, sigma)
                    keep_state(particles, rows, state)
                    if setting.tracked:
                        put(particles.V, rows, J * take(particles.V0, rows))
                    extra = update_viscous_pressure(
                        loads.viscosity, own, material, particles, rows, F, J, L
                    )
                    if cells.controlled:
                        c = grid_speed(own, True, material, ((), F, J, state), h, extra)
                        fastest = max(c * h, fastest)
                    margin = margins(own, material, F, J, sigma, state)
                    sound = bits(and_positive(and_finite(J > 0.0, state), margin))
                    if sound != 15:
                        note_errors(cells, V, sound, slot)
    raise_rate(cells, fastest)


@inlined
def _repeated(F, present):
    """Matrices of four particles with the first present one's in slots without a particle."""
    source = 0
    while present >> source & 1 == 0:
        source += 1
    first = of_lane(F, source)
    for j in range(4):
        if present >> j & 1 == 0:
            F = with_lanes(F, j, first)
    return F


@inlined
def _centre(loads, frame, u):
    """Mean of the masses of a cell's corners, and the deformation gradient G at its centre.

    () without mean dilatation.
    """
    if not averages(loads):
        return ()
    if len(frame.origin) == 2:
        low, left = load(u, 0) + load(u, 4), load(u, 0) + load(u, 8)
        high, right = load(u, 8) + load(u, 12), load(u, 4) + load(u, 12)
        X = 0.5 * frame.inverse[0] * (high - low)
        Y = 0.5 * frame.inverse[1] * (right - left)
        mass = 0.25 * lane(low + high, KEPT_MASS)
        return mass, (1.0 + lane(X, 1), lane(Y, 1), lane(X, 2), 1.0 + lane(Y, 2))
    a = (load(u, 0) + load(u, 4)) + (load(u, 8) + load(u, 12))
    b = (load(u, 16) + load(u, 20)) + (load(u, 24) + load(u, 28))
    c = (load(u, 0) + load(u, 4)) + (load(u, 16) + load(u, 20))
    d = (load(u, 8) + load(u, 12)) + (load(u, 24) + load(u, 28))
    e = (load(u, 0) + load(u, 8)) + (load(u, 16) + load(u, 24))
    f = (load(u, 4) + load(u, 12)) + (load(u, 20) + load(u, 28))
    X = 0.25 * frame.inverse[0] * (b - a)
    Y = 0.25 * frame.inverse[1] * (d - c)
    Z = 0.25 * frame.inverse[2] * (f - e)
    mass = 0.125 * lane(a + b, KEPT_MASS)
    return mass, (
        1.0 + lane(X, 1), lane(Y, 1), lane(Z, 1), lane(X, 2), 1.0 + lane(Y, 2), lane(Z, 2),
        lane(X, 3), lane(Y, 3), 1.0 + lane(Z, 3),
    )  # fmt: skip


@inlined
def _swollen(centre, frame, particles, rows, F):
    """Deformation gradients r F of four particles for their material; r = 1 without means.

    See `pgimp.kernels.update.mean_dilatation_lagrangian`, whose columns it sets.
    """
    if len(centre) == 0:
        return F
    D = len(frame.origin)
    least = MIN_FILL**D
    mass, G = centre
    put_row(particles.cell_F, rows, 0, vectors(G))
    held = mass * take(particles.V0, rows)
    for d in range(D):
        held = held * frame.inverse[d]
    was = take_row(particles.isolation, rows, 0, (0.0,))[0]
    isolation = where(held < least * take(particles.m, rows), 1.0, was)
    put_row(particles.isolation, rows, 0, (isolation,))
    swelling = max(determinant(G) / determinant(F), 0.0)  # an inverted one has none
    was = take_row(particles.fbar_ratio, rows, 0, (0.0,))[0]
    now = where(isolation > 0.0, was, side(swelling, F))
    put_row(particles.fbar_ratio, rows, 0, (now,))
    return scaled(now, F)
