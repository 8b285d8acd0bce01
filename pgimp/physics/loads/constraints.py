"""Grips: parts of bodies that move as prescribed, or by a given force; the entry in the case."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from pydantic import Field, model_validator

from pgimp.geometry.regions import RegionEntry
from pgimp.physics.loads.motion import zero_vector
from pgimp.physics.loads.spring import Spring
from pgimp.physics.loads.turning import NO_GRADIENT, Matrix, Triple, Turning
from pgimp.schema.base import Model, Name, NonNegative
from pgimp.schema.problems import Problem, raise_problems
from pgimp.schema.tables import Component, prescribed
from pgimp.schema.time_functions import TimeFunction


class Constraint(NamedTuple):
    """A constraint in one step: held components, velocity at its end, mean acceleration."""

    held: tuple[bool, bool, bool]
    velocity: Triple
    rate: Triple


class PlacedConstraint(NamedTuple):
    """A constraint in one step whose velocity depends on the place; so are all of such a scene.

    Attributes
    ----------
    held, velocity, rate
        See `Constraint`; the velocity, at the centre, is the mean over the step if it turns.
    centre : tuple of 3 float
        A point of the axis at the step's beginning.
    gradient, rate_gradient : tuple of 9 float
        Gradients of velocity and mean acceleration by the place then, row-major.
    moment : int
        Row of its angular impulse in the ledger; -1 without one.
    """

    held: tuple[bool, bool, bool]
    velocity: Triple
    rate: Triple
    centre: Triple = (0.0, 0.0, 0.0)
    gradient: Matrix = NO_GRADIENT
    rate_gradient: Matrix = NO_GRADIENT
    moment: int = -1


class ConstraintEntry(Model):
    """Holds the particles of a body that are in a region at the start, and moves them."""

    body: Name = Field(description="name of the body")
    region: RegionEntry = Field(
        description="its particles with their centre in here at the start are held"
    )
    velocity: tuple[Component, ...] = zero_vector(
        "velocity [length/time] along each direction: a number, a table over time, "
        "or null where the component is free, or has a force"
    )
    rotation: Turning | None = Field(
        default=None,
        description="prescribed rotation besides, about an axis that moves by `velocity`, or is at "
        "rest; all directions are then held but one along the axis whose velocity is null; null: "
        "none",
    )
    force: tuple[Component, ...] = zero_vector(
        "force [force] along each direction, in place of a velocity there: the particles move as "
        "one, with the velocity that it gives them; a number, a table over time, or null"
    )
    mass: NonNegative = Field(
        default=0.0, description="mass that moves with them where they have a force [mass]"
    )
    spring: Spring | None = Field(
        default=None, description="a spring and dashpot to ground, where they have a force"
    )

    @model_validator(mode="after")
    def _check_motion(self) -> ConstraintEntry:
        found = []
        if not (self.velocity or self.force or self.rotation):
            found.append(Problem(("velocity",), "expected a velocity, a rotation or a force"))
        if self.rotation:
            found += _unturned(self.velocity, self.force, self.rotation)
        for d, (v, f) in enumerate(zip(self.velocity, self.force, strict=False)):
            if v is not None and f is not None:
                text = "expected null here, or a velocity of null: one of the two gives the motion"
                found.append(Problem(("force", d), text))
        if not any(f is not None for f in self.force):
            for key in ("mass", "spring"):
                if getattr(self, key):
                    text = "is for directions with a force; give one, as force: [0.0, null]"
                    found.append(Problem((key,), text))
        raise_problems("constraint", found)
        return self

    @property
    def motion(self) -> tuple[Component, ...]:
        """The prescribed velocity along each direction, None where there is none.

        Of what turns it is that of the axis.
        """
        if self.rotation and not self.velocity:
            return (0.0,) * len(self.rotation.about)
        return self.velocity or (None,) * len(self.force)

    @property
    def forces(self) -> tuple[Component, ...]:
        """The given force along each direction, None where there is none."""
        return self.force or (None,) * len(self.motion)

    @property
    def rigid(self) -> tuple[bool, ...]:
        """Along which directions the particles move as one."""
        each = zip(self.motion, self.forces, strict=False)
        return tuple(v is not None or f is not None for v, f in each)

    @property
    def varies(self) -> bool:
        """Whether the parameters depend on time."""
        varying = any(isinstance(component, TimeFunction) for component in self.velocity)
        return varying or self.rotation is not None

    def parameters(self, start: float, end: float) -> Constraint:
        """Parameters of the kernels for a step from `start` to `end`, without given forces."""
        return Constraint(*prescribed(self.motion, start, end))

    def placed(
        self, start: float, end: float, before: Sequence[float], moment: int
    ) -> PlacedConstraint:
        """Parameters of the kernels in a scene where some constraint turns.

        The step's end is exact for what turns: the axis moves by the integral of its velocity, and
        the angle is the integral of the rate.

        Parameters
        ----------
        start, end : float
            Times of the step.
        before : sequence of D float
            Displacement in previous stages, to be added.
        moment : int
            Row of the angular impulse in the ledger.
        """
        own = PlacedConstraint(*self.parameters(start, end))
        if self.rotation is None:
            return own
        shifts = [[shift or 0.0 for shift in self.displacement(t)] for t in (start, end)]
        velocity = self.velocity if end > start else ()
        means = [
            (b - a) / (end - start) if isinstance(v, TimeFunction) else v or 0.0
            for a, b, v in zip(*shifts, velocity, strict=False)
        ]
        at = [sum(part) for part in zip(self.rotation.about, shifts[0], before, strict=True)]
        gradient, rate_gradient = self.rotation.gradients(start, end)
        return own._replace(
            velocity=_triple(means) if means else own.velocity,
            centre=_triple(at),
            gradient=gradient,
            rate_gradient=rate_gradient,
            moment=moment,
        )

    def displacement(self, t: float) -> tuple[float | None, ...]:
        """Return the displacement prescribed from time 0 to `t`, None for other components."""
        return tuple(
            v.integral(t) if isinstance(v, TimeFunction) else None if v is None else v * t
            for v in self.motion
        )

    def angle(self, t: float) -> float:
        """Return the angle of rotation prescribed from time 0 to `t`."""
        return self.rotation.angle(t) if self.rotation else 0.0


def _unturned(
    velocity: tuple[Component, ...], force: tuple[Component, ...], rotation: Turning
) -> list[Problem]:
    """Problems of what goes with a rotation: only the direction of the axis may be free."""
    found = []
    text = "cannot be combined with a rotation, which prescribes the motion; leave it out"
    if any(f is not None for f in force):
        found.append(Problem(("force",), text))
    for d, component in enumerate(velocity):
        if component is None and abs(rotation.direction[d]) != 1.0:
            text = "expected a velocity: what turns is free along its axis alone"
            found.append(Problem(("velocity", d), text))
    return found


def _triple(values: Sequence[float]) -> Triple:
    x, y, z = (*map(float, values), 0.0, 0.0, 0.0)[:3]
    return (x, y, z)
