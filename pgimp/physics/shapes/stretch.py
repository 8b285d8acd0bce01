"""Half-widths of chi_p that are constant, or follow the deformation: bases of parameters."""

from math import sqrt
from typing import NamedTuple

from pgimp.jit.kernel import exact

#: Largest half-width in cells: a particle then reaches four vertices a direction.
LARGEST = 1.0


@exact
def stretched(half0, cell, F):
    """Half-widths l_i = sqrt(sum_j (F_ij l0_j)^2), in cells, and the largest before clamping.

    The box has the second moments of the deformed box, so a cube keeps its size under rotation.
    `half0` is in cells of the initial state, `cell` the cells' size.
    """
    if len(half0) == 1:
        l0 = abs(F[0]) * half0[0]
        return (min(l0, LARGEST),), l0
    if len(half0) == 2:
        a, b = half0[0] * cell[0], half0[1] * cell[1]
        l0 = _length(F[0] * a, F[1] * b, 0.0) / cell[0]
        l1 = _length(F[2] * a, F[3] * b, 0.0) / cell[1]
        return (min(l0, LARGEST), min(l1, LARGEST)), max(l0, l1)
    a, b, c = half0[0] * cell[0], half0[1] * cell[1], half0[2] * cell[2]
    l0 = _length(F[0] * a, F[1] * b, F[2] * c) / cell[0]
    l1 = _length(F[3] * a, F[4] * b, F[5] * c) / cell[1]
    l2 = _length(F[6] * a, F[7] * b, F[8] * c) / cell[2]
    most = max(max(l0, l1), l2)
    return (min(l0, LARGEST), min(l1, LARGEST), min(l2, LARGEST)), most


@exact
def _length(a, b, c):
    """Length of a vector of three."""
    return sqrt(a * a + b * b + c * c)


class FixedSize(NamedTuple):
    """Half-widths by direction, in cells; constant in time."""

    half: tuple[float, ...]

    @staticmethod
    def size(shape, cell, F):
        """See `pgimp.physics.shapes`."""
        return shape.half, 0.0


class TrackedSize(NamedTuple):
    """Initial half-widths by direction, in cells; they follow the deformation."""

    half: tuple[float, ...]

    @staticmethod
    def size(shape, cell, F):
        """See `pgimp.physics.shapes`."""
        return stretched(shape.half, cell, F)
