"""Checks of bodies, tractions and constraints."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from pydantic import RootModel

from pgimp.case.body import Body
from pgimp.case.checks.domain import check_grid
from pgimp.case.grid import Grid
from pgimp.case.output import PointProbe
from pgimp.geometry.regions import REGIONS
from pgimp.geometry.regions.base import Region
from pgimp.physics.contact.pairs import ContactEntry
from pgimp.physics.loads.constraints import ConstraintEntry
from pgimp.physics.loads.motion import RigidMotion, check_rotation
from pgimp.physics.loads.tractions import TractionEntry
from pgimp.physics.materials import MATERIALS
from pgimp.physics.materials.base import Material
from pgimp.physics.rigid import FREEDOMS, Free, Motion, RigidBody
from pgimp.schema.messages import unknown
from pgimp.schema.problems import Problem
from pgimp.schema.registries import name_of
from pgimp.schema.sizes import AXES, WHOLE, Problems, faces, length

MOST_PARTS = 5000
"""Of a region: if these overlap, a few hundred thousand particles take a minute."""


def check_materials(bodies: Mapping[str, Body], declared: Iterable[str]) -> Problems:
    """Check that the bodies' materials are known."""
    for name, body in bodies.items():
        if body.material not in declared:
            text = unknown("material", body.material, declared)
            yield Problem(("bodies", name, "material"), text)


def check_velocities(dimensions: int, bodies: Mapping[str, Body]) -> Problems:
    """Check that initial velocities fit the dimensions."""
    for name, body in bodies.items():
        path = ("bodies", name, "velocity")
        if isinstance(body.velocity, tuple):
            yield from length(path, body.velocity, dimensions)
            continue
        rotation = body.velocity.rotation
        yield from length((*path, "translation"), body.velocity.translation, dimensions)
        yield from check_rotation((*path, "rotation"), rotation, dimensions)
        if dimensions == 1:
            yield Problem((*path, "rotation"), "there is no rotation in one dimension")


def _region(path: tuple[str | int, ...], region: Any, dimensions: int) -> Problems:
    """Check one region and its parts."""
    if (parts := region.parts) > MOST_PARTS:
        yield Problem(path, f"{parts:,} regions in one are too many (at most {MOST_PARTS:,})")
        return
    name = name_of(region, REGIONS)
    path = (*path, name)
    if isinstance(region, RootModel):
        for i, part in enumerate(region.root):
            yield from _region((*path, i), part, dimensions)
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
    for field, info in type(region).model_fields.items():
        yield from length((*path, info.alias or field), getattr(region, field), dimensions)


def check_regions(dimensions: int, grid: Grid, bodies: Mapping[str, Body]) -> Problems:
    """Check that regions fit the dimensions and lie in the domain."""
    sound = not list(check_grid(dimensions, grid))
    for name, body in bodies.items():
        path = ("bodies", name, "region")
        wrong = list(_region(path, body.region, dimensions))
        yield from wrong
        if wrong or not sound:
            continue
        if not any(region.FROM_FILE for region in body.region.simple()):
            yield from check_bounds(path, body.region, dimensions, grid)


def check_bounds(
    path: tuple[str | int, ...], region: Region, dimensions: int, grid: Grid
) -> Problems:
    """Check that a body's region has an end, is not empty and lies in the domain."""
    low, high = region.bounds()
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


def check_tools(
    dimensions: int, body_names: Sequence[str], rigid_bodies: Mapping[str, RigidBody]
) -> Problems:
    """Check that rigid bodies fit the dimensions and have an end, and that there is another."""
    if rigid_bodies and not body_names:
        yield Problem(("bodies",), "all are rigid; a case needs a body of a material")
    for name, rigid_body in rigid_bodies.items():
        path: tuple[str | int, ...] = ("bodies", name)
        if isinstance(rigid_body.rigid, Free):
            yield from _free(path, dimensions, rigid_body, rigid_body.rigid)
        else:
            yield from _motion((*path, "rigid"), dimensions, rigid_body.rigid)
            if rigid_body.velocity is not None:
                text = (
                    "a rigid body without density moves as `rigid` says, {velocity: ..}; one that "
                    "moves freely has a density: rigid: {density: ..}"
                )
                yield Problem((*path, "velocity"), text)
        wrong = list(_region((*path, "region"), rigid_body.region, dimensions))
        yield from wrong
        for region in () if wrong else rigid_body.region.simple():
            if region.WHOLE_BODY:
                yield Problem((*path, "region"), "a rigid body has no particles, also from a file")
        if wrong or any(region.FROM_FILE for region in rigid_body.region.simple()):
            continue
        low, high = rigid_body.region.bounds()
        if any(a > b for a, b in zip(low, high, strict=True)):
            yield Problem((*path, "region"), "is empty: no point lies in it")
        elif not all(map(math.isfinite, (*low, *high))):
            text = "has no end; let it reach beyond the domain: region: {intersection: [{box: ..}, "
            yield Problem((*path, "region"), text + "{half-space: ..}]}")


def _free(path: tuple[str | int, ...], dimensions: int, body: RigidBody, free: Free) -> Problems:
    """Check that the motion of a free rigid body fits the dimensions."""
    every = ("x",), ("x", "y", "rotation"), (*FREEDOMS, "rotation")
    ways: tuple[str, ...] = every[dimensions - 1]
    for i, way in enumerate(free.fixed):
        if way not in ways and not (dimensions == 2 and way == "rotation-z"):
            yield Problem((*path, "rigid", "fixed", i), unknown("way", way, ways))
    where, may = (*path, "velocity"), free.may(dimensions)
    along = body.velocity
    about: tuple[float, ...] = ()
    if isinstance(along, RigidMotion):
        rotation, along = along.rotation, along.translation
        if dimensions == 1:
            yield Problem((*where, "rotation"), "there is no rotation in one dimension")
            return
        yield from check_rotation((*where, "rotation"), rotation, dimensions)
        about = rotation.rate if isinstance(rotation.rate, tuple) else (0.0, 0.0, rotation.rate)
    yield from length(where, along or (0.0,) * dimensions, dimensions)
    for values, moves in ((along or (), may[:3]), (about, may[3:])):
        if any(v and not way for v, way in zip(values, moves, strict=False)):
            yield Problem(where, "it moves in a way that `fixed` excludes")


def _motion(path: tuple[str | int, ...], dimensions: int, motion: Motion) -> Problems:
    """Check that the motion of a rigid body fits the dimensions."""
    if isinstance(motion.velocity, tuple):
        yield from length((*path, "velocity"), motion.velocity, dimensions)
    elif motion.velocity is not None:
        for i, (_, value) in enumerate(motion.velocity.table):
            yield from length((*path, "velocity", "table", i, 1), value, dimensions)
    if motion.rotation is None:
        return
    if dimensions == 1:
        yield Problem((*path, "rotation"), "there is no rotation in one dimension")
        return
    yield from length((*path, "rotation", "about"), motion.rotation.about, dimensions)
    if dimensions == 2 and any(motion.rotation.axis[:2]):
        yield Problem((*path, "rotation", "axis"), "in 2D the axis is z; leave it out")


def _beyond(
    path: tuple[str | int, ...], face: str, reach: float, wall: float, what: str
) -> Problem:
    return Problem(
        path,
        f"reaches {abs(reach - wall):.6g} beyond the domain at {face}: to {reach:.15g}"
        f"{what and f' with {what}'}, where the domain ends at {wall:.15g}",
    )


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
    materials: Mapping[str, Material],
    tractions: Mapping[str, TractionEntry],
) -> Problems:
    """Check that tractions act on faces of boxes, and on solids."""
    for name, entry in tractions.items():
        path: tuple[str | int, ...] = ("tractions", name)
        why = "a traction pulls at a body of a material; a rigid one moves as its key `rigid` says"
        yield from check_body_of(path, entry, every_body, body_names, why)
        if entry.face not in faces(dimensions):
            yield Problem((*path, "face"), unknown("face", entry.face, faces(dimensions)))
        if entry.body in bodies and name_of(bodies[entry.body].region, REGIONS) != "box":
            kind = name_of(bodies[entry.body].region, REGIONS)
            yield Problem(
                (*path, "body"),
                f"the region of '{entry.body}' is a {kind}; tractions act on faces of a box",
            )
        law = materials.get(bodies[entry.body].material) if entry.body in bodies else None
        if law is not None and law.VOLUME_ONLY:
            text = (
                f"'{entry.body}' flows ({name_of(law, MATERIALS)}): of its deformation only the "
                "volume is known, and no face; press it with a rigid body or a moving wall "
                "(boundaries)"
            )
            yield Problem((*path, "body"), text)
        yield from length((*path, "traction"), entry.traction, dimensions)
        for i, (_, value) in enumerate(getattr(entry.traction, "table", ())):
            yield from length((*path, "traction", "table", i, 1), value, dimensions)


def check_constraints(
    dimensions: int,
    grid: Grid,
    every_body: Mapping[str, Body | RigidBody],
    body_names: Iterable[str],
    constraints: Mapping[str, ConstraintEntry],
) -> Problems:
    """Check that constraints hold parts of bodies, within the domain."""
    sound = not list(check_grid(dimensions, grid))
    for name, entry in constraints.items():
        path: tuple[str | int, ...] = ("constraints", name)
        why = "a constraint holds parts of a body of a material; give a rigid one its motion by"
        why += " its key `rigid`"
        yield from check_body_of(path, entry, every_body, body_names, why)
        wrong = list(_region((*path, "region"), entry.region, dimensions))
        yield from wrong
        yield from length((*path, "velocity"), entry.velocity, dimensions)
        if wrong or not sound or any(region.FROM_FILE for region in entry.region.simple()):
            continue
        low, high = entry.region.bounds()
        within = zip(low, high, grid.origin, grid.corner, strict=True)
        if any(a > b for a, b in zip(low, high, strict=True)):
            yield Problem((*path, "region"), "is empty: no point lies in it")
        elif any(b < least or a > most for a, b, least, most in within):
            yield Problem((*path, "region"), "lies beyond the domain, where no particle comes")


def check_contact(
    body_names: Sequence[str],
    rigid_bodies: Mapping[str, RigidBody],
    contact: Sequence[ContactEntry],
) -> Problems:
    """Check that the entries of contact name bodies, and no pair twice."""
    body_names = [*body_names, *rigid_bodies]
    earlier: dict[frozenset[str], int] = {}
    for i, entry in enumerate(contact):
        path: tuple[str | int, ...] = ("contact", i, "bodies")
        pairs = {frozenset(pair) for pair in entry.pairs()} or {frozenset(("all",))}
        if entry.bodies != "all":
            for k, name in enumerate(entry.bodies):
                if name not in body_names:
                    yield Problem((*path, k), unknown("body", name, body_names))
        elif len(body_names) < 2:
            yield Problem(path, "there is only one body, which meets no other")
        if entry.bodies != "all" and set(entry.bodies) <= set(rigid_bodies):
            text = (
                "all are rigid, and rigid bodies do not feel each other: leave the entry out, or "
                "make one of them a body of a material"
            )
            yield Problem(path, text)
        for pair in sorted(pairs & set(earlier), key=sorted)[:1]:
            names = " and ".join(sorted(pair))
            yield Problem(path, f"entry {earlier[pair] + 1} has a law for {names} already")
        earlier |= dict.fromkeys(pairs, i)


def check_adhesion(grid: Grid, contact: Sequence[ContactEntry]) -> Problems:
    """Check that adhesion acts over gaps that a vertex can resolve."""
    for i, entry in enumerate(contact):
        cell = min(grid.cell)
        if entry.adhesion is not None and entry.adhesion.reach > cell:
            text = f"must be at most the side of a cell, {cell:.15g}: bodies meet at vertices"
            yield Problem(("contact", i, "adhesion", "reach"), text)
