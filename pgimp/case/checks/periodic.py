"""Checks of periodic faces: pairs of them, and what suits a domain without ends."""

from __future__ import annotations

from collections.abc import Mapping

from pgimp.case.grid import Grid
from pgimp.case.output import Output
from pgimp.physics.boundaries.base import Boundary
from pgimp.physics.shapes.base import Shape
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import Problems


def periodic_axes(boundaries: Mapping[str, Boundary]) -> list[int]:
    """Directions of which a face is periodic."""
    return sorted({"xyz".index(face[0]) for face, entry in boundaries.items() if entry.joins})


def check_periodic_faces(boundaries: Mapping[str, Boundary]) -> Problems:
    """Check that both faces of a direction are periodic."""
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


def check_unwrapped(boundaries: Mapping[str, Boundary], output: Output) -> Problems:
    """Check that unwrapped positions are of a periodic domain."""
    if "unwrapped" in output.fields and not periodic_axes(boundaries):
        yield Problem(
            ("output", "fields", output.fields.index("unwrapped")),
            "no face is periodic, so that it would be the position; leave it out",
        )
