"""Checks of the geometry of a scene in two dimensions."""

from __future__ import annotations

from pgimp.case.grid import Grid
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import Problems


def check_geometry(dimensions: int, geometry: str, grid: Grid) -> Problems:
    """Check that in axisymmetry the grid has a radius from 0 on."""
    if geometry != "axisymmetric" or dimensions != 2 or len(grid.origin) != 2:
        return
    if grid.origin[0] < 0.0:
        yield Problem(
            ("grid", "origin", 0),
            f"x is the radius, from the axis at 0 on, but the grid begins at {grid.origin[0]:g}; "
            "begin at 0, or above for what has a hole",
        )
    elif 0.0 < grid.origin[0] < grid.cell[0]:
        yield Problem(
            ("grid", "origin", 0),
            f"begins within a cell from the axis, {grid.origin[0]:g}; begin at 0, or a cell away",
        )
