"""Checks of the geometry of a scene in two dimensions: what axisymmetry and plane stress allow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pgimp.case.body import Body
from pgimp.case.grid import Grid
from pgimp.case.start import StartEntry
from pgimp.physics.boundaries.base import Boundary
from pgimp.physics.boundaries.slip import Slip
from pgimp.physics.contact.pairs import ContactEntry
from pgimp.physics.functions.entry import FunctionEntry
from pgimp.physics.loads.motion import RigidMotion
from pgimp.physics.materials.base import Material
from pgimp.physics.rigid import Free, RigidBody
from pgimp.physics.shapes.base import Shape
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import Problems
from pgimp.schema.tables import entries_of


def check_plane(dimensions: int, geometry: str) -> Problems:
    """Check that axisymmetry and plane stress have two dimensions."""
    axes = {"axisymmetric": ", the radius x and the axis y", "plane-stress": ""}.get(geometry)
    if axes is not None and dimensions != 2:
        yield Problem(
            ("geometry",), f"{geometry} is for 2 dimensions{axes}, but the case has {dimensions}"
        )


def check_geometry(dimensions: int, geometry: str, grid: Grid, method: Shape) -> Problems:
    """Check that axisymmetry has a radius from 0 on, and a shape that knows it."""
    if geometry != "axisymmetric" or dimensions != 2:
        return
    if len(grid.origin) == 2 and grid.origin[0] < 0.0:
        yield Problem(
            ("grid", "origin", 0),
            f"x is the radius, from the axis at 0 on, but the grid begins at {grid.origin[0]:g}; "
            "begin at 0, or above for what has a hole",
        )
    elif len(grid.origin) == 2 and 0.0 < grid.origin[0] < grid.cell[0]:
        yield Problem(
            ("grid", "origin", 0),
            f"begins within a cell from the axis, {grid.origin[0]:g}; begin at 0, or a cell away",
        )
    if not method.rings:
        yield Problem(
            ("method", "shape"),
            f"{method.name} has no axisymmetric weights; take gimp, finite-gimp, cpdi or mpm",
        )


def check_plane_stress(
    geometry: str,
    materials: Mapping[str, Material],
    method: Shape,
    start: StartEntry | None,
    exact: object,
) -> Problems:
    """Check that the stress out of the plane can be zero."""
    if geometry != "plane-stress":
        return
    if method.volumetric == "mean":
        yield Problem(
            ("method", "volumetric"),
            "mean is against locking, which plane stress does not have; take pointwise",
        )
    for name, law in materials.items():
        if not law.PLANE_STRESS:
            yield Problem(
                ("materials", name, "model"),
                f"{getattr(law, 'model', 'it')} is not known in plane stress; hooke, neo-hookean "
                "and von-mises are",
            )
    if start is not None and start.stress is not None:
        yield Problem(
            ("start", "stress"), "has a part out of the plane; take settle, or plane-strain"
        )
    if exact is not None and not isinstance(exact, FunctionEntry):
        yield Problem(("exact",), "is not known in plane stress; leave it out")


def check_axis(
    geometry: str,
    grid: Grid,
    boundaries: Mapping[str, Boundary],
    gravity: object,
    body_force: object,
    exact: object,
) -> Problems:
    """Check that nothing acts along the radius that an axis does not allow."""
    if geometry != "axisymmetric":
        return
    first = boundaries.get("x-min")
    if grid.origin[:1] == (0.0,) and first is not None and not isinstance(first, Slip):
        yield Problem(
            ("boundaries", "x-min"),
            "is the axis, across which nothing moves: leave it out, or take slip",
        )
    if _radial(gravity):
        yield Problem(
            ("gravity",), "acts along the axis, y, alone: x is the radius; take [0.0, ...]"
        )
    for name, value in (("body_force", body_force), ("exact", exact)):
        if value is not None and not isinstance(value, FunctionEntry):
            yield Problem((name,), "is not known in axisymmetry; leave it out")


def check_rings(
    geometry: str,
    materials: Mapping[str, Material],
    bodies: Mapping[str, Body],
    rigid_bodies: Mapping[str, RigidBody],
    boundaries: Mapping[str, Boundary],
    contact: Sequence[ContactEntry],
    method: Shape,
) -> Problems:
    """Check that bodies and loads are of a kind that exists in axisymmetry."""
    if geometry != "axisymmetric":
        return
    initial = [name for name, body in bodies.items() if body.configuration == "initial"]
    if 0 < len(initial) < len(bodies):
        yield Problem(
            ("bodies", initial[0], "configuration"),
            "in axisymmetry all bodies have the same; take initial, or current, for all",
        )
    for name, body in bodies.items():
        if isinstance(body.velocity, RigidMotion) or _radial(body.velocity):
            yield Problem(
                ("bodies", name, "velocity"),
                "is along the axis, y, alone, as all of a body moves at it: x is the radius",
            )
        law = materials.get(body.material)
        # What keeps a flow's volume (`kernels/flows/filling.py`) divides the volumes summed at a
        # vertex by a cell of the plane: of rings they are 2 pi r times as great. Its shift is along
        # gradients without the hoop, and would move rings across the axis.
        if law is not None and law.flow_speed > 0.0:
            yield Problem(
                ("bodies", name, "material"),
                f"'{body.material}' flows, which is not known in axisymmetry yet",
            )
    for name, rigid in rigid_bodies.items():
        if isinstance(rigid.rigid, Free):
            yield from _free(("bodies", name), rigid, rigid.rigid)
        elif rigid.rigid.rotation is not None or _radial(rigid.rigid.velocity):
            yield Problem(
                ("bodies", name, "rigid"), "moves along the axis, y, alone: x is the radius"
            )


def _free(path: tuple[str, str], body: RigidBody, free: Free) -> Problems:
    """Check that a rigid body that moves freely is moved along the axis alone."""
    if isinstance(body.velocity, RigidMotion) or _radial(body.velocity):
        yield Problem(
            (*path, "velocity"), "is along the axis, y, alone, on which the body stays: [0.0, ...]"
        )
    if _radial(free.force):
        yield Problem(
            (*path, "rigid", "force"), "acts along the axis, y, alone: x is the radius; [0.0, ...]"
        )
    if free.spring is not None and free.spring.to and free.spring.to[0] != 0.0:
        yield Problem(
            (*path, "rigid", "spring", "to"), "begins on the axis, where the centre is: [0.0, ...]"
        )


def _radial(value: object) -> bool:
    """Whether a vector has a component along the radius, at any time."""
    return any(len(row) == 2 and row[0] != 0.0 for _, row in entries_of(value))
