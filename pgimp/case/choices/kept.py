"""Choices that a run began with, kept when it is resumed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pgimp.case.choices.choose import Open, Path

#: Stands for `pgimp.case.schema.Case`, whose module imports the choices.
Case = Any


def kept(case: Case, before: Case) -> Case:
    """Return the case with the choices of the one that a run began as.

    What it writes itself stays. Later rules, or another end, may choose otherwise.
    """
    open_keys = case.__dict__.get("left_out")
    if open_keys is None:
        return case
    data, old = (each.model_dump(by_alias=True) for each in (case, before))
    changed = False
    for path in paths_of(open_keys):
        there, then = _at(data, path[:-1]), _at(old, path[:-1])
        if there is None or then is None or there.get(path[-1]) == then.get(path[-1]):
            continue
        there[path[-1]] = then.get(path[-1])
        changed = True
    if not changed:
        return case
    return carried(case, type(case).model_validate(data))


def carried(case: Case, other: Case) -> Case:
    """Return another form of a case, with what is known of its choices and its file."""
    for name in ("chosen", "left_out", "written"):
        if name in case.__dict__:
            other.__dict__.setdefault(name, case.__dict__[name])
    return other


def paths_of(open_keys: Open) -> Iterator[Path]:
    """Yield the paths of all keys that were chosen, or might have been."""
    yield from (("bodies", name, "formulation") for name in open_keys.bodies)
    yield from (("bodies", name, "mass") for name in open_keys.masses)
    yield from (("bodies", name, "volumetric") for name in open_keys.volumes)
    yield from (("method", key) for key in open_keys.method)
    if open_keys.step:
        yield "time", "step"
    if open_keys.contact or open_keys.bonded:
        yield ("contact",)


def _at(data: Any, path: Path) -> dict[str, Any] | None:
    """The mapping at a path; None if there is none."""
    for key in path:
        data = data.get(key) if isinstance(data, dict) else None
    return data if isinstance(data, dict) else None
