"""Sums over the vertices of grips that a given force moves."""

from pgimp.jit.kernel import kernel
from pgimp.kernels.data.motion import grid_rate, keeps, velocity_before
from pgimp.kernels.data.record import ACCELERATION, MASS, RECORD, VELOCITY
from pgimp.kernels.data.velocity_fields import field_size
from pgimp.kernels.loads.loads import relaxed_part

#: Sums of a grip along a direction: mass; mass times its relaxed part, see `relaxed_part`;
#: momentum that the particles gain in the step, had the vertices no grip.
GRIP_MASS, RELAXED_MASS, GAINED, GRIPPED = 0, 1, 2, 3


@kernel
def sum_grips(field, forcing, controls, A, reach, sums):
    """Set the sums of grips by plane, before constraints.

    Parameters
    ----------
    field, forcing
        As in `update_momentum`; its constraints are those with a given velocity.
    controls : (constraints, 3) int64
        1 where a given force moves a constraint, 2 where its velocity is given, else 0. Where
        constraints share a vertex, the last one counts, as in `constrained_velocity`.
    A, reach
        Empty and 0 after the momentum update. Before it accelerations of vertices that keep their
        motion, see `pgimp.kernels.lagrangian.averaged_mass.average_forces`.
    sums : (planes, constraints, 3, GRIPPED) float64
        Zeros.
    """
    G, active, plane = field.G, field.active, field.window.stride[0]
    mask, dt, relaxation = forcing.marked[1], forcing.dt, forcing.loads.relaxation
    size = field_size(field.window)
    for i in range(field.owned):
        if active[i] == 0:
            continue
        for r in range(i * plane, (i + 1) * plane, RECORD):
            held = mask[r // RECORD]
            m = G[r + MASS]
            if held == 0 or not m > 0.0:
                continue
            f = (r - i * plane) // size
            part = relaxed_part(grid_rate(relaxation, field.motion, f), dt)
            for d in range(3):
                last = -1
                for k in range(len(controls)):
                    if held >> k & 1 and controls[k, d] != 0:
                        last = k
                if last < 0 or controls[last, d] != 1:
                    continue
                v, a = G[r + VELOCITY + d], G[r + ACCELERATION + d]
                if len(A):
                    a = A[(reach * plane + r) // 2 + 1 + d]
                    kept = keeps(field.motion, f)
                    v = velocity_before(field.motion, kept, G, r, d, 1.0 / m) + dt * a
                sums[i, last, d, GRIP_MASS] += m
                sums[i, last, d, RELAXED_MASS] += m * part
                sums[i, last, d, GAINED] += m * ((1.0 - part) * dt * a + part * v)
