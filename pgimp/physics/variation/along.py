"""A parameter over a coordinate: a table, or layers."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, model_validator

from pgimp.physics.variation.base import NoValueError, Path, Places, Reals, Variation
from pgimp.schema.base import Number
from pgimp.schema.dispatch import Either
from pgimp.schema.paths import FileName
from pgimp.schema.problems import Problem, raise_problems
from pgimp.schema.profile import read_profile
from pgimp.schema.sizes import AXES

#: Tolerance for rounding beyond the ends of a table, over the table's length.
_SLACK = 1e-9


class _Along(Variation):
    """Base of variations along one coordinate."""

    over: Literal["x", "y", "z", "depth"] = Field(
        description="the coordinate: x, y or z; or depth, by which a place lies below `surface`, "
        "along the last direction of the case"
    )
    surface: Number | None = Field(
        default=None, description="with depth: the coordinate at which it is 0 [length]"
    )

    @model_validator(mode="after")
    def _check_surface(self) -> _Along:
        if (self.over == "depth") != (self.surface is not None):
            text = "missing (the coordinate at which the depth is 0)"
            if self.over != "depth":
                text = f"belongs to over: depth, not to {self.over}"
            raise_problems("over", [Problem(("surface",), text, self.over == "depth")])
        return self

    def coordinate(self, x: Reals) -> Reals:
        """Return the coordinate that the values depend on, (n,)."""
        if self.surface is not None:
            return self.surface - x[:, -1]
        return x[:, AXES.index(self.over)]

    def _own_problems(self, dimensions: int) -> Iterator[Problem]:
        if self.over not in ("depth", *AXES[:dimensions]):
            yield Problem(("over",), f"the case, {dimensions}D, has no {self.over}")


Rows = tuple[tuple[Number, Number], ...]


def _ascending(key: str, rows: Any) -> None:
    """Refuse rows whose coordinates do not increase."""
    for i in range(1, len(rows)):
        before, after = rows[i - 1][0], rows[i][0]
        if not after > before:
            text = f"the coordinates must increase, but {after!r} follows {before!r}"
            raise_problems(key, [Problem((key, i, 0), text)])


class TableVariation(_Along):
    """Linear between the rows of a table over a coordinate."""

    table: Annotated[
        Any,
        Either(
            "rows [[coordinate, value], ...] or the name of a file", {tuple: Rows, str: FileName}
        ),
    ] = Field(
        description="rows [coordinate, value], the coordinates increasing; or a .csv file, from "
        "the folder of the case, with a line of names: a column named as `over`, one as `column`"
    )
    column: str | None = Field(
        default=None, description="column of the file; null: the one named as the parameter"
    )
    beyond: Literal["refuse", "hold"] = Field(
        default="refuse",
        description="for places beyond the ends of the table: refuse the case, or hold the values "
        "of the ends",
    )

    @model_validator(mode="after")
    def _check_rows(self) -> TableVariation:
        if isinstance(self.table, str):
            return self
        if not self.table:
            raise_problems("table", [Problem(("table",), "expected at least one row, got none")])
        if self.column is not None:
            text = "belongs to the name of a file, not to rows"
            raise_problems("table", [Problem(("column",), text)])
        _ascending("table", self.table)
        return self

    def called(self, name: str) -> None:
        """Set the parameter's name, the default for the name of the file's column."""
        self.__dict__["parameter"] = name

    def read(self) -> Rows:
        """Read the rows of the file.

        Raises
        ------
        CaseError
            With the file, the line and the problem.
        """
        return read_profile(self.table, self.over, self.column or self.__dict__["parameter"])

    @cached_property
    def rows(self) -> Rows:
        """Rows from the case or from the file."""
        return self.read() if isinstance(self.table, str) else self.table

    def release(self) -> None:
        """See `Variation`."""
        if self.from_file:
            self.__dict__.pop("rows", None)

    @property
    def from_file(self) -> bool:
        """Whether the rows are in a file."""
        return isinstance(self.table, str)

    def _known(self) -> list[tuple[Path, float]]:
        if self.from_file and "rows" not in self.__dict__:
            return []
        path: tuple[Any, ...] = ("table",)
        return [
            (path if self.from_file else (*path, i, 1), value)
            for i, (_, value) in enumerate(self.rows)
        ]

    def own_values(self, places: Places) -> Reals:
        """See `Variation`."""
        t, (at, value) = self.coordinate(places.x), np.array(self.rows, float).T
        slack = _SLACK * (at[-1] - at[0])
        outside = (t < at[0] - slack) | (t > at[-1] + slack)
        if self.beyond == "refuse" and outside.any():
            row = int(np.argmax(outside))
            raise NoValueError(
                row,
                f"lies at {self.over} {t[row]:.6g}, where the table, from {at[0]:g} to {at[-1]:g}, "
                "has no value; give it more rows, or beyond: hold",
            )
        if len(at) == 1:
            return np.full(len(t), value[0])
        t = np.minimum(np.maximum(t, at[0]), at[-1])
        after = np.clip(np.searchsorted(at, t, "right"), 1, len(at) - 1)
        t0, t1, v0, v1 = at[after - 1], at[after], value[after - 1], value[after]
        # Exact values at the rows.
        return np.where(t == t1, v1, v0 + (v1 - v0) / (t1 - t0) * (t - t0))


class LayersVariation(_Along):
    """Constant in layers along a coordinate."""

    layers: Rows = Field(
        min_length=1,
        description="rows [coordinate, value]: where a layer begins and its value, up to where the "
        "next begins; the last has no end",
    )

    @model_validator(mode="after")
    def _check_rows(self) -> LayersVariation:
        _ascending("layers", self.layers)
        return self

    def _known(self) -> list[tuple[Path, float]]:
        return [(("layers", i, 1), value) for i, (_, value) in enumerate(self.layers)]

    def own_values(self, places: Places) -> Reals:
        """See `Variation`."""
        t, (begin, value) = self.coordinate(places.x), np.array(self.layers, float).T
        slack = _SLACK * max(abs(begin[0]), begin[-1] - begin[0])
        if (before := t < begin[0] - slack).any():
            row = int(np.argmax(before))
            raise NoValueError(
                row,
                f"lies at {self.over} {t[row]:.6g}, before the first layer, which begins at "
                f"{begin[0]:g}; let it begin earlier",
            )
        return value[np.maximum(np.searchsorted(begin, t, "right") - 1, 0)]
