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
#: Cells along a periodic direction below which it keeps what it has.
_PERIODIC = 4
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
    data = case.model_dump(by_alias=True)
    data["grid"] |= _grid(case, factor)
    shortest = min(data["grid"]["cell"]) / min(case.grid.cell)
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


def _grid(case: Case, factor: float) -> dict[str, Any]:
    """Origin, size and cells of the grid.

    Where whole cells do not fill the domain it grows beyond an open face, by less than a cell;
    without any the cells become a little longer or shorter.
    """
    grid = case.grid
    origin, sizes, cells = list(grid.origin), list(grid.size), list(grid.cell)
    for axis, (n, name) in enumerate(zip(grid.cells, "xyz", strict=False)):
        faces = [f"{name}-{side}" for side in ("min", "max")]
        low = case.boundaries.get(faces[0])
        fewest = min(n, _PERIODIC) if low is not None and low.joins else 1
        wanted = n / factor
        number = max(fewest, round(wanted))
        kept = [
            any(face in one.outflow or one.boundaries.get(face) is not None for one in case.stages)
            or (case.axisymmetric and face == "x-min")
            for face in faces
        ]
        if abs(number - wanted) > _ROUNDING * n and not all(kept):
            number = ceil(wanted)
            cells[axis] = factor * grid.cell[axis]
            sizes[axis] = number * cells[axis]
            if kept[1]:
                origin[axis] -= sizes[axis] - grid.size[axis]
        else:
            cells[axis] = grid.size[axis] / number
    return {"origin": origin, "size": sizes, "cell": cells}
