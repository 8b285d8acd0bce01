"""A case with other cells: all that is given in cells and steps goes with them."""

from __future__ import annotations

from math import ceil
from typing import Any

from pgimp.case.load import load
from pgimp.case.schema import Case
from pgimp.errors import CaseError, UsageError
from pgimp.geometry.regions import Points

#: Lines that a companion run writes for each of the case, between which values are interpolated.
DENSER = 4
#: Relative excess over a whole number of steps that is rounding.
_ROUNDING = 1e-9


def rescaled(case: Case, factor: float) -> Case:
    """Return a case with cells `factor` times as long, as near as the domain has whole cells.

    Particles a cell stay, and so do times of output. Fixed steps and intervals in steps go with
    the cells.

    Parameters
    ----------
    factor : float
        Above 1 for larger cells, below for smaller ones.

    Raises
    ------
    UsageError
        If a body's particles come from a file, or the case is no longer valid.
    """
    return _load(_rescaled(case, factor))


def companion(case: Case, factor: float) -> Case:
    """Return the case of a companion run: as `rescaled`, with few frames and dense lines.

    Frames are at its ends, and at the times of `output.at`, which shorten steps.
    """
    data = _rescaled(case, factor)
    data["output"] |= {"every": None, "grid": (), "surface": ()}
    data["accuracy"] = None
    for part in (data, *data["time"]["stages"]):
        if part is not data:
            part["output"] = {}
        for entry in (part.get("history", {}), *part.get("probes", {}).values()):
            if (every := entry.get("every")) is not None:
                entry["every"] = (
                    {"steps": max(1, every["steps"] // DENSER)}
                    if isinstance(every, dict)
                    else every / DENSER
                )
    return _load(data)


def ratio_of(case: Case, of: Case) -> float:
    """Return the cells of a case over those of another one, as a mean over the directions."""
    found = 1.0
    for cell, other in zip(case.grid.cell, of.grid.cell, strict=True):
        found *= cell / other
    return float(found ** (1.0 / case.dimensions))


def _load(data: dict[str, Any]) -> Case:
    try:
        return load(data)
    except CaseError as error:
        wide = " x ".join(f"{cell:.4g}" for cell in data["grid"]["cell"])
        raise UsageError(f"the case is not valid on cells of {wide}:\n{error}") from None


def _rescaled(case: Case, factor: float) -> dict[str, Any]:
    for name, body in case.bodies.items():
        if any(isinstance(part, Points) for part in body.region.simple()):
            raise UsageError(
                f"bodies.{name}: its particles come from a file, and stay what they are on other "
                "cells: there are no companion runs of such a case (--error, accuracy)"
            )
    grid = case.grid
    cells = [max(1, round(n / factor)) for n in grid.cells]
    data = case.model_dump(by_alias=True)
    data["grid"]["cell"] = [size / n for size, n in zip(grid.size, cells, strict=True)]
    shortest = min(data["grid"]["cell"]) / min(grid.cell)
    before = 0.0
    for number, stage in enumerate(case.stages):
        entry = data["time"]["stages"][number - 1] if number else data["time"]
        if isinstance(step := stage.time.step, float | int):
            longer, span = step * shortest, stage.time.end - before
            if span > 0.0:  # a whole number of steps
                longer = span / max(1, ceil(span / longer * (1.0 - _ROUNDING)))
            entry["step"] = longer
        before = stage.time.end
    for part in (data, *data["time"]["stages"]):
        for entry in (
            part.get("output", {}),
            part.get("history", {}),
            *part.get("probes", {}).values(),
        ):
            if isinstance(every := entry.get("every"), dict):
                entry["every"] = {"steps": max(1, round(every["steps"] / shortest))}
    return data
