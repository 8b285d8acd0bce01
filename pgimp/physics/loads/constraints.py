"""Grips: parts of bodies that move as prescribed, or by a given force; the entry in the case."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, NamedTuple

from pydantic import Field, model_validator

from pgimp.geometry.regions import RegionEntry
from pgimp.physics.loads.motion import zero_vector
from pgimp.physics.loads.prescribed_velocity import PrescribedVelocity
from pgimp.physics.loads.spring import Spring
from pgimp.physics.loads.turning import NO_GRADIENT, Matrix, Triple, Turning
from pgimp.schema.base import Model, Name, NonNegative
from pgimp.schema.dispatch import Either
from pgimp.schema.problems import Problem, raise_problems
from pgimp.schema.tables import Component, prescribed
from pgimp.schema.time_functions import TimeFunction

#: Least part of a vertex's mass from particles of a constraint where it holds the vertex, beside
#: the nearest ones, in the initial configuration. A flat edge at the part e of the way to the next
#: plane of vertices has e^2/2. So 1/8 is rounding; less, so that edges half-way are certain.
LEAST_PART = 0.1


class Constraint(NamedTuple):
    """A constraint in one step: held components, velocity at its end, mean acceleration."""

    held: tuple[bool, bool, bool]
    velocity: Triple
    rate: Triple


class VelocityFields(NamedTuple):
    """Functions of one's own that prescribe velocities of a scene's constraints in a step."""

    #: tuple of NamedTuple: See `pgimp.physics.functions.call.source_of`.
    functions: tuple[Any, ...]
    like: tuple[float, ...]  #: tuple of D float: Zeros.
    #: start, end: Times of the step.
    start: float
    end: float


class PlacedConstraint(NamedTuple):
    """A constraint in one step whose velocity depends on the place; so are all of such a scene."""

    #: held, velocity, rate: See `Constraint`; the velocity, at the centre, is the mean over the
    #: step if it turns.
    held: tuple[bool, bool, bool]
    velocity: Triple
    rate: Triple
    #: tuple of 3 float: A point of the axis at the step's beginning.
    centre: Triple = (0.0, 0.0, 0.0)
    #: gradient, rate_gradient: tuple of 9 float: Gradients of velocity and mean acceleration by the
    #: place then, row-major.
    gradient: Matrix = NO_GRADIENT
    rate_gradient: Matrix = NO_GRADIENT
    moment: int = -1  #: Row of its angular impulse in the ledger; -1 without one.
    #: VelocityFields or (): Those of all constraints, where any has one.
    fields: VelocityFields | tuple[()] = ()
    field: int = -1  #: Number of its own among them, in place of the above; -1 without one.


class ConstraintEntry(Model):
    """Holds the particles of a body that are in a region at the start, and moves them."""

    body: Name = Field(description="name of the body")
    region: RegionEntry = Field(
        description="its particles with their centre in here at the start are held"
    )
    velocity: Annotated[
        tuple[Component, ...] | PrescribedVelocity,
        Either(
            "one number, table or null a direction, or {function: ...}",
            {tuple: tuple[Component, ...], dict: PrescribedVelocity},
        ),
    ] = zero_vector(
        "velocity [length/time] along each direction: a number, a table over time, "
        "or null where the component is free, or has a force; or a function of one's own of place "
        "and time, {function: .., parameters: ..}"
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
            found += _unturned(self.along, self.force, self.rotation)
        if self.field:
            found += [
                Problem((key,), "cannot be combined with a function that gives the velocity")
                for key in ("rotation", "force")
                if getattr(self, key)
            ]
        for d, (v, f) in enumerate(zip(self.along, self.force, strict=False)):
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
    def field(self) -> PrescribedVelocity | None:
        """The function that gives the velocity; None without one."""
        return self.velocity if isinstance(self.velocity, PrescribedVelocity) else None

    @property
    def along(self) -> tuple[Component, ...]:
        """The velocity that is given along each direction, () for one by a function."""
        return self.velocity if isinstance(self.velocity, tuple) else ()

    @property
    def motion(self) -> tuple[Component, ...]:
        """The prescribed velocity along each direction, None where there is none.

        Of what turns it is that of the axis; () for one by a function.
        """
        if self.rotation and not self.along:
            return (0.0,) * len(self.rotation.about)
        return self.along or (None,) * len(self.force)

    @property
    def forces(self) -> tuple[Component, ...]:
        """The given force along each direction, None where there is none."""
        return self.force or (None,) * len(self.motion)

    @property
    def rigid(self) -> tuple[bool, ...]:
        """Along which directions the particles move as told."""
        if self.field:
            return (True, True, True)
        each = zip(self.motion, self.forces, strict=False)
        return tuple(v is not None or f is not None for v, f in each)

    @property
    def varies(self) -> bool:
        """Whether the parameters depend on time."""
        varying = any(isinstance(component, TimeFunction) for component in self.along)
        return varying or self.placed

    def parameters(self, start: float, end: float) -> Constraint:
        """Parameters of the kernels for a step from `start` to `end`, without given forces."""
        return Constraint(*prescribed(self.motion, start, end))

    @property
    def placed(self) -> bool:
        """Whether the velocity depends on the place."""
        return bool(self.rotation or self.field)

    def at_place(
        self, start: float, end: float, before: Sequence[float], moment: int
    ) -> PlacedConstraint:
        """Parameters of the kernels in a scene where some constraint turns, without functions.

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
        if self.field:
            x, y, z = (d < len(before) for d in range(3))
            return own._replace(held=(x, y, z))
        if self.rotation is None:
            return own
        shifts = [[shift or 0.0 for shift in self.displacement(t)] for t in (start, end)]
        velocity = self.motion if end > start else ()
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


def at_places(
    entries: Mapping[str, ConstraintEntry],
    step: tuple[float, float],
    before: Mapping[str, Sequence[float]],
    functions: tuple[tuple[Any, ...], tuple[float, ...]],
) -> tuple[PlacedConstraint, ...]:
    """Parameters of all constraints in a step, where the velocity of some depends on the place.

    Parameters
    ----------
    entries : dict of str to ConstraintEntry
        The constraints, by name.
    step : (float, float)
        Its beginning and end.
    before : dict of str to sequence of D float
        Displacements in previous stages, by name.
    functions : tuple
        The functions of those that have one, in their order, and D zeros.
    """
    found, row, number, like = [], len(entries), 0, functions[1]
    fields = VelocityFields(*functions, *step) if functions[0] else ()
    for name, entry in entries.items():
        one = entry.at_place(*step, before.get(name, like), row)
        found.append(one._replace(fields=fields, field=number if entry.field else -1))
        row, number = row + bool(entry.rotation), number + bool(entry.field)
    return tuple(found)


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
