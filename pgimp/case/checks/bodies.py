"""Checks of bodies of a material, their tractions and constraints."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from pgimp.case.body import Body
from pgimp.case.checks.domain import check_grid
from pgimp.case.grid import Grid
from pgimp.case.output import PointProbe
from pgimp.geometry.regions import REGIONS, Points
from pgimp.physics.boundaries.base import Boundary
from pgimp.physics.loads.constraints import ConstraintEntry
from pgimp.physics.loads.tractions import TractionEntry
from pgimp.physics.materials import MATERIALS
from pgimp.physics.materials.base import Material
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
    materials: Mapping[str, Material],
    tractions: Mapping[str, TractionEntry],
    gravity: object,
) -> Problems:
    """Check that tractions act on faces of boxes or on regions' surfaces, and on solids."""
    for name, entry in tractions.items():
        path: tuple[str | int, ...] = ("tractions", name)
        why = "a traction pulls at a body of a material; a rigid one moves as its key `rigid` says"
        yield from check_body_of(path, entry, every_body, body_names, why)
        if entry.face is None:
            yield from _surface_problems(path, entry, bodies, gravity)
        elif entry.face not in faces(dimensions):
            yield Problem((*path, "face"), unknown("face", entry.face, faces(dimensions)))
        elif entry.body in bodies and name_of(bodies[entry.body].region, REGIONS) != "box":
            kind = name_of(bodies[entry.body].region, REGIONS)
            yield Problem(
                (*path, "face"),
                f"the region of '{entry.body}' is a {kind}, which has no such faces; load the part "
                "of its surface that lies in a region: region: {box: ..} in place of face",
            )
        law = materials.get(bodies[entry.body].material) if entry.body in bodies else None
        if law is not None and law.VOLUME_ONLY:
            text = (
                f"'{entry.body}' flows ({name_of(law, MATERIALS)}): of its deformation only the "
                "volume is known, and no face; press it with a rigid body or a moving wall "
                "(boundaries)"
            )
            yield Problem((*path, "body"), text)


def _surface_problems(
    path: tuple[str | int, ...], entry: TractionEntry, bodies: Mapping[str, Body], gravity: object
) -> Problems:
    """Check a load on the part of a surface that lies in a region."""
    if entry.body in bodies and isinstance(bodies[entry.body].region, Points):
        text = f"'{entry.body}' is of particles from a file, whose surface is not known"
        yield Problem((*path, "body"), text + "; load a body with a region or a mesh")
    if entry.hydrostatic is not None and gravity is None:
        text = "needs gravity, which gives the weight of the liquid: gravity: [0.0, -9.81]"
        yield Problem((*path, "hydrostatic"), text)


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


def check_turning(
    dimensions: int,
    geometry: str,
    boundaries: Mapping[str, Boundary],
    constraints: Mapping[str, ConstraintEntry],
) -> Problems:
    """Check that what turns can turn in this domain."""
    joined = {face[0] for face, entry in boundaries.items() if entry.joins}
    for name, entry in constraints.items():
        if not entry.rotation:
            continue
        path = ("constraints", name, "rotation")
        if geometry == "axisymmetric":
            text = "what is turned in the plane of radius and axis is no ring any more, and a "
            text += "rotation about the axis (swirl) is no motion of this geometry; leave it out"
            yield Problem(path, text)
        for axis in sorted(joined) if dimensions > 1 else ():
            if abs(entry.rotation.direction["xyz".index(axis)]) != 1.0:
                text = f"the domain is periodic along {axis}: each of its copies would turn about "
                text += f"a centre of its own; only a rotation about {axis} is the same for all"
                yield Problem(path, text)
