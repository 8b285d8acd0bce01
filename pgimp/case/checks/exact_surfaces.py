"""Which bodies are exact to their surface: those in the initial configuration that it cuts."""

from __future__ import annotations

from typing import Any

import numpy as np

from pgimp.case.body import any_means, may_be_exact
from pgimp.case.checks.rigid_bodies import meet_by_surfaces
from pgimp.case.grid import Grid
from pgimp.geometry.regions import Points
from pgimp.geometry.regions.base import Region

#: Part of a lattice box by which a surface beside its faces is rounding.
_NEAR = 1e-9


def exact_surfaces(case: Any) -> list[bool]:
    """Whether each body of a `Case` is exact to its surface.

    Where bodies do not meet by surfaces, in no stage, and none cuts a particle, lattice particles
    are exact already: such scenes pay for nothing. Mean dilatation takes whole cells to be so: at
    the centre of a cell that is filled in part it is not that of its particles, and locks.
    """
    able = may_be_exact(case.bodies, case.method)
    boxes = (1,) * case.dimensions if any_means(case) else case.method.particles_per_cell
    cut = any(able) and (
        case.staged.meets
        or meets(case)
        or any(
            cuts(body.region, case.grid, boxes)
            for body, one in zip(case.bodies.values(), able, strict=True)
            if one
        )
    )
    return able if cut else [False] * len(able)


def meets(case: Any) -> bool:
    """Whether bodies of a `Case` may meet by surfaces: each other, rigid bodies or walls."""
    walls = any(entry.approaches for entry in case.boundaries.values())
    current = any(body.formulation == "updated-lagrangian" for body in case.bodies.values())
    some = case.contact or case.rigid_bodies or walls or current
    return bool(some) and meet_by_surfaces(case.bodies)


def cuts(region: Region, grid: Grid, per_cell: tuple[int, ...]) -> bool:
    """Whether the surface of a region leaves the faces of the lattice's boxes in the domain."""
    for part in region.simple():
        if part.FROM_FILE or np.isfinite(part.curved(np.array([grid.origin]))).any():
            return True
        for plane in part.planes():
            d = plane.axis
            boxes = grid.cells[d] * per_cell[d]
            at = (plane.at - grid.origin[d]) * boxes / grid.size[d]
            if 0.0 < at < boxes and abs(at - round(at)) > _NEAR:
                return True
    return False


def fallback(case: Any) -> str:
    """Note of bodies of a `Case` in the initial configuration that stay on the lattice; or empty.

    Their particles have the volumes of their parts, but weights of whole boxes.
    """
    bodies, method = case.bodies, case.method
    current = [name for name, body in bodies.items() if body.formulation != "total-lagrangian"]
    begun = [name for name in bodies if name not in current]
    if current and begun and not method.in_cell:
        return (
            f"'{begun[0]}', in the initial configuration, has weights of cells, by whose surfaces "
            f"it meets others: {method.name} is for bodies in the current one"
        )
    cut = [
        name
        for name, body in bodies.items()
        if body.formulation == "total-lagrangian" and body.surface == "cut-particles"
        if not isinstance(body.region, Points)
        if cuts(body.region, case.grid, method.particles_per_cell)
    ]
    if not cut or any(may_be_exact(bodies, method)):
        return ""
    why = f"{method.name} is wider than cells"
    if current:
        why = f"'{current[0]}' is in the current one, and another body is whole or from a file"
    return (
        f"cut particles of '{cut[0]}', in the initial configuration, have weights of whole ones, "
        f"as {why}"
    )
