"""Checks of periodic faces: pairs of them, and what suits a domain without ends."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pgimp.case.body import Body
from pgimp.case.grid import Grid
from pgimp.case.output import Output
from pgimp.geometry.regions import Points
from pgimp.physics.boundaries.base import Boundary
from pgimp.physics.contact.pairs import ContactEntry
from pgimp.physics.functions.entry import FunctionEntry
from pgimp.physics.loads import BODY_FORCES
from pgimp.physics.loads.bodyforce import BodyForceEntry
from pgimp.physics.loads.tractions import TractionEntry
from pgimp.physics.rigid import RigidBody
from pgimp.physics.shapes.base import Shape
from pgimp.schema.problems import Problem
from pgimp.schema.registries import name_of
from pgimp.schema.sizes import WHOLE, Problems


def periodic_axes(boundaries: Mapping[str, Boundary]) -> list[int]:
    """Directions of which a face is periodic."""
    return sorted({"xyz".index(face[0]) for face, entry in boundaries.items() if entry.joins})


def check_periodic_faces(
    dimensions: int, geometry: str, grid: Grid, boundaries: Mapping[str, Boundary]
) -> Problems:
    """Check that both faces of a direction are periodic, and that it may be."""
    for axis in periodic_axes(boundaries):
        names = [f"{'xyz'[axis]}-{end}" for end in ("min", "max")]
        for one, other in (names, reversed(names)):
            if one in boundaries and boundaries[one].joins:
                if other not in boundaries or not boundaries[other].joins:
                    yield Problem(
                        ("boundaries", one),
                        f"periodic joins the faces {names[0]} and {names[1]}, but {other} is not; "
                        f"add {other}: periodic, or give {one} another condition",
                    )
                elif axis == 0 and geometry == "axisymmetric":
                    yield Problem(
                        ("boundaries", one),
                        "x is the radius, which has no period; only y-min and y-max may be "
                        "periodic in axisymmetry",
                    )


def check_period(
    dimensions: int, grid: Grid, method: Shape, boundaries: Mapping[str, Boundary]
) -> Problems:
    """Check that no support of a particle meets itself round a periodic domain."""
    for axis in periodic_axes(boundaries):
        if axis >= min(dimensions, len(grid.cells)) or grid.cells[axis] >= method.vertices:
            continue
        yield Problem(
            ("grid", "size", axis),
            f"{grid.cells[axis]} cells are too few for a periodic direction: particles reach over "
            f"{method.vertices} vertices, and would meet themselves; take {method.vertices} cells "
            "or more, or smaller ones",
        )


def check_periodic_bodies(
    boundaries: Mapping[str, Boundary],
    bodies: Mapping[str, Body],
    rigid_bodies: Mapping[str, RigidBody],
    contact: Sequence[ContactEntry],
    tractions: Mapping[str, TractionEntry],
    grid: Grid,
    body_force: BodyForceEntry | None,
) -> Problems:
    """Check that bodies and loads are of a kind that knows a periodic domain."""
    axes = periodic_axes(boundaries)
    if not axes:
        return
    faces = f"{'xyz'[axes[0]]}-min and {'xyz'[axes[0]]}-max are periodic"
    initial = [name for name, body in bodies.items() if body.configuration == "initial"]
    approached = any(entry.approaches for entry in boundaries.values())
    for name in initial:
        if contact or approached or rigid_bodies or len(initial) < len(bodies):
            yield Problem(
                ("bodies", name, "configuration"),
                f"{faces}, where bodies in the initial configuration meet nothing yet: no contact, "
                "separating walls, rigid bodies, or bodies in the current configuration; take "
                "current",
            )
        elif not isinstance(bodies[name].velocity, tuple):
            yield Problem(
                ("bodies", name, "velocity"),
                f"{faces}, where the vertices of bodies in the initial configuration begin at one "
                "velocity, [..]; take configuration: current",
            )
    for name, entry in tractions.items():
        if entry.face is None:
            ahead = entry.profile.direction if entry.profile else (0.0, 0.0, 0.0)
            if any(ahead[axis] for axis in axes):
                yield Problem(
                    ("tractions", name, "profile", "along"),
                    f"{faces}, where this coordinate would jump; take a direction along these "
                    "faces, or a longer domain without periodic faces",
                )
            continue
        body, axis = bodies.get(entry.body), "xyz".index(entry.face[0])
        if axis in axes and body is not None and not isinstance(body.region, Points):
            end = body.region.bounds()[entry.face.endswith("max")][axis]
            face = (grid.corner if entry.face.endswith("max") else grid.origin)[axis]
            if abs(end - face) <= WHOLE * grid.size[axis]:
                yield Problem(
                    ("tractions", name, "face"),
                    f"{entry.face} of '{entry.body}' is on a periodic face, behind which it may go "
                    "on; a body with an end there begins within the domain",
                )
    if body_force is not None and not isinstance(body_force, FunctionEntry):
        yield Problem(
            ("body_force", name_of(body_force, BODY_FORCES)),
            f"{faces}, but this force depends on the position, and would jump there; take gravity",
        )


def check_unwrapped(boundaries: Mapping[str, Boundary], output: Output) -> Problems:
    """Check that unwrapped positions are of a periodic domain."""
    if "unwrapped" in output.fields and not periodic_axes(boundaries):
        yield Problem(
            ("output", "fields", output.fields.index("unwrapped")),
            "no face is periodic, so that it would be the position; leave it out",
        )
