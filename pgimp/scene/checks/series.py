"""Series from files that end before the run: their last value is held."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from pgimp.case.schema import Case
from pgimp.scene.checks.warned import Warned, warned
from pgimp.schema.messages import dotted
from pgimp.schema.tables import Components
from pgimp.schema.time_functions import Table

#: Part of the greatest value below which a last value counts as zero.
_SMALL = 1e-3


def warnings(case: Case) -> Iterator[Warned]:
    """Yield a warning for every series that ends before the last stage, at another value than 0."""
    end = max(stage.time.end for stage in case.stages)
    for path, table in _tables((), case):
        (last, value), greatest = table.rows[-1], max(abs(v) for _, v in table.rows)
        if table.source and last < end and abs(value) > _SMALL * greatest:
            yield warned(
                "series-end",
                f"{dotted(path)}: the series of {Path(table.source).name} ends at {last:.6g}, "
                f"before the run, at {end:.6g}; its last value, {value:.3g}, is held, "
                f"{abs(value) / greatest:.2g} of the greatest: end it with 0, correct it "
                "(baseline: true), or end the run",
            )


def _tables(path: tuple[str | int, ...], value: Any) -> Iterator[tuple[Any, Table]]:
    """Yield the tables within a value of a case, with their paths."""
    if isinstance(value, Components):  # a list in the case
        value = value.components
    if isinstance(value, Table):
        yield path, value
    elif isinstance(value, BaseModel):
        for name, field in type(value).model_fields.items():
            yield from _tables((*path, field.alias or name), getattr(value, name))
    elif isinstance(value, Mapping):
        for name, each in value.items():
            yield from _tables((*path, name), each)
    elif isinstance(value, tuple) and not all(isinstance(each, float) for each in value[:1]):
        for i, each in enumerate(value):
            yield from _tables((*path, i), each)
