"""What must hold between the parts of a case.

Each check is a generator of problems whose parameters name the parts of the case that it needs;
it runs when these are sound, whatever is wrong with the others.
"""

from __future__ import annotations

import inspect
import math
import sys
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from pydantic import BaseModel, RootModel, TypeAdapter, ValidationError

from pgimp.case.dispatch import name_of
from pgimp.case.messages import describe, unknown
from pgimp.case.problems import Problem
from pgimp.scene.regions import REGIONS

Problems = Iterator[Problem]

AXES = "xyz"

WHOLE = 1e-9
"""Relative tolerance of sizes in cells and of times in steps."""

MOST_CELLS = 10_000_000
"""Along one direction."""

MOST_STEPS = 2**53


_NAMED = ("materials", "bodies", "boundaries", "tractions", "constraints")
"""Parts of a case that are made of named entries."""


def whole(total: float, part: float) -> tuple[int, bool]:
    """Return how many times `part` fits into `total`, rounded, at least 1; and whether exactly."""
    ratio = total / part
    if math.isinf(ratio):
        return sys.maxsize, False
    count = max(1, round(ratio))
    return count, abs(count * part - total) <= WHOLE * total


def nearest_whole(total: float, part: float) -> str:
    """Return the nearest multiple of `part`, at least one, in the fewest digits that say it."""
    value = whole(total, part)[0] * part
    texts = (f"{value:.{digits}g}" for digits in (6, 9, 12, 15))
    return next((text for text in texts if whole(float(text), part)[1]), repr(value))


def faces(dimensions: int) -> list[str]:
    """Return the names of the domain's faces."""
    return [f"{axis}-{side}" for axis in AXES[:dimensions] for side in ("min", "max")]


def check(parts: Mapping[str, Any]) -> list[Problem]:
    """Return what is wrong between the `parts` of a case, given by their key."""
    for name, key in (("declared", "materials"), ("body_names", "bodies")):
        if key in parts:
            parts = {name: tuple(parts[key]), **parts}
    problems: list[Problem] = []
    for run in _CHECKS:
        names = inspect.signature(run).parameters
        if all(name in parts for name in names):
            problems.extend(run(**{name: parts[name] for name in names}))
    return problems


def sound_parts(
    model: type[BaseModel], data: Mapping[str, Any], problems: Iterable[Problem]
) -> dict[str, Any]:
    """Return the typed parts of `data` that the `problems` do not touch.

    Of materials, bodies, boundaries, tractions and constraints the sound entries are kept.
    ``declared`` and ``body_names`` hold the names of all materials and bodies, also of those that
    are not sound.
    """
    wrong = {item.path[:2] for item in problems}
    parts: dict[str, Any] = {}
    for name, field in model.model_fields.items():
        value = data.get(name, field.get_default(call_default_factory=True))
        if name in _NAMED and isinstance(value, Mapping):
            value = {key: item for key, item in value.items() if (name, key) not in wrong}
        elif any(path[:1] == (name,) for path in wrong):
            continue
        try:
            parts[name] = TypeAdapter(field.rebuild_annotation()).validate_python(value)
        except ValidationError:
            continue
    for name, key in (("declared", "materials"), ("body_names", "bodies")):
        if isinstance(data.get(key), Mapping) and (key,) not in wrong:
            parts[name] = tuple(data[key])
    return parts


def _length(path: tuple[str | int, ...], value: Any, dimensions: int) -> Problems:
    """Check that a vector has one entry a direction."""
    if isinstance(value, tuple) and len(value) != dimensions:
        entries = "entry" if dimensions == 1 else "entries"
        yield Problem(
            path, f"expected {dimensions} {entries}, one a direction, got {describe(value)}"
        )


def _kinds(
    dimensions: int, method: Any, materials: Mapping[str, Any], boundaries: Mapping[str, Any]
) -> Problems:
    """Check that every type exists in these dimensions."""
    entries: dict[tuple[str, ...], Any] = {("method", "shape"): method}
    entries |= {("materials", name, "model"): entry for name, entry in materials.items()}
    entries |= {("boundaries", name): entry for name, entry in boundaries.items()}
    for path, entry in entries.items():
        if dimensions not in entry.DIMENSIONS:
            allowed = " and ".join(f"{d}D" for d in entry.DIMENSIONS)
            what = getattr(entry, str(path[-1]), "this")
            yield Problem(path, f"{what} exists in {allowed} only, but the case has {dimensions}D")


def _grid(dimensions: int, grid: Any) -> Problems:
    """Check that sizes are whole cells, which float64 coordinates can tell apart."""
    wrong = [
        item
        for name in ("origin", "size", "cell")
        for item in _length(("grid", name), getattr(grid, name), dimensions)
    ]
    if wrong:
        yield from wrong
        return
    for i, (low, size, cell) in enumerate(zip(grid.origin, grid.size, grid.cell, strict=True)):
        count, exact = whole(size, cell)
        if count > MOST_CELLS:
            yield Problem(
                ("grid", "cell", i),
                f"{size / cell:.3g} cells are too many (at most 10 million along a direction)",
            )
        elif not exact:
            yield Problem(
                ("grid", "size", i),
                f"{size:.15g} is not a whole number of cells of {cell:.15g} "
                f"({size / cell:.9g} cells); the nearest is {nearest_whole(size, cell)}",
            )
        elif math.ulp(max(abs(low), abs(low + size))) > 1e-6 * cell:
            yield Problem(
                ("grid", "origin", i),
                f"near {low:.15g} a float64 cannot resolve cells of {cell:.15g}; "
                "move the origin closer to 0",
            )


def _method(dimensions: int, method: Any) -> Problems:
    """Check that there is one number of particles a direction."""
    counts = method.particles_per_cell
    yield from _length(("method", "particles_per_cell"), counts, dimensions)


def _time(time: Any) -> Problems:
    """Check that the end is a whole number of fixed steps."""
    if time.steps is None:
        return
    count, exact = whole(time.end, time.step)
    if count > MOST_STEPS:
        yield Problem(("time", "step"), f"{time.end / time.step:.3g} steps are too many")
    elif not exact:
        yield Problem(
            ("time", "end"),
            f"{time.end:.15g} is not a whole number of steps of {time.step:.15g} "
            f"({time.end / time.step:.9g} steps); the nearest is "
            f"{nearest_whole(time.end, time.step)}",
        )


def _output(time: Any, output: Any) -> Problems:
    """Check that frames lie between the start and the end."""
    for i, instant in enumerate(output.at):
        if instant > time.end:
            yield Problem(
                ("output", "at", i), f"{instant:.15g} is after the end at {time.end:.15g}"
            )


def _materials(bodies: Mapping[str, Any], declared: Iterable[str]) -> Problems:
    """Check that the bodies' materials are known."""
    for name, body in bodies.items():
        if body.material not in declared:
            text = unknown("material", body.material, declared)
            yield Problem(("bodies", name, "material"), text)


def _velocities(dimensions: int, bodies: Mapping[str, Any]) -> Problems:
    """Check that initial velocities fit the dimensions."""
    for name, body in bodies.items():
        path = ("bodies", name, "velocity")
        if isinstance(body.velocity, tuple):
            yield from _length(path, body.velocity, dimensions)
            continue
        rotation = body.velocity.rotation
        yield from _length((*path, "translation"), body.velocity.translation, dimensions)
        yield from _length((*path, "rotation", "about"), rotation.about, dimensions)
        if dimensions == 1:
            yield Problem((*path, "rotation"), "there is no rotation in one dimension")
        elif dimensions == 2 and isinstance(rotation.rate, tuple):
            text = f"expected a number in 2D, got a list of {len(rotation.rate)}"
            yield Problem((*path, "rotation", "rate"), text)
        elif dimensions == 3 and not isinstance(rotation.rate, tuple):
            text = f"expected a vector along the axis in 3D, got {rotation.rate:.15g}"
            yield Problem((*path, "rotation", "rate"), text)
        elif dimensions == 3:
            yield from _length((*path, "rotation", "rate"), rotation.rate, dimensions)


def _region(path: tuple[str | int, ...], region: Any, dimensions: int) -> Problems:
    """Check one region and those that it is made of."""
    name = name_of(region, REGIONS)
    path = (*path, name)
    if isinstance(region, RootModel):
        for i, part in enumerate(region.root):
            yield from _region((*path, i), part, dimensions)
        return
    if dimensions not in region.DIMENSIONS:
        allowed = " and ".join(f"{d}D" for d in region.DIMENSIONS)
        hint = "; in 2D a disk is a ball" if dimensions == 2 else ""
        yield Problem(path, f"a {name} exists in {allowed} only{hint}")
        return
    for field, info in type(region).model_fields.items():
        yield from _length((*path, info.alias or field), getattr(region, field), dimensions)


def _regions(dimensions: int, grid: Any, bodies: Mapping[str, Any]) -> Problems:
    """Check that regions fit the dimensions and lie in the domain."""
    sound = not list(_grid(dimensions, grid))
    for name, body in bodies.items():
        path = ("bodies", name, "region")
        wrong = list(_region(path, body.region, dimensions))
        yield from wrong
        if wrong or not sound:
            continue
        low, high = body.region.bounds()
        for i in range(dimensions):
            least, most = grid.origin[i], grid.corner[i]
            slack = WHOLE * grid.cell[i]
            if low[i] < least - slack:
                yield _beyond(path, f"{AXES[i]}-min", low[i], least)
            if high[i] > most + slack:
                yield _beyond(path, f"{AXES[i]}-max", high[i], most)


def _beyond(path: tuple[str | int, ...], face: str, reach: float, wall: float) -> Problem:
    return Problem(
        path,
        f"reaches {abs(reach - wall):.6g} beyond the domain at {face}: to {reach:.15g}, "
        f"where the domain ends at {wall:.15g}",
    )


def _gravity(dimensions: int, gravity: Any) -> Problems:
    """Check that gravity fits the dimensions."""
    yield from _length(("gravity",), gravity, dimensions)
    for i, (_, value) in enumerate(getattr(gravity, "table", ())):
        yield from _length(("gravity", "table", i, 1), value, dimensions)


def _boundaries(dimensions: int, boundaries: Mapping[str, Any]) -> Problems:
    """Check that the domain has the faces, and that vectors fit the dimensions."""
    for face, entry in boundaries.items():
        if face not in faces(dimensions):
            yield Problem(("boundaries", face), unknown("face", face, faces(dimensions)))
        for field in type(entry).model_fields:
            path = ("boundaries", face, field)
            yield from _length(path, getattr(entry, field), dimensions)


def _body_of(
    path: tuple[str | int, ...], entry: Any, bodies: Mapping[str, Any], named: Iterable[str]
) -> Problems:
    """Check that an entry's body is known."""
    if entry.body not in bodies and entry.body not in named:
        yield Problem((*path, "body"), unknown("body", entry.body, named))


def _tractions(
    dimensions: int,
    bodies: Mapping[str, Any],
    body_names: Iterable[str],
    tractions: Mapping[str, Any],
) -> Problems:
    """Check that tractions act on faces of boxes."""
    for name, entry in tractions.items():
        path: tuple[str | int, ...] = ("tractions", name)
        yield from _body_of(path, entry, bodies, body_names)
        if entry.face not in faces(dimensions):
            yield Problem((*path, "face"), unknown("face", entry.face, faces(dimensions)))
        if entry.body in bodies and name_of(bodies[entry.body].region, REGIONS) != "box":
            kind = name_of(bodies[entry.body].region, REGIONS)
            yield Problem(
                (*path, "body"),
                f"the region of '{entry.body}' is a {kind}; tractions act on faces of a box",
            )
        yield from _length((*path, "traction"), entry.traction, dimensions)
        for i, (_, value) in enumerate(getattr(entry.traction, "table", ())):
            yield from _length((*path, "traction", "table", i, 1), value, dimensions)


def _constraints(
    dimensions: int,
    bodies: Mapping[str, Any],
    body_names: Iterable[str],
    constraints: Mapping[str, Any],
) -> Problems:
    """Check that constraints hold parts of bodies."""
    for name, entry in constraints.items():
        path: tuple[str | int, ...] = ("constraints", name)
        yield from _body_of(path, entry, bodies, body_names)
        yield from _region((*path, "region"), entry.region, dimensions)
        yield from _length((*path, "velocity"), entry.velocity, dimensions)


_CHECKS = (
    _kinds,
    _grid,
    _method,
    _time,
    _materials,
    _velocities,
    _regions,
    _gravity,
    _boundaries,
    _tractions,
    _constraints,
    _output,
)
