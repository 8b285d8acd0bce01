"""What one particle carries to the grid: mass, momentum and its variation in space, stress."""

from pgimp.kernels.jit import specialise
from pgimp.kernels.simd import pack
from pgimp.kernels.viscosity import viscous_pressure


def charges(frame, viscosity, particles, p):
    """What a particle carries to the grid, as vectors.

    Returns
    -------
    A : Vec4
        (m_p, m_p v_p), for (21) and (22).
    S : tuple of Vec4
        For each direction i the column -V_p (0, sigma_xi, sigma_yi, sigma_zi), for (16), the
        stress less the viscous pressure (45).
    """


@specialise(charges)
def _charges(frame, viscosity, particles, p):
    D = len(frame.types[0])
    if D == 1:

        def charges1(frame, viscosity, particles, p):
            m = particles.m[p]
            V = -particles.V[p]
            q = viscous_pressure(viscosity, particles, p)
            return pack(m, m * particles.v[p, 0], 0.0, 0.0), (
                pack(0.0, V * (particles.sigma[p, 0] - q), 0.0, 0.0),
            )

        return charges1
    if D == 2:

        def charges2(frame, viscosity, particles, p):
            m = particles.m[p]
            V = -particles.V[p]
            q = viscous_pressure(viscosity, particles, p)
            s = particles.sigma
            xy = V * s[p, 3]
            return pack(m, m * particles.v[p, 0], m * particles.v[p, 1], 0.0), (
                pack(0.0, V * (s[p, 0] - q), xy, 0.0),
                pack(0.0, xy, V * (s[p, 1] - q), 0.0),
            )

        return charges2

    def charges3(frame, viscosity, particles, p):
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

    return charges3


def slopes(affine, frame, particles, p):
    """How a particle's momentum varies in space: m_p dv/dx_i for each direction; () if it does not.

    With it, a vertex gets m_p (v_p + L_p (x_v - x_p)) S_vp. The particle's momentum remains, since
    the arms' weighted sum is zero, and fields that are linear arrive as they are up to the surface.
    """


@specialise(slopes)
def _slopes(affine, frame, particles, p):
    D = len(frame.types[0])
    if hasattr(affine, "count"):  # ()
        return lambda affine, frame, particles, p: ()

    def slopes1(affine, frame, particles, p):
        return (pack(0.0, particles.m[p] * particles.L[p, 0], 0.0, 0.0),)

    def slopes2(affine, frame, particles, p):
        m, L = particles.m[p], particles.L
        return (
            pack(0.0, m * L[p, 0], m * L[p, 2], 0.0),
            pack(0.0, m * L[p, 1], m * L[p, 3], 0.0),
        )

    def slopes3(affine, frame, particles, p):
        m, L = particles.m[p], particles.L
        return (
            pack(0.0, m * L[p, 0], m * L[p, 3], m * L[p, 6]),
            pack(0.0, m * L[p, 1], m * L[p, 4], m * L[p, 7]),
            pack(0.0, m * L[p, 2], m * L[p, 5], m * L[p, 8]),
        )

    return (slopes1, slopes2, slopes3)[D - 1]
