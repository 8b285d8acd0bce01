"""Half-widths of chi_p that are constant, or follow the deformation: bases of parameters."""

from math import sqrt
from typing import NamedTuple

from pgimp.jit.kernel import exact
from pgimp.jit.tuples import three

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
    D = len(half0)
    initial = tuple(half0[d] * cell[d] for d in range(D))
    rows = tuple(three(tuple(F[D * i + j] * initial[j] for j in range(D))) for i in range(D))
    half = tuple(sqrt(a * a + b * b + c * c) / h for (a, b, c), h in zip(rows, cell, strict=True))
    return tuple(min(each, LARGEST) for each in half), max(half)


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
