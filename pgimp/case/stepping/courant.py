"""Largest stable Courant numbers of a case, by its shape and the configuration of its bodies."""

from __future__ import annotations

from typing import Any

import numpy as np

from pgimp.case.body import any_means, scene_method
from pgimp.case.checks.exact_surfaces import exact_surfaces
from pgimp.physics.shapes.averaging import averaged_part

#: With bodies in the initial configuration only, whose vertices keep velocities: by shape,
#: dimensions and particles per cell; of bodies at any offset to the grid, by eigenvalues
#: (``scripts/hard vertices``). Points have none: with them a body's outermost vertices may have as
#: little mass as one likes, but the stiffness of whole particles.
VERTEX_LIMITS: dict[str, dict[int, dict[int, float]]] = {
    "gimp": {
        1: {1: 0.86, 2: 0.8, 3: 0.73, 4: 0.66, 8: 0.49},
        2: {1: 0.85, 2: 0.78, 3: 0.71, 4: 0.65},
        3: {1: 0.84, 2: 0.77},
    },
    "finite-gimp": {
        1: {1: 0.86, 2: 0.8, 3: 0.73, 4: 0.66, 8: 0.49},
        2: {1: 0.85, 2: 0.78, 3: 0.71, 4: 0.65},
        3: {1: 0.84, 2: 0.77},
    },
    "cpdi": {
        1: {1: 1.0, 2: 0.9, 3: 0.78, 4: 0.68, 8: 0.49},
        2: {1: 1.0, 2: 0.91, 3: 0.77, 4: 0.68},
        3: {1: 1.0, 2: 0.89},
    },
    "bspline-quadratic": {
        1: {1: 0.86, 2: 0.95, 3: 0.99, 4: 1.0, 8: 1.0},
        2: {1: 0.85, 2: 0.93, 3: 0.97, 4: 1.0},
        3: {1: 0.84, 2: 0.89},
    },
    "bspline-cubic": {
        1: {1: 1.0, 2: 1.0, 3: 1.0, 4: 1.0, 8: 1.0},
        2: {1: 1.0, 2: 1.0, 3: 1.0, 4: 1.0},
        3: {1: 1.0, 2: 1.0},
    },
    "fuzzy-nearest": {
        1: {1: 1.0, 2: 1.0, 3: 0.89, 4: 0.78, 8: 0.55},
        2: {1: 1.0, 2: 1.0, 3: 0.86, 4: 0.75},
        3: {1: 1.0, 2: 0.96},
    },
    "fuzzy-constant": {
        1: {1: 1.0, 2: 1.0, 3: 1.0, 4: 1.0, 8: 1.0},
        2: {1: 1.0, 2: 1.0, 3: 1.0, 4: 1.0},
        3: {1: 1.0, 2: 1.0},
    },
}
#: Of bodies exact to their surface, at any offset to the grid, with any number of particles a cell
#: and Poisson's ratio: no vertex holds less than a part of a cell. The least found was 0.79.
EXACT_LIMIT = 0.73
#: What is left of that for Poisson's ratios above 0.3, by dimensions; the least of all shapes.
_LESS = {
    2: {0.3: 1.0, 0.4: 0.94, 0.45: 0.91, 0.5: 0.87},
    3: {0.3: 1.0, 0.4: 0.91, 0.45: 0.86, 0.5: 0.81},
}


def vertex_limit(case: Any) -> float | None:
    """Largest stable Courant number of a `Case` with all bodies in the initial configuration.

    Else, with mean dilatation but for bodies exact to their surface, and for points, None.
    """
    method = case.method
    if any(body.formulation != "total-lagrangian" for body in case.bodies.values()):
        return None
    exact = exact_surfaces(case)
    if any_means(case) and not any(exact):
        return None
    if exact and all(exact):
        return averaged_limit(case, EXACT_LIMIT)
    known = method.limits.get("vertices") or VERTEX_LIMITS.get(method.name, {})
    found = known.get(case.dimensions)
    if found is None:
        return None
    most = max(method.particles_per_cell)
    limit = next((limit for n, limit in found.items() if most <= n), 0.0)
    if not limit:
        n, least = list(found.items())[-1]
        limit = least * n / most
    limit *= _of_ratios(case)
    return averaged_limit(case, min(limit, EXACT_LIMIT) if any(exact) else limit)


def averaged_limit(case: Any, limit: float) -> float:
    """The part of a limit, of lumped masses, that the averaged mass of any body leaves.

    The greatest frequency grows by the root of 1 + alpha at most, whatever the body.
    """
    if not any((body.mass or case.method.mass) == "averaged" for body in case.bodies.values()):
        return limit
    found = limit
    for _ in range(20):  # alpha depends on the Courant number
        alpha = averaged_part(case.method.name, case.method.particles_per_cell, found)
        found = limit / (1.0 + alpha) ** 0.5
    return found


def _of_ratios(case: Any) -> float:
    """Part of the limits that the greatest Poisson's ratio of the materials leaves."""
    if case.dimensions == 1:
        return 1.0
    used = (case.materials[body.material] for body in case.bodies.values())
    ratios = [getattr(material, "poisson", 0.5) for material in used]
    most = max(float(nu) if isinstance(nu, float | int) else 0.5 for nu in ratios)
    measured, parts = zip(*_LESS[case.dimensions].items(), strict=True)
    return float(np.interp(most, measured, parts))


def largest_courant(case: Any) -> float:
    """Largest Courant number measured as stable with the case's shape and bodies."""
    limit = vertex_limit(case)
    if limit is not None:
        return limit
    limit = scene_method(case).largest_courant(case.dimensions)
    if not case.method.in_cell and any(
        b.formulation == "total-lagrangian" for b in case.bodies.values()
    ):
        limit = min(limit, EXACT_LIMIT)  # those have weights of cells
    return averaged_limit(case, limit)
