"""Output of a run: frames, history, checkpoints; their entries in the case."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, Field

from pgimp.physics.columns import GRID, SURFACE
from pgimp.physics.derived import COMPUTED, DERIVED, OF_STRESS
from pgimp.physics.fields import ALWAYS, OPTIONAL, PREFIX
from pgimp.schema.base import Count, Interval, Model, Name, NonNegative, Positive, Steps, Vector
from pgimp.schema.dispatch import Either
from pgimp.schema.messages import nearest, unknown
from pgimp.schema.problems import Problem, problem, raise_problems
from pgimp.schema.registries import ByWord


def _states() -> list[str]:
    """Names of the state variables of all materials registered so far."""
    from pgimp.physics.materials import MATERIALS

    MATERIALS.complete()
    return sorted({state.name for entry in MATERIALS.values() for state in entry.STATE})


def _field(value: str) -> str:
    """Accept fields of any material; `check_fields` checks them against the case."""
    if value.startswith(PREFIX):
        return value
    if value in ALWAYS:
        raise problem(f"every frame has {value}: leave it out")
    if value not in OPTIONAL and value not in (states := _states()):
        names = [*OPTIONAL, *states]
        if nearest(value, names) not in DERIVED:  # a shorter list
            names = [name for name in names if name not in DERIVED]
        raise problem(unknown("field", value, names))
    return value


def _names_fields(schema: dict[str, object]) -> None:
    schema.pop("type", None)
    names = {"enum": [*OPTIONAL, *_states()]}
    schema["anyOf"] = [names, {"type": "string", "pattern": f"^{PREFIX}[a-z0-9-]+$"}]


def _quantity(value: str) -> str:
    if value not in GRID:
        raise problem(unknown("quantity of the grid", value, GRID))
    return value


def _on_surface(value: str) -> str:
    return _known(value, SURFACE, "quantity of surfaces")


def _known(value: str, names: Mapping[str, object], what: str = "derived field") -> str:
    if value not in names:
        raise problem(unknown(what, value, names))
    return value


def _unique(values: tuple[object, ...]) -> tuple[object, ...]:
    for position, value in enumerate(values):
        if value in values[:position]:
            raise_problems("list", [Problem((position,), f"{value} is in the list already")])
    return values


FieldName = Annotated[
    str, AfterValidator(_field), Field(strict=True, json_schema_extra=_names_fields)
]
"""Name of a quantity that frames may hold."""

GridName = Annotated[
    str, AfterValidator(_quantity), Field(strict=True, json_schema_extra={"enum": [*GRID]})
]
"""Name of a quantity of the grid that frames may hold."""

SurfaceName = Annotated[
    str, AfterValidator(_on_surface), Field(strict=True, json_schema_extra={"enum": [*SURFACE]})
]
"""Name of a quantity of surfaces that frames may hold."""

DerivedName = Annotated[
    str,
    AfterValidator(lambda value: _known(value, COMPUTED)),
    Field(strict=True, json_schema_extra={"enum": [*COMPUTED]}),
]
"""Name of a field that is computed from others."""

StressFieldName = Annotated[
    str,
    AfterValidator(lambda value: _known(value, OF_STRESS)),
    Field(strict=True, json_schema_extra={"enum": [*OF_STRESS]}),
]
"""Name of a field that is computed from the stress."""


class Output(Model):
    """Frames: the particles at chosen times."""

    every: Interval | None = Field(
        default=None,
        description="a frame at the first step at or after every multiple of this; "
        "null: only the start and the end, which always have one [time]",
    )
    at: tuple[NonNegative, ...] = Field(
        default=(),
        description="further times of frames: a step under Courant control is shortened to meet "
        "them; with a fixed step, the first step at or after them [time]",
    )
    fields: Annotated[tuple[FieldName, ...], AfterValidator(_unique)] = Field(
        default=("velocity", "stress"),
        description="what frames hold besides position and size; also the state variables of the "
        "case's materials, by their names, and parameters that vary in space, as parameter-young",
    )
    grid: Annotated[tuple[GridName, ...], AfterValidator(_unique)] = Field(
        default=(),
        description="what frames of the grid hold, which come with those of the particles: its "
        "cells with particles, for grid.xdmf; none: there are no such frames",
    )
    surface: Annotated[tuple[SurfaceName, ...], AfterValidator(_unique)] = Field(
        default=(),
        description="what frames of surfaces hold, which come with those of the particles: the "
        "surfaces of bodies that meet by them, for surface.vtkhdf; none: there are no such frames",
    )
    precision: Literal["float64", "float32"] = Field(
        default="float64",
        description="of the numbers in frames: float32 makes files about half as large and keeps 7 "
        "digits: a position is known to 6e-8 of its distance from the origin, a displacement to "
        "6e-8 of itself; only what is written is rounded, and whole numbers stay as they are",
    )
    compression: Literal["none", "gzip"] = Field(
        default="none",
        description="of frames of particles, without loss: gzip makes them 1.4 to 2 times "
        "smaller, 3 to 5 times with float32, and takes a core some 15 s for each GB; HDF5 programs "
        "read them as they are",
    )


class History(Model):
    """Sums over the particles, a line of history.csv each time."""

    every: Interval = Field(
        default=Steps(steps=100),
        description="a line at the first step at or after every multiple of this; "
        "the start and the end always have one [time]",
    )


class PointProbe(Model):
    """A material point, followed wherever it goes."""

    body: Name = Field(description="name of the body, one of whose particles is followed")
    at: Vector = Field(
        description="place in the undeformed body, before it settles: followed is the particle "
        "whose centre is closest to it, of several the one with the lowest id [length]"
    )
    every: Interval | None = Field(
        default=None,
        description="a line at the first step at or after every multiple of this, at the start and "
        "at the end; null: as the history [time]",
    )
    fields: Annotated[tuple[DerivedName, ...], AfterValidator(_unique)] = Field(
        default=(),
        description="further columns: fields that are computed from others, as frames have them",
    )


class PlaceProbe(Model):
    """A place fixed in space, and the material that is there."""

    place: Vector = Field(description="where, in the domain [length]")
    every: Interval | None = Field(
        default=None,
        description="a line at the first step at or after every multiple of this, at the start and "
        "at the end; null: as the history [time]",
    )
    fields: Annotated[tuple[StressFieldName, ...], AfterValidator(_unique)] = Field(
        default=(), description="further columns: fields that follow from its mean stress"
    )


_PROBES: Mapping[str, type[BaseModel]] = {"body": PointProbe, "place": PlaceProbe}

ProbeEntry = Annotated[Any, ByWord(lambda: _PROBES, "probe")]
"""A probe as a case writes it, ``{body: .., at: [..]}`` or ``{place: [..]}``."""


class WallTime(Model):
    """An interval of wall-clock time."""

    wall: Positive = Field(alias="wall-time", description="interval in seconds of wall time")


class Checkpoint(Model):
    """Complete states of the run, from which `--resume` goes on; the end always has one."""

    every: Annotated[
        float | Steps | WallTime | None,
        Either(
            "a time above zero, {steps: 10}, {wall-time: 900} or null",
            {float: Positive, dict: ByWord(lambda: _INTERVALS, "kind of interval"), None: None},
        ),
    ] = Field(
        default=WallTime.model_validate({"wall-time": 900.0}),
        description="a checkpoint at the first step at or after every multiple of this simulated "
        "time or number of steps, or at an interval of wall time; null: only at the end, "
        "and where the run is asked to stop [time]",
    )
    keep: Count = Field(default=2, description="how many are kept; older ones are deleted")


_INTERVALS: Mapping[str, type[BaseModel]] = {"steps": Steps, "wall-time": WallTime}
