"""Checks of the regions that bodies fill."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from pydantic import RootModel

from pgimp.case.body import Body
from pgimp.case.checks.domain import check_grid
from pgimp.case.grid import Grid
from pgimp.geometry.regions import REGIONS
from pgimp.geometry.regions.base import Region
from pgimp.schema.problems import Problem
from pgimp.schema.registries import name_of
from pgimp.schema.sizes import AXES, WHOLE, Problems, length

MOST_PARTS = 5000
"""Of a region: if these overlap, a few hundred thousand particles take a minute."""


def check_region(path: tuple[str | int, ...], region: Any, dimensions: int) -> Problems:
    """Check one region and its parts."""
    if (parts := region.parts) > MOST_PARTS:
        yield Problem(path, f"{parts:,} regions in one are too many (at most {MOST_PARTS:,})")
        return
    name = name_of(region, REGIONS)
    path = (*path, name)
    if isinstance(region, RootModel):
        for i, part in enumerate(region.root):
            yield from check_region((*path, i), part, dimensions)
        return
    if dimensions not in region.DIMENSIONS:
        allowed = " and ".join(f"{d}D" for d in region.DIMENSIONS)
        hint = "; in 2D a disk is a ball" if dimensions == 2 else ""
        yield Problem(path, f"a {name} exists in {allowed} only{hint}")
        return
    if region.WHOLE_BODY and (path[0] != "bodies" or len(path) > 4):
        yield Problem(path, "particles of a file are a body of their own, and no part of a region")
        return
    region.belong(dimensions)
    for keys, text in region.misfits(dimensions):
        yield Problem((*path, *keys), text)
    for field, info in type(region).model_fields.items():
        yield from length((*path, info.alias or field), getattr(region, field), dimensions)


def check_regions(geometry: str, grid: Grid, bodies: Mapping[str, Body]) -> Problems:
    """Check that regions of bodies lie in the domain.

    In axisymmetry they may reach across the axis, as a ball on it does.
    """
    axis = geometry == "axisymmetric" and grid.origin[:1] == (0.0,)
    sound = not list(check_grid(grid))
    for name, body in bodies.items():
        if sound and not any(region.FROM_FILE for region in body.region.simple()):
            yield from check_bounds(("bodies", name, "region"), body.region, grid, axis)


def check_bounds(
    path: tuple[str | int, ...], region: Region, grid: Grid, axis: bool = False
) -> Problems:
    """Check that a body's region has an end, is not empty and lies in the domain.

    What lies beyond an `axis` at x-min is left out.
    """
    dimensions = len(grid.cell)
    low, high = region.bounds()
    low = (max(low[0], 0.0), *low[1:]) if axis else low
    ends = [f"{AXES[i]}-min" for i in range(dimensions) if low[i] == -math.inf]
    ends += [f"{AXES[i]}-max" for i in range(dimensions) if high[i] == math.inf]
    if any(a > b for a, b in zip(low, high, strict=True)):
        yield Problem(path, "is empty: no point lies in it; see how its parts overlap")
        return
    if ends:
        yield Problem(
            path,
            f"has no end towards {', '.join(ends)}, which a body needs; a half-space is a part of "
            "one: region: {intersection: [{box: ..}, {half-space: ..}]}",
        )
        return
    for i in range(dimensions):
        least, most = grid.origin[i], grid.corner[i]
        slack = WHOLE * grid.cell[i]
        if low[i] < least - slack:
            yield _beyond(path, f"{AXES[i]}-min", low[i], least, region.at(i, low[i]))
        if high[i] > most + slack:
            yield _beyond(path, f"{AXES[i]}-max", high[i], most, region.at(i, high[i]))


def _beyond(
    path: tuple[str | int, ...], face: str, reach: float, wall: float, what: str
) -> Problem:
    return Problem(
        path,
        f"reaches {abs(reach - wall):.6g} beyond the domain at {face}: to {reach:.15g}"
        f"{what and f' with {what}'}, where the domain ends at {wall:.15g}",
    )
