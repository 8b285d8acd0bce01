"""Checks of bodies of a material, their tractions and constraints."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from pgimp.case.body import Body
from pgimp.case.checks.domain import check_grid
from pgimp.case.grid import Grid
from pgimp.case.output import PointProbe
from pgimp.geometry.regions import REGIONS
from pgimp.physics.loads.constraints import ConstraintEntry
from pgimp.physics.loads.tractions import TractionEntry
from pgimp.physics.rigid import RigidBody
from pgimp.schema.messages import unknown
from pgimp.schema.problems import Problem
from pgimp.schema.registries import name_of
from pgimp.schema.sizes import Problems, faces


def check_materials(bodies: Mapping[str, Body], declared: Iterable[str]) -> Problems:
    """Check that the bodies' materials are known."""
    for name, body in bodies.items():
        if body.material not in declared:
            text = unknown("material", body.material, declared)
            yield Problem(("bodies", name, "material"), text)


def check_body_of(
    path: tuple[str | int, ...],
    entry: TractionEntry | ConstraintEntry | PointProbe,
    every_body: Mapping[str, Body | RigidBody],
    named: Iterable[str],
    why: str,
) -> Problems:
    """Check that an entry's body is known and has particles; `why` gives the reason."""
    body = every_body.get(entry.body)
    if isinstance(body, RigidBody):
        yield Problem((*path, "body"), f"'{entry.body}' is rigid, and has no particles: {why}")
    elif body is None and entry.body not in named:
        yield Problem((*path, "body"), unknown("body", entry.body, named))


def check_tractions(
    dimensions: int,
    every_body: Mapping[str, Body | RigidBody],
    bodies: Mapping[str, Body],
    body_names: Iterable[str],
    tractions: Mapping[str, TractionEntry],
    gravity: object,
) -> Problems:
    """Check that tractions act on faces of boxes, or on regions' surfaces."""
    for name, entry in tractions.items():
        path: tuple[str | int, ...] = ("tractions", name)
        why = "a traction pulls at a body of a material; a rigid one moves as its key `rigid` says"
        yield from check_body_of(path, entry, every_body, body_names, why)
        if entry.face is None:
            if entry.hydrostatic is not None and gravity is None:
                text = "needs gravity, which gives the weight of the liquid: gravity: [0.0, -9.81]"
                yield Problem((*path, "hydrostatic"), text)
        elif entry.face not in faces(dimensions):
            yield Problem((*path, "face"), unknown("face", entry.face, faces(dimensions)))
        elif entry.body in bodies and name_of(bodies[entry.body].region, REGIONS) != "box":
            kind = name_of(bodies[entry.body].region, REGIONS)
            yield Problem(
                (*path, "face"),
                f"the region of '{entry.body}' is a {kind}, which has no such faces; load the part "
                "of its surface that lies in a region: region: {box: ..} in place of face",
            )


def check_constraints(
    grid: Grid,
    every_body: Mapping[str, Body | RigidBody],
    body_names: Iterable[str],
    constraints: Mapping[str, ConstraintEntry],
) -> Problems:
    """Check that constraints hold parts of bodies, within the domain."""
    sound = not list(check_grid(grid))
    for name, entry in constraints.items():
        path: tuple[str | int, ...] = ("constraints", name)
        why = "a constraint holds parts of a body of a material; give a rigid one its motion by"
        why += " its key `rigid`"
        yield from check_body_of(path, entry, every_body, body_names, why)
        if not sound or any(region.FROM_FILE for region in entry.region.simple()):
            continue
        low, high = entry.region.bounds()
        within = zip(low, high, grid.origin, grid.corner, strict=True)
        if any(a > b for a, b in zip(low, high, strict=True)):
            yield Problem((*path, "region"), "is empty: no point lies in it")
        elif any(b < least or a > most for a, b, least, most in within):
            yield Problem((*path, "region"), "lies beyond the domain, where no particle comes")
