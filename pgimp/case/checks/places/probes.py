"""Checks of the probes: material points in bodies, fixed positions in the domain."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from pgimp.case.body import Body
from pgimp.case.checks.bodies import check_body_of
from pgimp.case.checks.domain import check_grid
from pgimp.case.checks.regions import check_regions
from pgimp.case.grid import Grid
from pgimp.case.output import PlaceProbe, PointProbe
from pgimp.geometry.regions.base import Region
from pgimp.physics.rigid import RigidBody
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import AXES, WHOLE, Problems


def check_probes(
    geometry: str,
    grid: Grid,
    every_body: Mapping[str, Body | RigidBody],
    bodies: Mapping[str, Body],
    body_names: Collection[str],
    probes: Mapping[str, PointProbe | PlaceProbe],
) -> Problems:
    """Check that material points are in their bodies, and fixed positions in the domain."""
    sound = not list(check_grid(grid))
    for name, entry in probes.items():
        path: tuple[str | int, ...] = ("probes", name)
        if isinstance(entry, PlaceProbe):
            if sound:
                yield from _in_domain((*path, "place"), entry.place, grid)
            continue
        yield from check_body_of(path, entry.body, every_body, body_names)
        if sound and entry.body in bodies:
            if not any(check_regions(geometry, grid, {entry.body: bodies[entry.body]})):
                yield from _in_body((*path, "at"), entry, grid, bodies)


def _in_domain(path: tuple[str | int, ...], place: tuple[float, ...], grid: Grid) -> Problems:
    for i, x in enumerate(place):
        least, most = grid.origin[i], grid.corner[i]
        if not least - WHOLE * grid.cell[i] <= x <= most + WHOLE * grid.cell[i]:
            yield Problem(
                (*path, i),
                f"{x:.15g} is outside of the domain, which goes from {least:.15g} to {most:.15g} "
                f"along {AXES[i]}",
            )


def _in_body(
    path: tuple[str | int, ...], entry: PointProbe, grid: Grid, bodies: Mapping[str, Body]
) -> Problems:
    """Check that a position is in a body; for bodies from files, after they are read."""
    region = bodies[entry.body].region
    if not any(part.FROM_FILE for part in region.simple()):
        yield from check_near(path, entry, region, grid)


def check_near(
    path: tuple[str | int, ...], entry: PointProbe, region: Region, grid: Grid
) -> Problems:
    """Check that a position is in a region, or so close that a particle may be next to it."""
    slack = 0.5 * min(grid.cell)
    low, high = region.bounds()
    # First the bounding box of the body: a position outside it needs no closer check.
    away = max(max(a - x, x - b) for a, x, b in zip(low, entry.at, high, strict=True))
    if away <= slack:
        away = float(region.distance(np.array([entry.at], float))[0])
        if np.isinf(away):  # particles from a file have no surface
            return
    if away > slack:
        yield Problem(
            path,
            f"{list(entry.at)} is outside of body '{entry.body}', by {away:.3g} or more; it is the "
            "place of the point at the start",
        )
