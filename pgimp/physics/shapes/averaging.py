"""Part of the consistent mass in the averaged mass, see `pgimp.kernels.lagrangian.averaged_mass`.

Measured by ``scripts/waves numbers``, from plane waves of 6 to 13 cells in all directions, P and S
alike. In 2D and 3D nine tenths of what is best: hardly less accurate, and steps may be longer.
"""

from __future__ import annotations

#: By shape, dimensions, and particles per cell along each direction: (a, b) of the part
#: a - b C^2 with the Courant number C, as steps in time make waves faster.
PARTS: dict[str, dict[int, dict[int, tuple[float, float]]]] = {
    "gimp": {
        1: {1: (0.374, 0.377), 2: (0.5, 0.5), 3: (0.534, 0.54), 4: (0.55, 0.562)},
        2: {1: (0.491, 0.222), 2: (0.53, 0.284), 3: (0.54, 0.304), 4: (0.544, 0.304)},
        3: {1: (0.561, 0.219), 2: (0.61, 0.286), 3: (0.622, 0.302)},
    },
    "bspline-quadratic": {
        1: {1: (0.374, 0.377), 2: (1.0, 0.0)},
        2: {1: (0.491, 0.222), 2: (0.9, 0.0)},
        3: {1: (0.561, 0.219), 2: (0.9, 0.0)},
    },
    "fuzzy-nearest": {
        1: {1: (1.0, 0.0), 2: (1.09, 0.521), 3: (0.964, 0.551), 4: (0.88, 0.562)},
        2: {1: (0.9, 0.0), 2: (0.925, 0.263), 3: (0.843, 0.297), 4: (0.784, 0.302)},
        3: {1: (0.9, 0.0), 2: (0.939, 0.263), 3: (0.873, 0.293)},
    },
    "fuzzy-constant": {1: {1: (1.0, 0.0)}, 2: {1: (0.9, 0.0)}, 3: {1: (0.9, 0.0)}},
}

#: Shapes whose weights at the start are those of another one, on the lattice.
_LIKE = {
    "mpm": "gimp",
    "finite-gimp": "gimp",
    "cpdi": "gimp",
    "cpdi-corners": "gimp",
    "bspline-cubic": "fuzzy-constant",
}


def averaged_part(shape: str, per_cell: tuple[int, ...], courant: float) -> float:
    """Return alpha, from 0 to 1.

    Parameters
    ----------
    shape : str
        Name of the shape of the particles.
    per_cell : tuple of int
        Particles per cell along each direction, of which the greatest number counts.
    courant : float
        Courant number of the body's waves.
    """
    known = PARTS[_LIKE.get(shape, shape)][len(per_cell)]
    a, b = known[min(max(per_cell), max(known))]
    return min(max(a - b * courant**2, 0.0), 1.0)
