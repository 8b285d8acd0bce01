"""The controlled loads of a case, by name."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from pydantic import BaseModel

from pgimp.case.load import load
from pgimp.case.schema import Case
from pgimp.physics.loads.controlled import Controlled, Level
from pgimp.schema.tables import Components


def _within(value: Any) -> Iterator[Controlled]:
    if isinstance(value, Components):
        value = value.components
    if isinstance(value, Controlled):
        yield value
    elif isinstance(value, BaseModel):
        for name in type(value).model_fields:
            yield from _within(getattr(value, name))
    elif isinstance(value, Mapping):
        for each in value.values():
            yield from _within(each)
    elif isinstance(value, tuple):
        for each in value:
            yield from _within(each)


def controlled(stages: Iterable[Case]) -> list[Controlled]:
    """Return the controlled loads of a case's stages."""
    parts = ("gravity", "water", "boundaries", "tractions", "constraints", "inflow", "rigid_bodies")
    return [one for stage in stages for part in parts for one in _within(getattr(stage, part))]


def own_levels(case: Case) -> Case:
    """Return a case whose controlled loads are of no other simulation."""
    return load(case, {"title": case.title}) if controlled(case.stages) else case


def levels_of(stages: Iterable[Case]) -> dict[str, Level]:
    """Return the levels of controlled loads of all stages by name, which follow them from now on.

    The first load of a name gives the value at the start.
    """
    found: dict[str, Level] = {}
    for one in controlled(stages):
        one.follow(found.setdefault(one.control, Level(float(one.start))))
    return found
