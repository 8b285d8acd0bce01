"""Features of geometry, method, bodies and contact, see `pgimp.case.checks.exclusions.table`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pgimp.case.body import has_means
from pgimp.case.checks.exclusions.feature import Feature, Place, named, of_bodies, of_key
from pgimp.geometry.regions import REGIONS, Box, Points
from pgimp.physics.loads.motion import RigidMotion
from pgimp.physics.rigid import RigidBody
from pgimp.schema.registries import name_of
from pgimp.schema.sizes import AXES
from pgimp.schema.tables import entries_of


def _initial(body: Any) -> bool:
    return bool(body.formulation == "total-lagrangian")


def some_initial(bodies: Any) -> list[str]:
    """Return the names of the bodies in the initial configuration."""
    return [name for name, body in bodies.items() if _initial(body)]


def _along(path: tuple[str | int, ...], value: Any) -> Iterator[Place]:
    """Places of a vector, constant or over time, in the directions of its components."""
    turns = isinstance(value, RigidMotion)
    rows = [(1.0, 1.0)] if turns else [row for _, row in entries_of(value)]
    for i, axis in enumerate(AXES):
        if any(len(row) > i and row[i] != 0.0 for row in rows):
            yield Place(path, axis=axis)


# Geometry and method.
axisymmetric = of_key(
    "axisymmetric scenes", "geometry", lambda geometry: geometry == "axisymmetric", "x"
)
plane_stress = of_key("plane stress", "geometry", lambda geometry: geometry == "plane-stress")
not_plane = of_key("1 or 3 dimensions", "dimensions", lambda dimensions: dimensions != 2)
without_rings = of_key(
    "tents, B-splines, `cpdi-corners`", "method.shape", lambda method: not method.rings
)
no_boxes = of_key(
    "points, tents, `cpdi-corners`",
    "method.shape",
    lambda method: not (method.chi == "box" and method.separable),
)
of_points = of_key("points (`mpm`)", "method.shape", lambda method: method.is_point)
not_separable = of_key("`cpdi-corners`", "method.shape", lambda method: not method.separable)
initial_volume = of_key("`volume: initial`", "method.volume", lambda method: not method.tracked)
mean = Feature(
    "mean dilatation",
    lambda bodies, method: (
        Place(path, method.name)
        for path in dict.fromkeys(
            ("bodies", name, "volumetric") if body.volumetric else ("method", "volumetric")
            for name, body in bodies.items()
            if has_means(body, method)
        )
    ),
)
ordered = of_key(
    "`stress: average` and `last-mapped`", "method.stress", lambda method: method.stress != "last"
)
one_particle = Feature(
    "one particle along two or three directions of a cell",
    lambda method: (
        Place(("method", "particles-per-cell"), f"{once}")
        for once in [list(method.particles_per_cell).count(1)]
        if once > 1
    ),
)

# Bodies of a material.
beyond_cells = of_key("tents, B-splines", "method.shape", lambda method: not method.in_cell)
initial = of_bodies("bodies in the initial configuration", "formulation", lambda b, _: _initial(b))
averaged = Feature(
    "averaged mass",
    lambda bodies, method: (
        Place(("bodies", name, "mass") if body.mass else ("method", "mass"), name, name)
        for name, body in bodies.items()
        if (body.mass or method.mass) == "averaged"
    ),
)
initial_on_lattice = of_bodies(
    "bodies in the initial configuration, on the lattice",
    "formulation",
    lambda body, _: _initial(body) and not isinstance(body.region, Points),
)
initial_with_memory = of_bodies(
    "bodies in the initial configuration whose law cannot begin with a stress",
    "formulation",
    lambda body, law: _initial(body) and not (law.CARRIES_STRESS and law.CARRIES_PRESSURE),
)
initial_not_uniform = of_bodies(
    "bodies in the initial configuration that begin with a rotation or a function",
    "velocity",
    lambda body, _: _initial(body) and not isinstance(body.velocity, tuple),
)
exact_surface = of_bodies("`surface: exact`", "surface", lambda body, _: body.surface == "exact")
whole_beside_current = Feature(
    "bodies in the initial configuration with `surface: whole-particles` beside the current one",
    lambda bodies: (
        Place(("bodies", name, "surface"), name, name)
        for name in some_initial(bodies)
        if bodies[name].surface == "whole-particles" and len(some_initial(bodies)) < len(bodies)
    ),
)
in_current = of_bodies(
    "bodies in the current configuration", "formulation", lambda b, _: not _initial(b)
)
all_initial = Feature(
    "all bodies in the initial configuration",
    lambda bodies: (
        Place(("bodies", name, "formulation"), name)
        for name in some_initial(bodies)[:1]
        if len(some_initial(bodies)) == len(bodies)
    ),
)
mixed = Feature(
    "bodies of both configurations",
    lambda bodies: (
        Place(
            ("bodies", name, "formulation"), f"'{name}' is total Lagrangian and '{other}' updated"
        )
        for name in some_initial(bodies)[:1]
        for other in [one for one in bodies if not _initial(bodies[one])][:1]
    ),
)
liquid = of_bodies("laws of the volume alone", "material", lambda _, law: law.VOLUME_ONLY)
loose = of_bodies("liquids and loose soil", "material", lambda _, law: law.flow_speed > 0.0)
varying = of_bodies("materials that vary in space", "material", lambda _, law: law.variations)
varying_density = of_bodies(
    "a density that varies in space", "material", lambda _, law: ("density",) in law.variations
)
more_than_inertia = of_bodies(
    "laws with a density that is more than inertia",
    "material",
    lambda _, law: not law.INERTIA_ALONE,
)
points = of_bodies("particles of a file", "region", lambda body, _: isinstance(body.region, Points))
no_box = Feature(
    "regions but boxes",
    lambda bodies: (
        Place(("bodies", name, "region"), name_of(body.region, REGIONS), name)
        for name, body in bodies.items()
        if not isinstance(body.region, Box)
    ),
)
begins_moving = of_bodies(
    "bodies that begin with a velocity",
    "velocity",
    lambda body, _: not isinstance(body.velocity, tuple) or any(body.velocity),
)
not_across = Feature(
    "laws but hooke, neo-hookean, von-mises",
    lambda materials: (
        Place(("materials", name, "model"), getattr(law, "model", "it"))
        for name, law in materials.items()
        if not law.PLANE_STRESS
    ),
)

# Rigid bodies, what moves and what acts along an axis, and contact.
rigid = named("rigid bodies", "every_body", "rigid", lambda body: isinstance(body, RigidBody))
free_rigid = named("rigid bodies that move freely", "rigid_bodies", "rigid", lambda body: body.free)


def _motions(bodies: Any, rigid_bodies: Any) -> Iterator[Place]:
    for name, body in {**bodies, **rigid_bodies}.items():
        yield from _along(("bodies", name, "velocity"), body.velocity)
    for name, body in rigid_bodies.items():
        if body.free is None:
            turns = (1.0, 1.0) if body.rigid.rotation is not None else body.rigid.velocity
            yield from _along(("bodies", name, "rigid"), turns)
        elif body.free.spring is not None:
            yield from _along(("bodies", name, "rigid", "spring", "to"), body.free.spring.to)


def _forces(gravity: Any, rigid_bodies: Any) -> Iterator[Place]:
    yield from _along(("gravity",), gravity)
    for name, body in rigid_bodies.items():
        if body.free is not None:
            yield from _along(("bodies", name, "rigid", "force"), body.free.force)


motions = Feature("motion along an axis", _motions)
forces = Feature("gravity, and forces on free rigid bodies, along an axis", _forces)


def _meetings(bodies: Any, rigid_bodies: Any, boundaries: Any, contact: Any) -> Iterator[Place]:
    some = some_initial(bodies)
    walls = some and any(entry.approaches for entry in boundaries.values())
    for there, text in (
        (contact, "contact"),
        (rigid_bodies, f"contact with the rigid body '{next(iter(rigid_bodies), '')}'"),
        (0 < len(some) < len(bodies), "contact of bodies of both configurations"),
        (walls, "contact with a unilateral wall in the initial configuration"),
    ):
        if there:
            yield Place(("contact",), text)
            return


meetings = Feature("contact, also with rigid bodies and between configurations", _meetings)
meetings_by_surfaces = Feature(
    "contact, rigid bodies, unilateral walls, if all bodies are in the initial configuration",
    lambda bodies, rigid_bodies, boundaries, contact: (
        place
        for place in _meetings(bodies, rigid_bodies, boundaries, contact)
        if len(some_initial(bodies)) == len(bodies) > 0
    ),
)
