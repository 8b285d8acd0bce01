"""Checks of periodic faces: pairs of them, and what suits a domain without ends."""

from __future__ import annotations

from collections.abc import Mapping

from pgimp.case.body import Body
from pgimp.case.grid import Grid
from pgimp.case.output import Output
from pgimp.physics.boundaries.base import Boundary
from pgimp.physics.loads import BODY_FORCES
from pgimp.physics.loads.bodyforce import BodyForceEntry
from pgimp.physics.rigid import RigidBody
from pgimp.physics.shapes.base import Shape
from pgimp.schema.problems import Problem
from pgimp.schema.registries import name_of
from pgimp.schema.sizes import Problems


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
    body_force: BodyForceEntry | None,
) -> Problems:
    """Check that bodies and loads are of a kind that knows a periodic domain."""
    axes = periodic_axes(boundaries)
    if not axes:
        return
    faces = f"{'xyz'[axes[0]]}-min and {'xyz'[axes[0]]}-max are periodic"
    for name, body in bodies.items():
        if body.configuration == "initial":
            yield Problem(
                ("bodies", name, "configuration"),
                f"{faces}, which bodies in the initial configuration do not know yet; take current",
            )
    for name in rigid_bodies:
        yield Problem(
            ("bodies", name, "rigid"),
            f"{faces}, and rigid bodies have no images beyond them yet; take walls (fixed, slip, "
            "velocity, separating) along the other directions, or a stiff body of a material",
        )
    if body_force is not None:
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
