"""Contribution of a particle to the sums of the grid: mass, momentum, stress."""

from pgimp.jit.kernel import inlined
from pgimp.jit.tuples import read, scaled, three
from pgimp.jit.vectors.simd import pack
from pgimp.kernels.loads.wall_gap import moment, wall
from pgimp.kernels.transfer.first_vertex import is_axial, is_initial
from pgimp.kernels.update.mean_dilatation import set_apart
from pgimp.kernels.update.piola import kept_force, kept_hoop
from pgimp.kernels.update.viscosity import viscous_pressure

#: Place of a shear stress, by the sum of its directions.
_SHEAR = (0, 3, 5, 4)


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
    m = particles.m[p]
    A = pack(m, *three(scaled(m, read(particles.v, p, 0, frame.origin))))
    if is_initial(frame):
        return A, kept_force(forces, 0, j, frame.origin)
    V, s = -particles.V[p], particles.sigma
    if D == 1:
        q = viscous_pressure(loads.viscosity, particles, p)
    else:
        q = set_apart(loads, frame, particles, p)
    rows = tuple(
        tuple(V * (s[p, i] - q) if i == k else V * s[p, _SHEAR[i + k]] for k in range(D))
        for i in range(D)
    )
    return A, tuple(
        pack(moment(wall(loads.approached, i), particles, p, i), *three(row))
        for i, row in enumerate(rows)
    )


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
