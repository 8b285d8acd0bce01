"""Rigid bodies: their entries in the case, and poses of prescribed motions."""

from __future__ import annotations

from math import hypot
from typing import Annotated, Literal, NamedTuple

from pydantic import Field

from pgimp.geometry.regions import RegionEntry
from pgimp.physics.loads.motion import RigidMotion
from pgimp.physics.loads.spring import AnchoredSpring
from pgimp.physics.loads.turning import Triple, Turning, rotation_matrix
from pgimp.schema.base import Model, Positive, Vector
from pgimp.schema.dispatch import Either, WithKey
from pgimp.schema.tables import VaryingVector, VectorFunction
from pgimp.schema.time_functions import TimeFunction


class Pose(NamedTuple):
    """Position and rotation of a rigid body."""

    #: (3,) float: Reference point: of its rotation, else the origin of coordinates displaced with
    #: the body.
    centre: Triple
    #: tuple of 9 float: Rotation matrix, row-major, from the initial to the present orientation.
    turn: tuple[float, ...]


class Motion(Model):
    """How a rigid body moves: its velocity, and a rotation besides. Nothing given: it stands."""

    velocity: VaryingVector = Field(
        default=None,
        description="velocity of the body, of its axis if it turns: a vector, or a table over "
        "time, linear in between and held at both ends; null: none [length/time]",
    )
    rotation: Turning | None = Field(default=None, description="rotation; null: none")

    @property
    def moves(self) -> bool:
        """Whether there is any motion."""
        return self.velocity is not None or self.rotation is not None

    def displacement(self, t: float) -> Triple:
        """Return the displacement of the reference point from time 0 to `t`."""
        if self.velocity is None:
            return (0.0, 0.0, 0.0)
        if isinstance(self.velocity, VectorFunction):
            shift = self.velocity.integral(t)
        else:
            shift = tuple(v * t for v in self.velocity)
        x, y, z = (*shift, 0.0, 0.0)[:3]
        return (x, y, z)

    @property
    def reference(self) -> Triple:
        """The reference point at the start."""
        about = self.rotation.about if self.rotation else ()
        x, y, z = (*(float(c) for c in about), 0.0, 0.0, 0.0)[:3]
        return (x, y, z)

    @property
    def axis(self) -> Triple:
        """Unit vector of the axis of rotation."""
        return self.rotation.direction if self.rotation else (0.0, 0.0, 1.0)

    def pose(self, t: float) -> Pose:
        """Return the pose at time `t`: exact, not summed over steps."""
        shift, start = self.displacement(t), self.reference
        turn = rotation_matrix(self.axis, self.rotation.angle(t) if self.rotation else 0.0)
        return Pose((start[0] + shift[0], start[1] + shift[1], start[2] + shift[2]), turn)

    def velocities(self, t: float) -> tuple[Triple, Triple]:
        """Return the velocity of the reference point and the angular velocity at time `t`."""
        velocity: tuple[float, ...] = ()
        if isinstance(self.velocity, VectorFunction):
            velocity = self.velocity.value(t)
        elif self.velocity is not None:
            velocity = self.velocity
        x, y, z = (*(float(v) for v in velocity), 0.0, 0.0, 0.0)[:3]
        rate = self.rotation.speed(t) if self.rotation else 0.0
        u, v, w = (rate * n for n in self.axis)
        return (x, y, z), (u, v, w)

    def mean_velocities(self, start: float, end: float) -> tuple[Triple, Triple]:
        """Return the means of `velocities` over a step: what it moves by, over the time."""
        along, about = self.velocities(end)
        dt = end - start
        if isinstance(self.velocity, VectorFunction) and dt > 0.0:
            u, v = self.displacement(start), self.displacement(end)
            along = ((v[0] - u[0]) / dt, (v[1] - u[1]) / dt, (v[2] - u[2]) / dt)
        if self.rotation and isinstance(self.rotation.rate, TimeFunction) and dt > 0.0:
            rate, (x, y, z) = (
                (self.rotation.angle(end) - self.rotation.angle(start)) / dt,
                self.axis,
            )
            about = (rate * x, rate * y, rate * z)
        return along, about

    def greatest(self) -> tuple[float, float]:
        """Return the greatest velocity of the reference point, and angular velocity."""
        velocity = self.velocity
        values = [velocity or ()]
        if isinstance(velocity, VectorFunction):
            values = [value for _, value in velocity.rows]
        rate = self.rotation.greatest if self.rotation else 0.0
        return max(hypot(*value) for value in values), rate


#: Degrees of freedom of a body; `fixed` lists those that a free rigid body lacks.
FREEDOMS = ("x", "y", "z", "rotation-x", "rotation-y", "rotation-z")


class Free(Model):
    """A rigid body that moves freely: by its inertia, gravity, and what it meets."""

    density: Positive = Field(
        description="of a rigid body that moves freely its density, everywhere the same "
        "[mass/length^3]"
    )
    fixed: tuple[
        Literal["x", "y", "z", "rotation-x", "rotation-y", "rotation-z", "rotation"], ...
    ] = Field(
        default=(),
        description="ways in which it does not move, whatever acts on it: along x, y, z, or "
        "rotation about their directions; rotation: about all of them",
    )
    force: VaryingVector = Field(
        default=None,
        description="force at its centre of mass: a vector, constant or over time [force]",
    )
    spring: AnchoredSpring | None = Field(
        default=None, description="a spring and dashpot to ground, at its centre of mass"
    )

    def may(self, dimensions: int) -> tuple[bool, ...]:
        """Return which of `FREEDOMS` it has."""
        there = (("x",), ("x", "y", "rotation-z"), FREEDOMS)[dimensions - 1]
        return tuple(
            freedom in there
            and freedom not in self.fixed
            and not (d > 2 and "rotation" in self.fixed)
            for d, freedom in enumerate(FREEDOMS)
        )

    def mirrored(self, axis: int, dimensions: int) -> bool:
        """Whether a body stays symmetric about a plane across `axis`.

        It does if it can only move along the plane and turn about the plane's normal.
        """
        may = self.may(dimensions)
        return not may[axis] and not any(may[3 + d] for d in range(3) if d != axis)


class RigidBody(Model):
    """A rigid body without particles: what it meets cannot enter it."""

    rigid: Annotated[Motion | Free, WithKey("density", Free, Motion)] = Field(
        description="of a body without particles how it moves: as prescribed ({}: it stands), such "
        "a body may reach beyond the domain; or freely, {density: ..}"
    )
    region: RegionEntry = Field(
        description="the part of space that it fills at the start; it may reach beyond the domain"
    )
    velocity: Annotated[
        tuple[float, ...] | RigidMotion | None,
        Either(
            "one number a direction or {rotation: ...}",
            {None: None, tuple: Vector, dict: RigidMotion},
        ),
    ] = Field(
        default=None,
        description="of a body that moves freely its initial velocity: a vector or a rigid motion; "
        "null: it is at rest [length/time]",
    )

    @property
    def free(self) -> Free | None:
        """Entry of a free motion; None for a prescribed motion."""
        return self.rigid if isinstance(self.rigid, Free) else None

    @property
    def moves(self) -> bool:
        """Whether the body may move."""
        return isinstance(self.rigid, Free) or self.rigid.moves
