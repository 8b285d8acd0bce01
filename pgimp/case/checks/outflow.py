"""Checks of `outflow`: open faces, and sinks with a region."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from pgimp.case.checks.domain import check_grid
from pgimp.case.grid import Grid
from pgimp.case.outflow import Sink
from pgimp.geometry.regions.base import Region
from pgimp.schema.messages import unknown
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import AXES, Problems, faces

Path = tuple[str | int, ...]


def check_outflow(dimensions: int, grid: Grid, outflow: Mapping[str, Any]) -> Problems:
    """Check that faces exist, and that sinks lie in the domain."""
    sound = not list(check_grid(grid))
    for name, action in outflow.items():
        path = ("outflow", name)
        if isinstance(action, Sink):
            yield from _sink(path, name, action, grid if sound else None)
        elif name not in faces(dimensions):
            text = unknown("face", name, faces(dimensions))
            yield Problem(path, f"{text}; a sink inside the domain is {{region: ..}}")


def _sink(path: Path, name: str, sink: Sink, grid: Grid | None) -> Problems:
    """Check the name of a sink and its region; `grid` is None if that is wrong itself."""
    if name in faces(3):
        yield Problem(
            path, "is the name of a face, which takes stop or remove; call the sink otherwise"
        )
    path = (*path, "region")
    if any(region.FROM_FILE for region in sink.region.simple()):
        yield Problem(
            path, "is from a file; a sink is looked at in every step: take a box, a ball or others"
        )
    elif grid is not None:
        yield from _beyond(path, sink.region, grid)


def _beyond(path: Path, region: Region, grid: Grid) -> Problems:
    """Check that a region is not empty, and that something of it lies in the domain."""
    low, high = region.bounds()
    if any(a > b for a, b in zip(low, high, strict=True)):
        yield Problem(path, "is empty: no point lies in it; see how its parts overlap")
        return
    for i in range(len(grid.cell)):
        if high[i] <= grid.origin[i] or low[i] >= grid.corner[i]:
            end = low[i] if math.isfinite(low[i]) and low[i] >= grid.corner[i] else high[i]
            yield Problem(
                path,
                f"lies beyond the domain along {AXES[i]}, at {end:.15g}: nothing comes there; a "
                "face lets particles out by its own name",
            )
            return
