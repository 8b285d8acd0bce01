"""Deformation gradients and volumes (29, 30).

Materials that flow may shear without limit: only their volume J is integrated, and F is the
isotropic J^(1/D) 1, in axisymmetry J^(1/3) 1. J grows by det(1 + dt L), as for a solid. In a rigid
rotation, whose step is 1 + dt L = R, it does not change, where exp(dt tr L) would shrink it in
every step.
"""

from math import sqrt

from pgimp.jit.algebra import determinant, inverse, multiply, one_plus
from pgimp.jit.functions import cbrt
from pgimp.jit.kernel import inlined, of_types
from pgimp.jit.tuples import on_diagonal, plus_scaled
from pgimp.jit.vectors.lanes import where_all
from pgimp.jit.vectors.simd import bits, pack, vector, where
from pgimp.kernels.transfer.first_vertex import is_initial
from pgimp.kernels.transfer.lane_io import deformations
from pgimp.physics.materials.base import volume_only

#: Change of volume in a step up to which `_cube_root` is right; steps seldom have more.
_NEAR = 0.25


@inlined
def velocity_gradients(frame, particles, four, D):
    """Velocity gradients L of four particles at the step's beginning, by current positions.

    `D` is from the grid. It is L itself or, in the initial configuration, the rate of F, the
    velocity gradient by initial positions; then L = D F^-1. Either way F after the step is
    (1 + dt L) F, to rounding.
    """
    if not is_initial(frame):
        return D
    return multiply(D, inverse(deformations(frame, particles, four.rows)))


@inlined
def update_deformation(setting, forcing, particles, four, numbers, L):
    """Deformation gradients F of four particles after a step, from velocity gradients L (29).

    Parameters
    ----------
    setting, forcing, particles, four
        See `KernelScene`, `Forcing`, `Particles`, `FourParticles`.
    numbers : tuple of 4 int
        Their materials.
    L : tuple of D*D Vec4
        Velocity gradients from the grid, see `velocity_gradients`.
    """
    flows = _flows(setting.materials)
    if is_initial(setting.frame):
        return plus_scaled(forcing.dt, L, deformations(setting.frame, particles, four.rows))
    if not any(flow for flow in flows):
        return multiply(one_plus(forcing.dt, L), deformations(setting.frame, particles, four.rows))
    if all(flow for flow in flows):
        F = deformations(setting.frame, particles, four.rows)
        return _diagonal(F[0] * side(determinant(one_plus(forcing.dt, L)), L), L)
    F = deformations(setting.frame, particles, four.rows)
    grown = one_plus(forcing.dt, L)
    kinds = pack(flows[numbers[0]], flows[numbers[1]], flows[numbers[2]], flows[numbers[3]])
    volume = _diagonal(F[0] * side(determinant(grown), L), L)
    return where_all(kinds > 0.0, volume, multiply(grown, F))


@of_types
def _flows(materials):
    """For each material 1 if it knows no more of F than the volume, else 0."""
    return tuple(float(volume_only(each.instance_class)) for each in materials)


@inlined
def side(volume, L):
    """Side of a cube of a volume near 1, in as many directions as `L` stretches.

    In 3D without division: Newton's method for volume^(-1/3).
    """
    if len(L) == 1:
        return volume
    if len(L) == 4:
        return sqrt(max(0.0, volume))  # an inverted one has none
    x = volume - 1.0
    near = abs(x) < _NEAR
    z = 1.0 - x * (1.0 / 3.0 - x * (2.0 / 9.0 - x * (14.0 / 81.0)))
    for _ in range(3):
        z = z * (4.0 / 3.0 - volume * (z * z) * (z * (1.0 / 3.0)))
    square = z * z
    y = volume * square
    found = y - (y * y * y - volume) * square * (1.0 / 3.0)
    return found if bits(near) == 15 else where(near, found, cbrt(volume))


@inlined
def _diagonal(f, like):
    """The matrix f 1."""
    return tuple(f if on_diagonal(k, like) else vector(0.0) for k in range(len(like)))
