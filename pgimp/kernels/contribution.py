"""What one particle adds to the sums of the grid: mass, momentum, stress."""

from pgimp.jit.kernel import specialise
from pgimp.jit.simd import pack
from pgimp.kernels.viscosity import viscous_pressure


def contribution(frame, viscosity, particles, p):
    """What a particle adds to the sums of vertices, times its weights, as vectors.

    Returns
    -------
    A : Vec4
        (m_p, m_p v_p), for (21) and (22).
    S : tuple of Vec4
        For each direction i the column -V_p (0, sigma_xi, sigma_yi, sigma_zi), for (16), the
        stress less the viscous pressure (45).
    """


@specialise(contribution)
def _contribution(frame, viscosity, particles, p):
    D = len(frame.types[0])
    if D == 1:

        def contribution1(frame, viscosity, particles, p):
            m = particles.m[p]
            V = -particles.V[p]
            q = viscous_pressure(viscosity, particles, p)
            return pack(m, m * particles.v[p, 0], 0.0, 0.0), (
                pack(0.0, V * (particles.sigma[p, 0] - q), 0.0, 0.0),
            )

        return contribution1
    if D == 2:

        def contribution2(frame, viscosity, particles, p):
            m = particles.m[p]
            V = -particles.V[p]
            q = viscous_pressure(viscosity, particles, p)
            s = particles.sigma
            xy = V * s[p, 3]
            return pack(m, m * particles.v[p, 0], m * particles.v[p, 1], 0.0), (
                pack(0.0, V * (s[p, 0] - q), xy, 0.0),
                pack(0.0, xy, V * (s[p, 1] - q), 0.0),
            )

        return contribution2

    def contribution3(frame, viscosity, particles, p):
        m = particles.m[p]
        V = -particles.V[p]
        q = viscous_pressure(viscosity, particles, p)
        v = particles.v
        s = particles.sigma
        xy = V * s[p, 3]
        yz = V * s[p, 4]
        xz = V * s[p, 5]
        return pack(m, m * v[p, 0], m * v[p, 1], m * v[p, 2]), (
            pack(0.0, V * (s[p, 0] - q), xy, xz),
            pack(0.0, xy, V * (s[p, 1] - q), yz),
            pack(0.0, xz, yz, V * (s[p, 2] - q)),
        )

    return contribution3
