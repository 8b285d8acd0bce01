"""Loads on any part of a body's surface: their parameters for kernels."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from math import hypot
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from pgimp.physics.loads.controlled import Controlled
from pgimp.schema.base import Model, Number, Positive, Vector
from pgimp.schema.problems import Problem, raise_problems
from pgimp.schema.rows import row_problems
from pgimp.schema.sizes import Problems, length
from pgimp.schema.tables import Varying
from pgimp.schema.time_functions import TimeFunction


def surface_width(dimensions: int) -> int:
    """Numbers of a particle's part of a surface: area, area vector, and its first moments."""
    return 1 + dimensions + dimensions**2


class Profile(NamedTuple):
    """The size of a load along a line, during one step."""

    direction: tuple[float, float, float]  #: Unit vector of the line.
    #: Where the table's coordinate is zero, along the direction from the origin of coordinates.
    origin: float
    #: (n, 2) float64: Coordinates, which increase, and factors; without any the factor is one
    #: everywhere.
    rows: np.ndarray
    outside: tuple[float, float]  #: Factors before the first row and after the last one.
    #: Half-widths of the particles' boxes in the initial state; 0 in missing directions.
    half: tuple[float, float, float]

    def factors(self, x: np.ndarray) -> np.ndarray:
        """Return the factors at points, (n,), given their coordinates `x`, (n, D)."""
        if not len(self.rows):
            return np.ones(len(x))
        along = np.full(len(x), -self.origin)
        for d in range(x.shape[1]):
            along += self.direction[d] * x[:, d]
        return np.interp(along, self.rows[:, 0], self.rows[:, 1], *self.outside)


class SurfaceLoad(NamedTuple):
    """A load on a part of a surface during one step."""

    column: int  #: First of the columns of ``particles.surface`` with the particles' parts.
    #: tuple of D float: Half-widths over which a part is spread, in the initial state; zeros for
    #: points.
    half: tuple[float, ...]
    follows: bool  #: Whether areas and normals are current; else initial.
    #: Whether distances from particles follow the deformation, as the particles' size does.
    stretches: bool
    traction: tuple[float, float, float]  #: Force per area.
    pressure: float  #: Force per area against the normal, at the origin of coordinates.
    gradient: tuple[float, float, float]  #: Gradient of the pressure in space.
    #: float or (): A number where areas and normals follow the particles' positions, not their F
    #: alone; alike for all loads of a scene.
    corrected: float | tuple[()] = ()
    #: Profile or (): Factor along a line; for all loads of a scene, if one has any.
    profile: Profile | tuple[()] = ()


class Normal(Model):
    """The parts of a surface whose normal is near a direction."""

    of: Vector = Field(description="the direction, out of the body, of any length")
    within: Annotated[float, Field(gt=0.0, le=180.0)] = Field(
        default=30.0, description="greatest angle between it and the normal [degrees]"
    )

    @model_validator(mode="after")
    def _check_direction(self) -> Normal:
        if not hypot(*self.of) > 0.0:
            text = "expected a direction, not a vector of length zero"
            raise_problems("normal", [Problem(("of",), text)])
        return self

    def includes(self, area: np.ndarray) -> np.ndarray:
        """Whether elements with area vectors, (n, D), are among them, (n,) bool."""
        size, along = np.zeros(len(area)), np.zeros(len(area))
        for d, each in enumerate(self.of):
            size += area[:, d] ** 2
            along += each * area[:, d]
        least = np.cos(np.radians(self.within)) * hypot(*self.of)
        return np.asarray(along >= least * np.sqrt(size))


class Hydrostatic(Model):
    """The pressure of a liquid at rest, below its level."""

    level: Varying = Field(
        description="height of the liquid's surface, against gravity from the origin of "
        "coordinates: with gravity along -y the y of the surface [length]"
    )
    density: Positive = Field(description="density of the liquid [mass/length^3]")

    def pressure(
        self, gravity: Sequence[float], t: float
    ) -> tuple[float, tuple[float, float, float]]:
        """Return the pressure at the origin of coordinates at time `t`, and its gradient."""
        x, y, z = (*(self.density * g for g in gravity), 0.0, 0.0)[:3]
        level = self.level.value(t) if isinstance(self.level, TimeFunction) else self.level
        return hypot(x, y, z) * level, (x, y, z)


class ProfileEntry(Model):
    """The size of a load along a line, as a table in a coordinate that moves."""

    along: Vector = Field(description="direction of the line, of any length")
    origin: Vector | None = Field(
        default=None,
        alias="from",
        description="a point where the coordinate is 0 at the start; in a stage with another "
        "`from` or `along`, as the stage begins; null: the origin of coordinates [length]",
    )
    velocity: Varying = Field(
        default=0.0, description="of the coordinate's zero along the line [length/time]"
    )
    table: tuple[tuple[Number, Number], ...] = Field(
        description="rows [coordinate, factor], the coordinates increasing: what the load is "
        "multiplied by, linear in between"
    )
    beyond: Literal["zero", "hold"] = Field(
        default="zero",
        description="beyond the ends of the table: no load, or the factors of the ends",
    )

    @model_validator(mode="after")
    def _check_line(self) -> ProfileEntry:
        found = []
        if not hypot(*self.along) > 0.0:
            found.append(Problem(("along",), "expected a direction, not a vector of length zero"))
        if len(self.table) < 2:
            text = "expected two rows [coordinate, factor] or more, with the part under load in "
            found.append(Problem(("table",), f"{text}between; got {len(self.table) or 'none'}"))
        for problem in row_problems([(s, (factor,)) for s, factor in self.table]):
            text = problem.text.replace("the times", "the coordinates")
            found.append(problem._replace(text=text))
        raise_problems("profile", found)
        return self

    @cached_property
    def direction(self) -> tuple[float, float, float]:
        """Unit vector of the line."""
        size = hypot(*self.along)
        x, y, z = (*(each / size for each in self.along), 0.0, 0.0)[:3]
        return x, y, z

    @cached_property
    def rows(self) -> np.ndarray:
        """Rows of the table, (n, 2)."""
        return np.array(self.table)

    @property
    def greatest(self) -> float:
        """Greatest size of a factor."""
        return max(abs(factor) for _, factor in self.table)

    def travel(self, t: float) -> float:
        """Return the way of the coordinate's zero from time 0 to `t`: the velocity's integral."""
        v = self.velocity
        return v.integral(t) if isinstance(v, TimeFunction) else v * t

    def controlled_since(self, before: ProfileEntry | None) -> bool:
        """Whether a stage would need the way by a velocity that a program sets, see `Controlled`.

        `before` is the profile of the stage before.
        """
        velocities = [self.velocity, *((before.velocity,) if before else ())]
        if not any(isinstance(each, Controlled) for each in velocities):
            return False
        keys = [(each.direction, each.origin, each.velocity) for each in (self, before) if each]
        return len(keys) == 1 or keys[0] != keys[1]

    def offset_in_stage(self, before: ProfileEntry | None, shift: float, start: float) -> float:
        """Return the way to add in a stage that begins at time `start`.

        Parameters
        ----------
        before : ProfileEntry or None
            The profile of the stage before.
        shift : float
            The way that was to be added there.
        start : float
            When the stage begins.
        """
        if before is None or (before.direction, before.origin) != (self.direction, self.origin):
            return -self.travel(start)
        if before.velocity == self.velocity:
            return shift
        return (before.travel(start) + shift) - self.travel(start)

    def parameters(self, half: Sequence[float], t: float, shift: float) -> Profile:
        """Return the parameters of the kernels.

        Parameters
        ----------
        half : sequence of float
            See `Profile`, (D,).
        shift : float
            Way to add to that since time 0, see `offset_in_stage`.
        """
        pairs = zip(self.direction, self.origin or (), strict=False)
        origin = sum(a * x for a, x in pairs) + (self.travel(t) + shift)
        ends = self.table[0][1], self.table[-1][1]
        outside = ends if self.beyond == "hold" else (0.0, 0.0)
        x, y, z = (*half, 0.0, 0.0)[:3]
        return Profile(self.direction, float(origin), self.rows, outside, (x, y, z))


#: Stands for none, where another load of the scene has a profile.
UNIFORM = Profile((1.0, 0.0, 0.0), 0.0, np.zeros((0, 2)), (1.0, 1.0), (0.0, 0.0, 0.0))


def profile_problems(
    path: tuple[str | int, ...], dimensions: int, profile: ProfileEntry
) -> Problems:
    """Check that a profile fits the dimensions."""
    yield from length((*path, "along"), profile.along, dimensions)
    if profile.origin is not None:
        yield from length((*path, "from"), profile.origin, dimensions)
