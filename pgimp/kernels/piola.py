"""Internal forces of the initial configuration: -V0 P grad0 S with P = J s F^-T in place of (16).

P, the first Piola-Kirchhoff stress, is the force per unit of initial area. J F^-T is the cofactor
matrix of F, which needs no division. It is computed for four particles at a time, and is on the
stack for the transfers, which take one after the other.
"""

from pgimp.jit.algebra import cofactor, full, multiply
from pgimp.jit.kernel import specialise
from pgimp.jit.simd import load, store, vector
from pgimp.jit.simdrows import transpose
from pgimp.jit.tuples import scaled
from pgimp.kernels.fours import deformations, take, take_row
from pgimp.kernels.place import is_initial

#: Numbers in the buffer: for each direction a vector a particle.
PIOLA_SIZE = 48


def _less_pressure(viscosity, particles, rows, sigma):
    """Stresses of four particles less the viscous pressure (45)."""


@specialise(_less_pressure)
def _less_viscous_pressure(viscosity, particles, rows, sigma):
    if not hasattr(viscosity, "instance_class"):
        return lambda viscosity, particles, rows, sigma: sigma

    def less(viscosity, particles, rows, sigma):
        q = take_row(particles.q, rows, 0, (0.0,))[0]
        return (sigma[0] - q, sigma[1] - q, sigma[2] - q, *sigma[3:])

    return less


def _keep(buffer, at, first, second, third):
    """Store the vectors (0, first, second, third) of four particles in the buffer."""


@specialise(_keep)
def _keep_transposed(buffer, at, first, second, third):
    def keep(buffer, at, first, second, third):
        V = transpose(vector(0.0), vector(first), vector(second), vector(third))
        store(buffer, at, V[0])
        store(buffer, at + 4, V[1])
        store(buffer, at + 8, V[2])
        store(buffer, at + 12, V[3])

    return keep


def _keep_columns(buffer, P):
    """Store the columns of row-major matrices of four particles in the buffer."""


@specialise(_keep_columns)
def _keep_all_columns(buffer, P):
    def keep1(buffer, P):
        _keep(buffer, 0, P[0], 0.0, 0.0)

    def keep2(buffer, P):
        _keep(buffer, 0, P[0], P[2], 0.0)
        _keep(buffer, 16, P[1], P[3], 0.0)

    def keep3(buffer, P):
        _keep(buffer, 0, P[0], P[3], P[6])
        _keep(buffer, 16, P[1], P[4], P[7])
        _keep(buffer, 32, P[2], P[5], P[8])

    return {1: keep1, 4: keep2, 9: keep3}[len(P)]


def keep_forces(viscosity, frame, particles, rows, buffer):
    """Store -V0 P of four particles, less viscosity's, in a buffer of `PIOLA_SIZE` float64.

    Nothing is done in the current configuration.
    """


@specialise(keep_forces)
def _keep_forces(viscosity, frame, particles, rows, buffer):
    if not is_initial(frame):
        return lambda viscosity, frame, particles, rows, buffer: None
    like = (0.0,) * (3, 4, 6)[len(frame.types[0]) - 1]

    def keep_forces(viscosity, frame, particles, rows, buffer):
        sigma = take_row(particles.sigma, rows, 0, like)
        sigma = _less_pressure(viscosity, particles, rows, sigma)
        P = multiply(full(sigma), cofactor(deformations(frame, particles, rows)))
        _keep_columns(buffer, scaled(-take(particles.V0, rows), P))

    return keep_forces


def kept_force(buffer, j, like):
    """For each direction the vector (0, -V0 P_xi, -V0 P_yi, -V0 P_zi) of the batch's `j`."""


@specialise(kept_force)
def _kept_force(buffer, j, like):
    one = lambda buffer, j, like: (load(buffer, 4 * j),)  # noqa: E731
    two = lambda buffer, j, like: (load(buffer, 4 * j), load(buffer, 16 + 4 * j))  # noqa: E731
    three = lambda buffer, j, like: (  # noqa: E731
        load(buffer, 4 * j), load(buffer, 16 + 4 * j), load(buffer, 32 + 4 * j),
    )  # fmt: skip
    return (one, two, three)[len(like) - 1]
