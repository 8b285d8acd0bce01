"""Small cases similar to a case."""

from __future__ import annotations

from collections.abc import Collection
from math import prod
from typing import Any

from pgimp.case.schema import Case

#: Steps, or multiples of a case's end, that no sample reaches.
ENDLESS = 1_000_000


def resized(case: Case, factor: float, longer: float = ENDLESS) -> Case:
    """The case with cells `factor` times as long, as far as the domain has whole cells.

    Its end is `longer` times as late, with steps of about the same Courant number.

    Raises
    ------
    ValueError, CaseError
        If the result is no valid case.
    """
    grid, time = case.grid, case.time
    cells = [max(1, round(n / factor)) for n in grid.cells]
    data = case.model_dump(by_alias=True, exclude={"history", "checkpoint"})
    data["output"] = {"fields": case.output.fields}
    data["outflow"] = _open(case, case.boundaries)
    data["boundaries"] = {
        name: _standing(entry, "xyz".index(name[0])) for name, entry in data["boundaries"].items()
    }
    data["grid"]["cell"] = [size / n for size, n in zip(grid.size, cells, strict=True)]
    if isinstance(time.step, float | int):
        step = float(time.step) * min(n / m for n, m in zip(grid.cells, cells, strict=True))
        data["time"] = {"end": step * ENDLESS, "step": step}
    else:
        data["time"]["end"] = time.end * longer
    return Case.model_validate(data)


def _open(case: Case, boundaries: Collection[str]) -> dict[str, str]:
    """``outflow`` of a sample: a few particles at an open face do not end it."""
    if any(body.formulation == "total-lagrangian" for body in case.bodies.values()):
        return {}
    faces = (f"{axis}-{end}" for axis in "xyz"[: case.dimensions] for end in ("min", "max"))
    return {face: "remove" for face in faces if face not in boundaries}


def _standing(entry: Any, axis: int) -> Any:
    """A face's condition without normal velocity, which keeps the material in at equal cost."""
    if not isinstance(entry, dict) or "velocity" not in entry:
        return entry
    velocity = list(entry["velocity"])
    velocity[axis] = 0.0
    return {**entry, "velocity": velocity}


def plain(case: Case, count: int, longer: float = ENDLESS) -> Case:
    """A block of about `count` particles of the first body's material, without other features."""
    D = case.dimensions
    each = prod(case.method.particles_per_cell)
    cells = max(2, round((count / each) ** (1.0 / D)))
    h = min(case.grid.cell)
    step = case.time.step
    data: dict[str, Any] = {
        "format": 1,
        "dimensions": D,
        "grid": {"size": [h * (cells + 2)] * D, "cell": [h] * D},
        "method": case.method.model_dump(by_alias=True),
        "materials": {
            name: entry.uniform()
            for name, entry in case.materials.items()
            if name == next(iter(case.bodies.values())).material
        },
        "boundaries": {"x-min": "fixed"},
        "outflow": _open(case, {"x-min"}),
    }
    data["bodies"] = {
        "sample": {
            "material": next(iter(data["materials"])),
            "region": {"box": {"min": [h] * D, "max": [h * (cells + 1)] * D}},
            "formulation": next(iter(case.bodies.values())).formulation,
        }
    }
    if isinstance(step, float | int):
        data["time"] = {"end": step * ENDLESS, "step": step}
    else:
        data["time"] = {"end": case.time.end * longer, "step": step.model_dump()}
    return Case.model_validate(data)
