"""What belongs to the dimensions of a case: vectors, regions and rotations fit them.

These checks come before all others, which then take one entry a direction for granted: a part that
does not fit is told here, and left out there.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pgimp.case.body import Body
from pgimp.case.checks.regions import check_region
from pgimp.case.gauges import CutGauge, FluxGauge, Gauge, LevelGauge
from pgimp.case.grid import Grid
from pgimp.case.outflow import Sink
from pgimp.case.output import PlaceProbe, PointProbe
from pgimp.geometry.regions import Box, HalfSpace
from pgimp.physics.boundaries.base import Boundary
from pgimp.physics.loads.constraints import ConstraintEntry
from pgimp.physics.loads.inflow import InflowEntry
from pgimp.physics.loads.motion import RigidMotion, check_rotation
from pgimp.physics.loads.own_velocity import OwnVelocity
from pgimp.physics.loads.surfaces import profile_problems
from pgimp.physics.loads.tractions import TractionEntry
from pgimp.physics.loads.turning import turning_problems
from pgimp.physics.rigid import Free, RigidBody
from pgimp.physics.shapes.base import Shape
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import Problems, length
from pgimp.schema.tables import lengths

Path = tuple[str | int, ...]


def fit_grid(dimensions: int, grid: Grid) -> Problems:
    """Check that the grid has its sizes along each direction."""
    for name in ("origin", "size", "cell"):
        yield from length(("grid", name), getattr(grid, name), dimensions)


def fit_method(dimensions: int, method: Shape) -> Problems:
    """Check that there is a number of particles along each direction."""
    yield from length(("method", "particles-per-cell"), method.particles_per_cell, dimensions)


def fit_gravity(dimensions: int, gravity: object) -> Problems:
    """Check that gravity fits the dimensions."""
    yield from lengths(("gravity",), gravity, dimensions)


def fit_boundaries(dimensions: int, boundaries: Mapping[str, Boundary]) -> Problems:
    """Check that vectors of faces fit the dimensions."""
    for face, entry in boundaries.items():
        for field in type(entry).model_fields:
            yield from length(("boundaries", face, field), getattr(entry, field), dimensions)


def fit_bodies(dimensions: int, every_body: Mapping[str, Body | RigidBody]) -> Problems:
    """Check that regions and motions of bodies fit the dimensions."""
    for name, body in every_body.items():
        path: Path = ("bodies", name)
        yield from check_region((*path, "region"), body.region, dimensions)
        if isinstance(body.velocity, OwnVelocity):
            yield from _own((*path, "velocity"), body.velocity, dimensions)
        elif isinstance(body.velocity, RigidMotion):
            yield from _motion((*path, "velocity"), body.velocity, dimensions)
        elif body.velocity is not None:
            yield from length((*path, "velocity"), body.velocity, dimensions)
        if not isinstance(body, RigidBody):
            continue
        path, rigid = (*path, "rigid"), body.rigid
        if isinstance(rigid, Free):
            yield from lengths((*path, "force"), rigid.force, dimensions)
            if rigid.spring:
                yield from length((*path, "spring", "to"), rigid.spring.to, dimensions)
        else:
            yield from lengths((*path, "velocity"), rigid.velocity, dimensions)
            if rigid.rotation is not None:
                yield from turning_problems((*path, "rotation"), dimensions, rigid.rotation)


def _motion(path: Path, motion: RigidMotion, dimensions: int) -> Problems:
    """Check an initial motion with a rotation."""
    yield from length((*path, "translation"), motion.translation, dimensions)
    if dimensions == 1:
        yield Problem((*path, "rotation"), "there is no rotation in one dimension")
    else:
        yield from check_rotation((*path, "rotation"), motion.rotation, dimensions)


def _own(path: Path, entry: Any, dimensions: int) -> Iterator[Problem]:
    """Check a function of one's own, whose problems have paths from it on."""
    for found in entry.misfits(dimensions):
        yield found._replace(path=(*path, *found.path))


def fit_tractions(dimensions: int, tractions: Mapping[str, TractionEntry]) -> Problems:
    """Check that tractions, their regions and profiles fit the dimensions."""
    for name, entry in tractions.items():
        path: Path = ("tractions", name)
        yield from lengths((*path, "traction"), entry.traction, dimensions)
        if entry.face is None:
            yield from check_region((*path, "region"), entry.region, dimensions)
            if entry.normal is not None:
                yield from length((*path, "normal", "of"), entry.normal.of, dimensions)
            if entry.profile is not None:
                yield from profile_problems((*path, "profile"), dimensions, entry.profile)


def fit_constraints(dimensions: int, constraints: Mapping[str, ConstraintEntry]) -> Problems:
    """Check that regions, velocities, forces and rotations of constraints fit the dimensions."""
    for name, entry in constraints.items():
        path: Path = ("constraints", name)
        yield from check_region((*path, "region"), entry.region, dimensions)
        if entry.rotation:
            yield from turning_problems((*path, "rotation"), dimensions, entry.rotation)
        if entry.field:
            yield from _own((*path, "velocity"), entry.field, dimensions)
        for key, given in (("velocity", entry.along), ("force", entry.force)):
            if given:
                yield from length((*path, key), given, dimensions)


def fit_inflow(dimensions: int, inflow: Mapping[str, InflowEntry]) -> Problems:
    """Check that velocities of inflows fit the dimensions."""
    for name, entry in inflow.items():
        yield from length(("inflow", name, "velocity"), entry.velocity, dimensions)


def fit_outflow(dimensions: int, outflow: Mapping[str, Any]) -> Problems:
    """Check that regions of sinks fit the dimensions."""
    for name, action in outflow.items():
        if isinstance(action, Sink):
            yield from check_region(("outflow", name, "region"), action.region, dimensions)


def fit_probes(dimensions: int, probes: Mapping[str, PointProbe | PlaceProbe]) -> Problems:
    """Check that places of probes fit the dimensions."""
    for name, entry in probes.items():
        key = "place" if isinstance(entry, PlaceProbe) else "at"
        yield from length(("probes", name, key), getattr(entry, key), dimensions)


def fit_gauges(dimensions: int, gauges: Mapping[str, Gauge]) -> Problems:
    """Check that surfaces, parts and places of gauges fit the dimensions."""
    for name, entry in gauges.items():
        path: Path = ("gauges", name)
        if (within := getattr(entry, "within", None)) is not None:
            yield from check_region((*path, "within"), within, dimensions)
        if isinstance(entry, CutGauge | FluxGauge):
            key = "cut" if isinstance(entry, CutGauge) else "flux"
            region = getattr(entry, key)
            if isinstance(region, HalfSpace | Box):
                yield from check_region((*path, key), region, dimensions)
        if isinstance(entry, CutGauge):
            yield from length((*path, "about"), entry.about, dimensions)
        if isinstance(entry, LevelGauge) and dimensions > 1:
            yield from length((*path, "level"), entry.level, dimensions - 1)


FITS = (
    fit_grid,
    fit_method,
    fit_gravity,
    fit_boundaries,
    fit_bodies,
    fit_tractions,
    fit_constraints,
    fit_inflow,
    fit_outflow,
    fit_probes,
    fit_gauges,
)
