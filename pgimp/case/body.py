"""A body of a material: its entry in the case."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Field

from pgimp.geometry.regions import Points, RegionEntry
from pgimp.physics.loads.motion import RigidMotion, zero_vector
from pgimp.physics.loads.own_velocity import OwnVelocity
from pgimp.physics.shapes.base import Shape
from pgimp.schema.base import Model, Name, Vector, or_auto
from pgimp.schema.dispatch import Either, WithKey


class Body(Model):
    """A body: a region filled with particles of one material."""

    material: Name = Field(description="name of its material")
    region: RegionEntry = Field(description="the part of space that it fills at the start")
    surface: Literal["cut-particles", "whole-particles", "exact"] = Field(
        default="cut-particles",
        description="cut-particles: a particle that the surface cuts has the volume, mass and "
        "momentum of its part inside; of bodies in the initial configuration, in a shape no wider "
        "than cells, its weights and forces are those of this part, too, and vertices that hold "
        "next to nothing move with those next to them. whole-particles: those whose centre lies "
        "inside. exact: older word for `cut-particles` there",
    )
    velocity: Annotated[
        tuple[float, ...] | RigidMotion | OwnVelocity,
        Either(
            "one number a direction, {rotation: ...} or {function: ...}",
            {tuple: Vector, dict: WithKey("function", OwnVelocity, RigidMotion)},
        ),
    ] = zero_vector(
        "initial velocity: a vector, a rigid motion or a function of one's own [length/time]"
    )
    formulation: Literal["updated-lagrangian", "total-lagrangian"] = Field(
        default="updated-lagrangian",
        description="updated-lagrangian: particles move over the grid (the current configuration); "
        "for what flows or breaks. total-lagrangian: the grid is one of the body as it was at the "
        "start (the initial configuration), and moves and deforms with it: vibrations and spin "
        "last, nothing tears at any stretch, and steps are cheaper and do not become shorter as "
        "the body moves. Faces of the domain hold what lies on them at the start; `unilateral` "
        "ones, rigid bodies and other bodies, of either formulation, are met where they are. Left "
        "out where the method is chosen: total-lagrangian of what is elastic and keeps together, "
        "updated-lagrangian of what flows or tears",
        json_schema_extra=or_auto,
    )
    mass: Literal["lumped", "averaged"] | None = Field(
        default=None,
        description="mass of this body's vertices, see `method`; by default that of `method.mass`",
        json_schema_extra=or_auto,
    )
    volumetric: Literal["pointwise", "b-bar"] | None = Field(
        default=None,
        description="rate of volume change that this body's particles see, see `method`; by "
        "default that of `method.volumetric`",
        json_schema_extra=or_auto,
    )


def has_means(body: Body, method: Shape) -> bool:
    """Whether a body has mean dilatation."""
    return (body.volumetric or method.volumetric) == "b-bar"


def any_means(case: Any) -> bool:
    """Whether any body of a `Case` has mean dilatation, which 1D has not."""
    return case.dimensions > 1 and any(has_means(b, case.method) for b in case.bodies.values())


def scene_method(case: Any) -> Shape:
    """Return the method of a `Case` whose steps bear what any of its bodies needs."""
    volumetric = "b-bar" if any_means(case) else "pointwise"
    method: Shape = case.method
    return method.model_copy(update={"volumetric": volumetric})


def may_be_exact(bodies: Mapping[str, Body], method: Shape) -> list[bool]:
    """Whether each body can be exact to its surface, and is not to be `whole`.

    Weights of parts of particles are those of their cells. So shapes wider than these have none,
    nor have bodies from files of particles. Beside others in the current configuration, whose shape
    it then is, all can or none, and shapes may be as wide as they like.
    """
    able = [
        body.surface != "whole-particles" and not isinstance(body.region, Points)
        for body in bodies.values()
        if body.formulation == "total-lagrangian"
    ]
    mixed = 0 < len(able) < len(bodies)
    if (mixed and not all(able)) or not (method.in_cell or mixed):
        return [False] * len(bodies)
    found = iter(able)
    return [body.formulation == "total-lagrangian" and next(found) for body in bodies.values()]
