"""Contribution of a particle to the sums of the grid: mass, momentum, stress."""

from pgimp.jit.kernel import inlined
from pgimp.jit.tuples import read, scaled
from pgimp.jit.vectors.simd import pack
from pgimp.kernels.loads.wall_gap import moment, wall
from pgimp.kernels.transfer.first_vertex import is_axial, is_initial
from pgimp.kernels.update.mean_dilatation import set_apart
from pgimp.kernels.update.piola import kept_force, kept_hoop
from pgimp.kernels.update.viscosity import viscous_pressure


@inlined
def contribution(loads, frame, particles, p, forces, j):
    """Contribution of a particle to the sums of vertices, times its weights, as vectors.

    Particle `p` is number `j` of four; `forces` is from `keep_forces`.

    Returns
    -------
    A : Vec4
        (m_p, m_p v_p), for (21) and (22).
    S : tuple of Vec4
        For each direction i the column (m_p w_i, -V_p (sigma_xi, sigma_yi, sigma_zi)), for (16).
        The stress is reduced by the viscous pressure (45), or by its mean, see `set_apart`. w is
        the moment for `pgimp.kernels.loads.wall_gap`. In the initial configuration (0, -V0_p
        (P_xi, P_yi, P_zi)).
    """
    D = len(frame.origin)
    if is_initial(frame):
        m = particles.m[p]
        v = scaled(m, read(particles.v, p, 0, frame.origin))
        return _mass_and_momentum(m, v), kept_force(forces, 0, j, frame.origin)
    m, V = particles.m[p], -particles.V[p]
    if D == 1:
        q = viscous_pressure(loads.viscosity, particles, p)
        mx = moment(wall(loads.approached, 0), particles, p, 0)
        return pack(m, m * particles.v[p, 0], 0.0, 0.0), (
            pack(mx, V * (particles.sigma[p, 0] - q), 0.0, 0.0),
        )
    q, s = set_apart(loads, frame, particles, p), particles.sigma
    if D == 2:
        xy = V * s[p, 3]
        mx = moment(wall(loads.approached, 0), particles, p, 0)
        my = moment(wall(loads.approached, 1), particles, p, 1)
        return pack(m, m * particles.v[p, 0], m * particles.v[p, 1], 0.0), (
            pack(mx, V * (s[p, 0] - q), xy, 0.0),
            pack(my, xy, V * (s[p, 1] - q), 0.0),
        )
    v = particles.v
    xy = V * s[p, 3]
    yz = V * s[p, 4]
    xz = V * s[p, 5]
    return pack(m, m * v[p, 0], m * v[p, 1], m * v[p, 2]), (
        pack(moment(wall(loads.approached, 0), particles, p, 0), V * (s[p, 0] - q), xy, xz),
        pack(moment(wall(loads.approached, 1), particles, p, 1), xy, V * (s[p, 1] - q), yz),
        pack(moment(wall(loads.approached, 2), particles, p, 2), xz, yz, V * (s[p, 2] - q)),
    )


@inlined
def _mass_and_momentum(m, p):
    """The vector (m, p)."""
    if len(p) == 1:
        return pack(m, p[0], 0.0, 0.0)
    if len(p) == 2:
        return pack(m, p[0], p[1], 0.0)
    return pack(m, p[0], p[1], p[2])


@inlined
def hoop_force(loads, frame, particles, p, forces, j):
    """The vector (m_p w_x, -V_p sigma_zz, 0, 0) of a ring, times T the hoop's part of its sums.

    () outside of axisymmetry.
    """
    if not is_axial(frame):
        return ()
    if is_initial(frame):
        return kept_hoop(forces, 0, j)
    hoop = particles.sigma[p, 2] - set_apart(loads, frame, particles, p)
    spread = moment(wall(loads.approached, 0), particles, p, 0)
    return pack(spread, -particles.V[p] * hoop, 0.0, 0.0)
