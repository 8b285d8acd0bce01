"""Shift of particles to free space, closing of gaps, null modes of J and v; see `filling`.

An isolated particle of spray carries spin, but no stretch. It has no shape that would bear one. Its
pressure holds its volume only, and differs between directions, as vertices have more or less of its
mass. Stretched by a along x and pressed by a along y it would gain da/dt up to a^2, until it is
pressed to nothing.
"""

from pgimp.jit.algebra import determinant
from pgimp.jit.functions import exp, power
from pgimp.jit.kernel import inlined, is_empty, is_record
from pgimp.jit.tuples import plus_first, scaled, three
from pgimp.jit.vectors.rows import transpose
from pgimp.jit.vectors.simd import lane, load, pack, store
from pgimp.kernels.data.ledger import CARRIED, ROOM
from pgimp.kernels.data.velocity_fields import field_of
from pgimp.kernels.flows.calming import keep_gain, with_gains
from pgimp.kernels.flows.filling import EXCESS, FIELD, OVERLAP, SURPLUS
from pgimp.kernels.grid.position_limits import free_part
from pgimp.kernels.transfer.first_vertex import deformation, is_initial
from pgimp.kernels.transfer.gather import gather
from pgimp.kernels.transfer.lane_io import LANES
from pgimp.kernels.transfer.supports import first_offset, supports
from pgimp.kernels.transfer.transfer import Support
from pgimp.physics.shapes.base import by_corners

#: phi up to which a neighbourhood counts as one at a free surface, where gaps of soil remain.
FREE = 0.9

#: phi - 1 from which voids of fluids close at their full rate. If voids closed in neighbourhoods
#: just full, the rest would hold more space than it fills: a dam break would end 5 % too high.
OVERFULL = 0.05

#: Filled part of a cell round an isolated particle, at most; no more than its volume, too.
ALONE = 0.25

#: The greatest shift of a particle at once, in cells, by direction.
MAX_SHIFT = 0.1

#: Offset of the velocities' gains in the scratch, behind shifts.
GAINS = 16


@inlined
def refill(forcing, setting, field, particles, four, buffers, moved, ledger):
    """Shift four particles, close their gaps, relax J and their null modes.

    Parameters
    ----------
    forcing, setting, field, particles, four
        See `Forcing`, `KernelScene`, `Field`, `Particles`, `FourParticles`; the filling belongs to
        the step's beginning.
    buffers : tuple
        Their supports, and scratch.
    moved : tuple
        Positions, deformation gradients and velocities, tuples of D, D*D and D Vec4.
    ledger : Ledger
        Work grows by the work of gravity; volumes grow by the particles' volumes.

    Returns
    -------
    x, F, v
        Positions, deformation gradients and velocities after the shift.
    """
    frame = setting.frame
    filling = forcing.filling
    if not is_record(filling) or is_initial(frame):
        return moved
    D = len(frame.origin)
    part = 1.0 / D
    (x, F, v), filling, gravity = moved, forcing.filling, forcing.gravity
    if not filling.due:
        return x, F, v
    buffer, scratch = buffers
    shape, frame, stride = setting.shape, setting.frame, filling.window.stride
    _find_corners(shape, frame, filling.window, particles, four, buffer)
    for j in range(LANES):
        if j >= four.size:  # the last one once more
            store(scratch, 4 * j, load(scratch, 4 * j - 4))
            store(scratch, GAINS + 4 * j, load(scratch, GAINS + 4 * j - 4))
            continue
        p = four.rows[j]
        body = particles.body[p]
        if not filling.shift[body] > 0.0:
            store(scratch, 4 * j, pack(0.0, 0.0, 0.0, 1.0))
            store(scratch, GAINS + 4 * j, pack(0.0, 0.0, 0.0, 0.0))
            continue
        offset = four.layer * stride[0] + first_offset(buffer, j)
        offset += _to_field(shape, filling.window, field.window, particles, p)
        U, A, slopes, _ = gather(
            shape, filling.G, Support(buffer, j), offset, stride, frame.origin, (), ()
        )
        keep_gain(filling.calming, frame, particles, p, A, scratch, GAINS + 4 * j)
        step = _steps(slopes, frame.cell, filling.shift[body])
        step = free_part(forcing.constraints, particles, p, step)
        J = determinant(deformation(frame, particles, p))
        full = min(max((lane(U, SURPLUS) + 1.0 - FREE) / (1.0 - FREE), 0.0), 1.0)
        gap, most = filling.gap[body], J
        if gap >= 0:
            closed = filling.closed[body] * full * particles.state[p, gap]
            particles.state[p, gap] -= closed
            lost, most = J * (1.0 - exp(-closed)), J * exp(-particles.state[p, gap] - closed)
        else:
            for d, slope in enumerate(slopes):
                particles.slope[p, d] = lane(slope, FIELD)
            _keep_spin(forcing.loads.affine, frame, particles, p, lane(U, SURPLUS) + 1.0)
            most = filling.most[body]
            lost = filling.relaxed[body] * (J - lane(U, FIELD))
            if J > most:
                over = min(max(lane(U, SURPLUS) / OVERFULL, 0.0), 1.0)
                lost = filling.closed[body] * over * (J - min(lane(U, FIELD), most))
        store(scratch, 4 * j, pack(step[0], step[1], step[2], power((J - lost) / J, part)))
        along = gravity[0] * step[0] + gravity[1] * step[1] + gravity[2] * step[2]
        ledger.work[four.layer] += particles.m[p] * along
        V = min(J, most) * particles.V0[p]
        filled = ledger.filled[four.layer, body]
        filled[CARRIED] += V
        filled[ROOM] += V * (1.0 - lane(U, OVERLAP))
    S = transpose(load(scratch, 0), load(scratch, 4), load(scratch, 8), load(scratch, 12))
    return plus_first(x, S), scaled(S[3], F), with_gains(filling.calming, v, scratch, GAINS)


@inlined
def _find_corners(shape, frame, window, particles, four, buffer):
    """Find the offsets of corners anew: planes are apart as in another window."""
    if by_corners(shape):
        return supports(shape, frame, window, particles, four.rows, four.number, buffer, ())
    return None


@inlined
def _to_field(shape, window, other, particles, p):
    """Difference of offsets of particle `p` between the `other` window and its field."""
    if by_corners(shape):
        return 0
    return field_of(window, particles, p) - field_of(other, particles, p)


@inlined
def _steps(slopes, cell, shift):
    """The shift of a particle along x, y, z, zero where the scene has no such direction."""
    return three(tuple(_limited(slopes[d], cell[d], shift) for d in range(len(cell))))


@inlined
def _limited(slope, side, shift):
    """Minus `shift` times the gradient of EXCESS by cells, at most MAX_SHIFT of a `side`."""
    return side * min(max(-shift * side * lane(slope, EXCESS), -MAX_SHIFT), MAX_SHIFT)


@inlined
def _keep_spin(affine, frame, particles, p, filled):
    """Reduce the velocity gradient of an isolated particle `p` to its spin."""
    if is_empty(affine):
        return None
    D, cell, L = len(frame.cell), 1.0, particles.L
    for d in range(D):
        cell *= frame.cell[d]
    if filled * cell < min(particles.V0[p], ALONE * cell):
        for i in range(D):
            L[p, i * D + i] = 0.0
            for j in range(i):
                spin = 0.5 * (L[p, i * D + j] - L[p, j * D + i])
                L[p, i * D + j], L[p, j * D + i] = spin, -spin
