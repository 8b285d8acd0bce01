"""Where particles leave: open faces of the domain, and sinks inside it; entries in the case."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Annotated, Any, Literal

from pydantic import Field

from pgimp.geometry.regions.base import RegionEntry
from pgimp.schema.base import Model
from pgimp.schema.dispatch import Either


class Sink(Model):
    """A part of space that takes out whatever comes into it."""

    region: RegionEntry = Field(
        description="what has its centre in it when a step ends is taken out"
    )


OutflowEntry = Annotated[
    Any, Either("stop, remove or {region: ..}", {str: Literal["stop", "remove"], dict: Sink})
]
"""What a case says of a face, ``remove``, or of a sink, ``{region: {box: ..}}``."""


def exits(outflow: Mapping[str, str | Sink]) -> list[str]:
    """Return the faces through which particles leave."""
    return [name for name, action in outflow.items() if action == "remove"]


def sinks(outflow: Mapping[str, str | Sink]) -> dict[str, Sink]:
    """Return the sinks by name."""
    return {name: action for name, action in outflow.items() if isinstance(action, Sink)}


def exits_of(outflow: Mapping[str, str | Sink]) -> Iterable[str]:
    """Return the names of the faces and sinks through which particles leave."""
    return [name for name, action in outflow.items() if action != "stop"]
