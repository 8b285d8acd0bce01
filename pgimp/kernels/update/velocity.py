"""Velocities (27) and positions (26) of particles from the grid's motion."""

from pgimp.jit.kernel import inlined, is_empty
from pgimp.jit.tuples import plus_scaled
from pgimp.kernels.grid.constraints import constrain_particles
from pgimp.kernels.grid.resting import settle
from pgimp.kernels.loads.loads import relaxed
from pgimp.kernels.transfer.first_vertex import is_initial
from pgimp.kernels.transfer.lane_io import take_row
from pgimp.kernels.transfer.rings import ring_motion


@inlined
def update_velocity(frame, forcing, particles, four, gathered, ledger):
    """Velocities of four particles after a step, and velocities of their motion.

    Parameters
    ----------
    frame, forcing, particles, four, ledger
        See `Frame`, `Forcing`, `Particles`, `FourParticles`, `Ledger`.
    gathered : tuple
        The grid's velocity and acceleration at their positions, and the hoop's sums; see
        `take_from_grid`.

    Returns
    -------
    u, v : tuple of D Vec4
        The velocity of their motion, and their own.
    """
    if is_initial(frame):
        return (ring_motion(frame, particles, four, gathered[2], gathered[0]), gathered[0])
    u, a, hoop = gathered
    v = new_velocity(forcing, particles, four.rows, u, a)
    v = settle(forcing.loads.rest, frame, forcing, particles, four, (v, u), ledger)
    u = ring_motion(frame, particles, four, hoop, u)
    return constrain_particles(forcing.constraints, particles, four, u, v, ledger)


@inlined
def new_velocity(forcing, particles, rows, u, a):
    """Velocities of four particles (27), relaxed; those that a phase has found, if any."""
    if not is_empty(forcing.phase):
        return take_row(forcing.phase.velocities, rows, 0, u)
    v = plus_scaled(forcing.dt, a, take_row(particles.v, rows, 0, u))
    return relaxed(forcing.loads.relaxation, forcing.dt, v, u)


@inlined
def update_position(forcing, particles, four, u):
    """Positions of four particles after a step, moving at `u` (26)."""
    return plus_scaled(forcing.dt, u, take_row(particles.x, four.rows, 0, u))
