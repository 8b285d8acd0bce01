"""Prescribed velocity on a face: v as given at the step's end, a its rate over the step."""

from typing import NamedTuple

from pydantic import Field

from pgimp.physics.boundaries.base import Boundary
from pgimp.schema.tables import Component, prescribed
from pgimp.schema.time_functions import TimeFunction


class VelocityParameters(NamedTuple):
    """Face, held components, their velocities and accelerations; 0 where free."""

    axis: int
    side: int
    held: tuple[bool, bool, bool]
    velocity: tuple[float, float, float]
    rate: tuple[float, float, float]

    @staticmethod
    def constrain(face, v, a):
        """Set the held components."""
        h, u, r = face.held, face.velocity, face.rate
        return (
            (u[0] if h[0] else v[0], u[1] if h[1] else v[1], u[2] if h[2] else v[2]),
            (r[0] if h[0] else a[0], r[1] if h[1] else a[1], r[2] if h[2] else a[2]),
        )


class Velocity(Boundary):
    """Moves the material on a face at a given velocity, component by component."""

    velocity: tuple[Component, ...] = Field(
        description="velocity [length/time] along each direction: a number, a table over time, "
        "or null where the component is free"
    )

    @property
    def mirrors(self) -> bool:
        """See `Boundary.mirrors`: a moving wall is no plane of symmetry."""
        return False

    @property
    def varies(self) -> bool:
        """See `Boundary.varies`."""
        return any(isinstance(component, TimeFunction) for component in self.velocity)

    def speed(self, axis: int, end: float) -> float | None:
        """See `Boundary.speed`."""
        held, velocity, _ = prescribed(self.velocity, end, end)
        return velocity[axis] if held[axis] else None

    def motion(self, end: float) -> tuple[float, float, float] | None:
        """See `Boundary.motion`."""
        held, velocity, _ = prescribed(self.velocity, end, end)
        return velocity if all(held[: len(self.velocity)]) else None

    def parameters(self, axis: int, side: int, start: float, end: float) -> VelocityParameters:
        """See `Boundary.parameters`."""
        return VelocityParameters(axis, side, *prescribed(self.velocity, start, end))
