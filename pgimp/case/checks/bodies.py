"""Checks of bodies of a material, their tractions and constraints."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

from pgimp.case.body import Body
from pgimp.case.checks.domain import check_grid
from pgimp.case.grid import Grid
from pgimp.physics.loads.constraints import ConstraintEntry
from pgimp.physics.loads.tractions import TractionEntry
from pgimp.physics.rigid import RigidBody
from pgimp.schema.messages import unknown
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import Problems, faces


def check_materials(bodies: Mapping[str, Body], declared: Iterable[str]) -> Problems:
    """Check that the bodies' materials are known."""
    for name, body in bodies.items():
        if body.material not in declared:
            text = unknown("material", body.material, declared)
            yield Problem(("bodies", name, "material"), text)


def check_tractions(
    dimensions: int,
    every_body: Mapping[str, Body | RigidBody],
    body_names: Collection[str],
    tractions: Mapping[str, TractionEntry],
    gravity: object,
) -> Problems:
    """Check that tractions act on bodies and faces that there are."""
    for name, entry in tractions.items():
        path: tuple[str | int, ...] = ("tractions", name)
        yield from check_body_of(path, entry.body, every_body, body_names)
        if entry.face is not None and entry.face not in faces(dimensions):
            yield Problem((*path, "face"), unknown("face", entry.face, faces(dimensions)))
        if entry.hydrostatic is not None and gravity is None:
            text = "needs gravity, which gives the weight of the liquid: gravity: [0.0, -9.81]"
            yield Problem((*path, "hydrostatic"), text)


def check_body_of(
    path: tuple[str | int, ...], body: str, every: Collection[str], named: Collection[str]
) -> Problems:
    """Check that the body of an entry is known."""
    if body not in every and body not in named:
        yield Problem((*path, "body"), unknown("body", body, named))


def check_constraints(
    grid: Grid,
    every_body: Mapping[str, Body | RigidBody],
    body_names: Collection[str],
    constraints: Mapping[str, ConstraintEntry],
) -> Problems:
    """Check that constraints hold parts of bodies, within the domain."""
    sound = not list(check_grid(grid))
    for name, entry in constraints.items():
        path: tuple[str | int, ...] = ("constraints", name)
        yield from check_body_of(path, entry.body, every_body, body_names)
        if not sound or any(region.FROM_FILE for region in entry.region.simple()):
            continue
        low, high = entry.region.bounds()
        within = zip(low, high, grid.origin, grid.corner, strict=True)
        if any(a > b for a, b in zip(low, high, strict=True)):
            yield Problem((*path, "region"), "is empty: no point lies in it")
        elif any(b < least or a > most for a, b, least, most in within):
            yield Problem((*path, "region"), "lies beyond the domain, where no particle comes")
