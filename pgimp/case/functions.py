"""The functions of one's own that a case names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import BaseModel

from pgimp.case.schema import Case
from pgimp.physics.functions.entry import FunctionEntry
from pgimp.physics.functions.registry import FUNCTIONS


def functions_of(case: Case) -> list[FunctionEntry]:
    """Return the entries of a case, and of its stages, that name a function of one's own."""
    if not FUNCTIONS:
        return []
    return [entry for stage in case.stages for entry in _within(stage)]


def _within(value: Any) -> Iterator[FunctionEntry]:
    if isinstance(value, FunctionEntry):
        yield value
    if isinstance(value, BaseModel):
        for name in type(value).model_fields:
            yield from _within(getattr(value, name))
        for each in getattr(value, "variations", {}).values():
            yield from _within(each)
    elif isinstance(value, Mapping):
        for each in value.values():
            yield from _within(each)
    elif isinstance(value, tuple):
        for each in value:
            yield from _within(each)
