"""Initial motion of a body: its entry in the case."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from pgimp.schema.base import Model, Number, Vector
from pgimp.schema.dispatch import Either
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import Problems, length


def _zeros(schema: dict[str, Any]) -> None:
    """Document the default of a vector whose length depends on the dimensions of the case."""
    del schema["default"]


def zero_vector(description: str) -> Any:
    """Return a field for a vector that is zero by default."""
    return Field(
        default=(), validate_default=False, description=description, json_schema_extra=_zeros
    )


class Rotation(Model):
    """Rigid rotation."""

    about: Vector = Field(description="a point of the axis [length]")
    rate: Annotated[
        float | tuple[float, ...],
        Either("a number (2D) or a list of three (3D)", {float: Number, tuple: Vector}),
    ] = Field(
        description="angular velocity: a number in 2D, counter-clockwise positive; "
        "a vector along the axis in 3D [1/time]"
    )


def check_rotation(path: tuple[str | int, ...], rotation: Rotation, dimensions: int) -> Problems:
    """Check that a rotation fits the dimensions."""
    yield from length((*path, "about"), rotation.about, dimensions)
    if dimensions == 2 and isinstance(rotation.rate, tuple):
        text = f"expected a number in 2D, got a list of {len(rotation.rate)}"
        yield Problem((*path, "rate"), text)
    elif dimensions == 3 and not isinstance(rotation.rate, tuple):
        text = f"expected a vector along the axis in 3D, got {rotation.rate:.15g}"
        yield Problem((*path, "rate"), text)
    elif dimensions == 3:
        yield from length((*path, "rate"), rotation.rate, dimensions)


class RigidMotion(Model):
    """Velocity of a rigid motion: translation + rate x (position - about)."""

    rotation: Rotation = Field(description="rotation about an axis")
    translation: Vector = zero_vector("velocity added everywhere [length/time]")
