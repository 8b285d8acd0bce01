"""Half-widths that follow the deformation, for the shapes whose size is tracked."""

from math import sqrt

from pgimp.kernels.jit import exact

#: Largest half-width in cells: a particle then reaches four vertices a direction.
LARGEST = 1.0


def stretched(half0, cell, F):
    """Half-widths l_i = sqrt(sum_j (F_ij l0_j)^2), in cells, and 1 if any was clamped, else 0.

    These are the half-widths of the box with the second moments of the deformed box: they keep
    their size under any rotation. `half0` is in cells of the initial state, `cell` the cells' size.
    """


@exact(stretched)
def _stretched(half0, cell, F):
    if len(half0) == 1:

        def stretched1(half0, cell, F):
            l0 = abs(F[0]) * half0[0]
            return (min(l0, LARGEST),), int(l0 > LARGEST)

        return stretched1
    if len(half0) == 2:

        def stretched2(half0, cell, F):
            a, b = half0[0] * cell[0], half0[1] * cell[1]
            l0 = sqrt((F[0] * a) ** 2 + (F[1] * b) ** 2) / cell[0]
            l1 = sqrt((F[2] * a) ** 2 + (F[3] * b) ** 2) / cell[1]
            clamped = int(max(l0, l1) > LARGEST)
            return (min(l0, LARGEST), min(l1, LARGEST)), clamped

        return stretched2

    def stretched3(half0, cell, F):
        a, b, c = half0[0] * cell[0], half0[1] * cell[1], half0[2] * cell[2]
        l0 = sqrt((F[0] * a) ** 2 + (F[1] * b) ** 2 + (F[2] * c) ** 2) / cell[0]
        l1 = sqrt((F[3] * a) ** 2 + (F[4] * b) ** 2 + (F[5] * c) ** 2) / cell[1]
        l2 = sqrt((F[6] * a) ** 2 + (F[7] * b) ** 2 + (F[8] * c) ** 2) / cell[2]
        clamped = int(max(max(l0, l1), l2) > LARGEST)
        return (min(l0, LARGEST), min(l1, LARGEST), min(l2, LARGEST)), clamped

    return stretched3
