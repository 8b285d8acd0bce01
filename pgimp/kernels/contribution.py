"""What one particle adds to the sums of the grid: mass, momentum, stress."""

from typing import NamedTuple

from pgimp.jit.algebra import determinant
from pgimp.jit.kernel import specialise
from pgimp.jit.simd import pack
from pgimp.jit.tuples import read, scaled
from pgimp.kernels.clearance import moment, wall
from pgimp.kernels.piola import kept_force
from pgimp.kernels.place import deformation, is_initial
from pgimp.kernels.viscosity import viscous_pressure


class VolumeSums(NamedTuple):
    """What stands for the loads where volumes are summed in place of masses.

    The sums are then V_p and V_p (b + 1), b being the number of the particle's body, and those of
    the forces V_p grad S, the integral of S over the surface with its outward normal. The fields
    are those of `Loads`.
    """

    viscosity: tuple[()] = ()
    tractions: tuple[()] = ()
    force: tuple[()] = ()
    relaxation: tuple[()] = ()
    affine: tuple[()] = ()
    walls: tuple[()] = ()


def contribution(loads, frame, particles, p, forces, j):
    """What a particle adds to the sums of vertices, times its weights, as vectors.

    Particle `p` is number `j` of a batch; `forces` is what `keep_forces` has kept of that.

    Returns
    -------
    A : Vec4
        (m_p, m_p v_p), for (21) and (22).
    S : tuple of Vec4
        For each direction i the column (m_p w_i, -V_p (sigma_xi, sigma_yi, sigma_zi)), for (16),
        the stress less the viscous pressure (45); w is what `pgimp.kernels.clearance` wants.
        In the initial configuration (0, -V0_p (P_xi, P_yi, P_zi)).
    """


def _mass_and_momentum(m, p):
    """The vector (m, p)."""


@specialise(_mass_and_momentum)
def _mass_and_momentum_of(m, p):
    one = lambda m, p: pack(m, p[0], 0.0, 0.0)  # noqa: E731
    two = lambda m, p: pack(m, p[0], p[1], 0.0)  # noqa: E731
    three = lambda m, p: pack(m, p[0], p[1], p[2])  # noqa: E731
    return (one, two, three)[len(p) - 1]


def _outward(V, like):
    """Vectors V (0, e_i) of as many directions as `like` has."""


@specialise(_outward)
def _outward_along(V, like):
    one = lambda V, like: (pack(0.0, V, 0.0, 0.0),)  # noqa: E731
    two = lambda V, like: (*_outward(V, like[:1]), pack(0.0, 0.0, V, 0.0))  # noqa: E731
    three = lambda V, like: (*_outward(V, like[:2]), pack(0.0, 0.0, 0.0, V))  # noqa: E731
    return (one, two, three)[len(like) - 1]


@specialise(contribution)
def _contribution(loads, frame, particles, p, forces, j):
    D = len(frame.types[0])
    if loads.instance_class is VolumeSums:

        def volumes(loads, frame, particles, p, forces, j):
            V = particles.V0[p] * determinant(deformation(frame, particles, p))
            return pack(V, V * (particles.body[p] + 1), 0.0, 0.0), _outward(V, frame.origin)

        return volumes
    if is_initial(frame):

        def initial(loads, frame, particles, p, forces, j):
            m = particles.m[p]
            v = scaled(m, read(particles.v, p, 0, frame.origin))
            return _mass_and_momentum(m, v), kept_force(forces, j, frame.origin)

        return initial
    if D == 1:

        def contribution1(loads, frame, particles, p, forces, j):
            m = particles.m[p]
            V = -particles.V[p]
            q = viscous_pressure(loads.viscosity, particles, p)
            mx = moment(wall(loads.walls, 0), particles, p, 0)
            return pack(m, m * particles.v[p, 0], 0.0, 0.0), (
                pack(mx, V * (particles.sigma[p, 0] - q), 0.0, 0.0),
            )

        return contribution1
    if D == 2:

        def contribution2(loads, frame, particles, p, forces, j):
            m = particles.m[p]
            V = -particles.V[p]
            q = viscous_pressure(loads.viscosity, particles, p)
            s = particles.sigma
            xy = V * s[p, 3]
            return pack(m, m * particles.v[p, 0], m * particles.v[p, 1], 0.0), (
                pack(moment(wall(loads.walls, 0), particles, p, 0), V * (s[p, 0] - q), xy, 0.0),
                pack(moment(wall(loads.walls, 1), particles, p, 1), xy, V * (s[p, 1] - q), 0.0),
            )

        return contribution2

    def contribution3(loads, frame, particles, p, forces, j):
        m = particles.m[p]
        V = -particles.V[p]
        q = viscous_pressure(loads.viscosity, particles, p)
        v = particles.v
        s = particles.sigma
        xy = V * s[p, 3]
        yz = V * s[p, 4]
        xz = V * s[p, 5]
        return pack(m, m * v[p, 0], m * v[p, 1], m * v[p, 2]), (
            pack(moment(wall(loads.walls, 0), particles, p, 0), V * (s[p, 0] - q), xy, xz),
            pack(moment(wall(loads.walls, 1), particles, p, 1), xy, V * (s[p, 1] - q), yz),
            pack(moment(wall(loads.walls, 2), particles, p, 2), xz, yz, V * (s[p, 2] - q)),
        )

    return contribution3
