"""Checks of rigid bodies and of contact."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence

from pgimp.case.body import Body
from pgimp.case.grid import Grid
from pgimp.case.output import Output
from pgimp.physics.boundaries.base import Boundary
from pgimp.physics.contact.pairs import ContactEntry
from pgimp.physics.loads.motion import RigidMotion
from pgimp.physics.rigid import FREEDOMS, Free, RigidBody
from pgimp.schema.messages import unknown
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import Problems


def check_rigid_bodies(
    dimensions: int, body_names: Sequence[str], rigid_bodies: Mapping[str, RigidBody]
) -> Problems:
    """Check that rigid bodies fit the dimensions and have an end, and that there is another."""
    if rigid_bodies and not body_names:
        yield Problem(("bodies",), "all are rigid; a case needs a body of a material")
    for name, rigid_body in rigid_bodies.items():
        path: tuple[str | int, ...] = ("bodies", name)
        if isinstance(rigid_body.rigid, Free):
            yield from _free(path, dimensions, rigid_body, rigid_body.rigid)
        elif rigid_body.velocity is not None:
            text = (
                "a rigid body without density moves as `rigid` says, {velocity: ..}; one that "
                "moves freely has a density: rigid: {density: ..}"
            )
            yield Problem((*path, "velocity"), text)
        for region in rigid_body.region.simple():
            if region.WHOLE_BODY:
                yield Problem((*path, "region"), "a rigid body has no particles, also from a file")
        if any(region.FROM_FILE for region in rigid_body.region.simple()):
            continue
        low, high = rigid_body.region.bounds()
        if any(a > b for a, b in zip(low, high, strict=True)):
            yield Problem((*path, "region"), "is empty: no point lies in it")
        elif not all(map(math.isfinite, (*low, *high))):
            text = "has no end; let it reach beyond the domain: region: {intersection: [{box: ..}, "
            yield Problem((*path, "region"), text + "{half-space: ..}]}")


def _free(path: tuple[str | int, ...], dimensions: int, body: RigidBody, free: Free) -> Problems:
    """Check that a free rigid body moves in ways that exist, and are not fixed."""
    every = ("x",), ("x", "y", "rotation"), (*FREEDOMS, "rotation")
    ways: tuple[str, ...] = every[dimensions - 1]
    for i, way in enumerate(free.fixed):
        if way not in ways and not (dimensions == 2 and way == "rotation-z"):
            yield Problem((*path, "rigid", "fixed", i), unknown("way", way, ways))
    may = free.may(dimensions)
    along = body.velocity
    about: tuple[float, ...] = ()
    if isinstance(along, RigidMotion):
        rate, along = along.rotation.rate, along.translation
        about = rate if isinstance(rate, tuple) else (0.0, 0.0, rate)
    for values, moves in ((along or (), may[:3]), (about, may[3:])):
        if any(v and not way for v, way in zip(values, moves, strict=False)):
            yield Problem((*path, "velocity"), "it moves in a way that `fixed` excludes")


def meet_by_surfaces(bodies: Mapping[str, Body]) -> bool:
    """Whether bodies meet at their own surfaces: where any is in the initial configuration.

    Those in the current one still meet each other at the vertices of the domain's grid.
    """
    return any(body.formulation == "total-lagrangian" for body in bodies.values())


def check_contact(
    body_names: Sequence[str],
    rigid_bodies: Mapping[str, RigidBody],
    contact: Sequence[ContactEntry],
    bodies: Mapping[str, Body],
    boundaries: Mapping[str, Boundary],
) -> Problems:
    """Check that the entries of contact name bodies, and no pair twice."""
    body_names, soft = [*body_names, *rigid_bodies], set(body_names)
    by_surfaces = meet_by_surfaces(bodies)
    free = by_surfaces and any(body.free for body in rigid_bodies.values())
    for face, condition in boundaries.items():
        if getattr(condition, "restitution", 0.0) and not free:
            text = (
                "its restitution is of rigid bodies that move freely, of which none meets it here: "
                "that takes scenes in which others have `formulation: total-lagrangian`; leave it "
                "out"
            )
            yield Problem(("boundaries", face), text)
    needs = "is for bodies with `formulation: total-lagrangian`"
    now = {name for name, body in bodies.items() if body.formulation == "updated-lagrangian"}
    earlier: dict[frozenset[str], int] = {}
    for i, entry in enumerate(contact):
        path: tuple[str | int, ...] = ("contact", i, "bodies")
        pairs = {frozenset(pair) for pair in entry.pairs()}
        if entry.itself:
            pairs |= {frozenset((name,)) for name in entry.bodies if entry.bodies != "all"}
            if not by_surfaces or (entry.bodies != "all" and now & set(entry.bodies)):
                yield Problem(("contact", i, "self"), f"{needs}: leave it out, or give them these")
        if entry.bodies == "all":
            pairs = {frozenset(("all",))}
        if entry.bodies != "all":
            for k, name in enumerate(entry.bodies):
                if name not in body_names:
                    yield Problem((*path, k), unknown("body", name, body_names))
        elif len(body_names) < 2 and not entry.itself:
            yield Problem(path, "there is only one body, which meets no other")
        if entry.bodies != "all" and not soft & set(entry.bodies) and not by_surfaces:
            text = (
                f"all are rigid, and contact of rigid bodies with each other {needs}: give them "
                "these, or leave the entry out"
            )
            yield Problem(path, text)
        yield from _restitution(i, entry, soft)
        for pair in sorted(pairs & set(earlier), key=sorted)[:1]:
            names = " and ".join(sorted(pair))
            yield Problem(path, f"entry {earlier[pair] + 1} has a law for {names} already")
        earlier |= dict.fromkeys(pairs, i)


def check_surface_output(
    output: Output,
    contact: Sequence[ContactEntry],
    bodies: Mapping[str, Body],
    boundaries: Mapping[str, Boundary],
) -> Problems:
    """Check that there are surfaces that meet, if frames of these are asked for."""
    if not output.surface:
        return
    path = "output", "surface"
    if not meet_by_surfaces(bodies):
        text = (
            "takes bodies that meet by their surfaces: give them `formulation: total-lagrangian`, "
            "or leave this out"
        )
        yield Problem(path, text)
    elif not contact and not any(face.approaches for face in boundaries.values()):
        yield Problem(path, "no bodies meet: name them under `contact`, or leave it out")


def _restitution(i: int, entry: ContactEntry, soft: Collection[str]) -> Problems:
    """Check that a coefficient of restitution is of rigid bodies only."""
    some = [*soft] if entry.bodies == "all" else [name for name in entry.bodies if name in soft]
    if entry.restitution and some:
        text = (
            f"is of rigid bodies with each other, and '{some[0]}' is of a material: how far it "
            "rebounds, its waves say; give the rigid ones an entry of their own"
        )
        yield Problem(("contact", i, "restitution"), text)


def check_adhesion(grid: Grid, contact: Sequence[ContactEntry]) -> Problems:
    """Check that adhesion acts over gaps that a vertex can resolve."""
    for i, entry in enumerate(contact):
        cell = min(grid.cell)
        if entry.adhesion is not None and entry.adhesion.reach > cell:
            text = f"must be at most the side of a cell, {cell:.15g}: bodies meet at vertices"
            yield Problem(("contact", i, "adhesion", "reach"), text)
