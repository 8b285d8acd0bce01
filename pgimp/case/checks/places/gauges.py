"""Checks of the gauges: their surfaces, bodies, walls and places."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from pgimp.case.body import Body
from pgimp.case.checks.domain import check_grid
from pgimp.case.checks.periodic import periodic_axes
from pgimp.case.gauges import CutGauge, FluxGauge, Gauge, LevelGauge, WallGauge
from pgimp.case.grid import Grid
from pgimp.geometry.regions import Box, HalfSpace
from pgimp.physics.boundaries.base import Boundary
from pgimp.physics.rigid import RigidBody
from pgimp.schema.messages import unknown
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import AXES, WHOLE, Problems, faces

Path = tuple[str | int, ...]

#: Cells from a wall on from which no particle reaches a vertex on it.
_REACH = 2.0


def check_gauges(
    dimensions: int,
    grid: Grid,
    every_body: Mapping[str, Body | RigidBody],
    body_names: Iterable[str],
    boundaries: Mapping[str, Boundary],
    gauges: Mapping[str, Gauge],
) -> Problems:
    """Check that gauges are of surfaces, walls and places of the domain, and of known bodies."""
    sound = not list(check_grid(grid))
    for name, entry in gauges.items():
        path: Path = ("gauges", name)
        yield from _bodies(path, entry, every_body, body_names)
        within = getattr(entry, "within", None)
        if within is not None:
            named = not isinstance(entry, WallGauge) or entry.wall in faces(dimensions)
            if sound and named:
                yield from _within((*path, "within"), entry, dimensions, grid, boundaries)
        if isinstance(entry, CutGauge | FluxGauge):
            yield from _surface(path, entry, dimensions, grid, boundaries, sound)
        elif isinstance(entry, WallGauge):
            yield from _wall((*path, "wall"), entry.wall, dimensions, boundaries)
        elif isinstance(entry, LevelGauge):
            yield from _level((*path, "level"), entry.level, dimensions, grid, sound)


def _bodies(
    path: Path, entry: Gauge, every_body: Mapping[str, Body | RigidBody], named: Iterable[str]
) -> Problems:
    if entry.bodies == ():
        text = "names no body, so that nothing is measured; without the key all bodies count"
        yield Problem((*path, "bodies"), text)
    for i, body in enumerate(entry.bodies or ()):
        if isinstance(every_body.get(body), RigidBody):
            text = f"'{body}' is rigid, and has no stress: history.csv has its force, rigid.{body}"
            yield Problem((*path, "bodies", i), text)
        elif body not in every_body and body not in named:
            yield Problem((*path, "bodies", i), unknown("body", body, named))


def _surface(
    path: Path,
    entry: CutGauge | FluxGauge,
    dimensions: int,
    grid: Grid,
    boundaries: Mapping[str, Boundary],
    sound: bool,
) -> Problems:
    key, region = ("cut", entry.cut) if isinstance(entry, CutGauge) else ("flux", entry.flux)
    path = (*path, key)
    if not isinstance(region, HalfSpace | Box):
        text = "expected a half-space, whose plane is the surface, or a box"
        yield Problem(path, f"{text}; take the box around it")
        return
    if not sound:
        return
    yield from _reaches(path, region, dimensions, grid, periodic_axes(boundaries))
    for axis in periodic_axes(boundaries):
        if axis >= dimensions:
            continue
        if isinstance(region, HalfSpace):
            oblique = sum(n != 0.0 for n in region.normal) > 1
            through = region.normal[axis] != 0.0 and (oblique or isinstance(entry, CutGauge))
        else:
            through = _meets_seam(region, grid, axis)
        if through:
            ends = f"{AXES[axis]}-min and {AXES[axis]}-max"
            yield Problem(
                path,
                f"{ends} are periodic, so that what leaves it on one side enters on the other; "
                f"take a box that ends a cell or more from both, or spans all of {AXES[axis]}",
            )


def _reaches(
    path: Path, region: HalfSpace | Box, dimensions: int, grid: Grid, periodic: Iterable[int]
) -> Problems:
    """Check that a surface lies in the domain, in part; those across periodic directions do."""
    ends = list(zip(grid.origin, grid.corner, strict=True))
    if isinstance(region, Box):
        pairs = list(zip(region.min, region.max, ends, strict=True))
        for axis, (low, high, (least, most)) in enumerate(pairs):
            if low >= most or high <= least:
                yield Problem(path, f"lies beyond the domain along {AXES[axis]}: nothing passes it")
        if all(low <= least and high >= most for low, high, (least, most) in pairs):
            yield Problem(path, "holds the whole domain, so that it has no surface there")
        return
    normal, point = region.normal, region.point
    across = [axis for axis in range(dimensions) if normal[axis] != 0.0]
    if len(across) == 1 and across[0] in periodic:
        return
    least, most = (
        sum(pick(normal[d] * (x - point[d]) for x in ends[d]) for d in across)
        for pick in (min, max)
    )
    if least >= 0.0 or most < 0.0:
        where = f" along {AXES[across[0]]}" if len(across) == 1 else ""
        yield Problem(path, f"lies beyond the domain{where}: nothing passes it")


def _meets_seam(box: Box, grid: Grid, axis: int) -> bool:
    """Whether a box has a surface across a periodic direction at the seam."""
    low, high, cell = box.min[axis], box.max[axis], grid.cell[axis] * (1.0 - WHOLE)
    least, most = grid.origin[axis], grid.corner[axis]
    if low <= least and high >= most:
        return False
    return low < least + cell or high > most - cell


def _wall(path: Path, face: str, dimensions: int, boundaries: Mapping[str, Boundary]) -> Problems:
    if face not in faces(dimensions):
        yield Problem(path, unknown("face", face, faces(dimensions)))
        return
    condition = boundaries.get(face)
    if condition is None or condition.joins:
        what = "is open" if condition is None else "is periodic"
        text = f"{face} {what}, and bears nothing; name a face with a condition (boundaries)"
        yield Problem(path, text)


def _within(
    path: Path, entry: Gauge, dimensions: int, grid: Grid, boundaries: Mapping[str, Boundary]
) -> Problems:
    """Check that there is material to count in a sound region, and at a wall one that presses."""
    region = entry.within  # type: ignore[attr-defined]
    if any(part.FROM_FILE for part in region.simple()):
        return
    low, high = region.bounds()
    wall = "xyz".index(entry.wall[0]) if isinstance(entry, WallGauge) else -1
    for axis in set(range(dimensions)) - set(periodic_axes(boundaries)):
        least, most = grid.origin[axis], grid.corner[axis]
        ends = f"{AXES[axis]} goes from {least:.15g} to {most:.15g}"
        if low[axis] > high[axis]:
            yield Problem(path, "is empty, so that nothing is measured")
        elif low[axis] >= most or high[axis] <= least:
            yield Problem(path, f"lies beyond the domain, whose {ends}: nothing is measured")
        elif axis == wall and isinstance(entry, WallGauge):
            reach = _REACH * grid.cell[axis]
            away = low[axis] - least if entry.wall.endswith("min") else most - high[axis]
            if away >= reach:
                yield Problem(
                    path,
                    f"ends {away / grid.cell[axis]:.3g} cells from {entry.wall}, so that nothing "
                    "in it presses there; let it reach to the wall, from a cell or more away",
                )


def _level(
    path: Path, place: tuple[float, ...], dimensions: int, grid: Grid, sound: bool
) -> Problems:
    if dimensions == 1:
        yield Problem(path, "there is no level in one dimension; history.csv has the bodies' mass")
        return
    for i, x in enumerate(place) if sound else ():
        if not grid.origin[i] <= x <= grid.corner[i]:
            yield Problem(
                (*path, i),
                f"{x:.15g} is outside of the domain, which goes from {grid.origin[i]:.15g} to "
                f"{grid.corner[i]:.15g} along {AXES[i]}",
            )
