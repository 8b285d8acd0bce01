"""Conditions between the parts of a case.

Each check is a generator of problems. Its parameters name the parts of the case that it needs; it
runs if these are valid, even if others are not.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any

from pydantic import BaseModel, TypeAdapter, ValidationError

from pgimp.case.accuracy.entry import check_accuracy
from pgimp.case.checks.bodies import check_constraints, check_materials, check_tractions
from pgimp.case.checks.configuration import check_averaged, check_parted
from pgimp.case.checks.domain import (
    check_body_force,
    check_boundaries,
    check_fields,
    check_grid,
    check_output,
    check_time,
)
from pgimp.case.checks.exclusions.table import check_exclusions
from pgimp.case.checks.fit import FITS
from pgimp.case.checks.geometry import check_geometry
from pgimp.case.checks.geostatic import check_geostatic, check_water
from pgimp.case.checks.numbers import check_numbers
from pgimp.case.checks.outflow import check_outflow
from pgimp.case.checks.periodic import check_period, check_periodic_faces, check_unwrapped
from pgimp.case.checks.places.gauges import check_gauges
from pgimp.case.checks.places.probes import check_probes
from pgimp.case.checks.regions import check_regions
from pgimp.case.checks.rigid_bodies import (
    check_adhesion,
    check_contact,
    check_rigid_bodies,
    check_surface_output,
)
from pgimp.case.checks.variations import check_variations
from pgimp.case.staging.arrivals import check_added
from pgimp.case.staging.inflow import check_inflow
from pgimp.physics.boundaries.base import Boundary
from pgimp.physics.materials.base import Material
from pgimp.physics.rigid import RigidBody
from pgimp.physics.shapes.base import Shape
from pgimp.schema.base import Model
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import Problems

_NAMED = (
    "materials", "bodies", "boundaries", "outflow", "tractions", "constraints", "inflow", "probes",
    "gauges",
)  # fmt: skip
"""Parts of a case that are made of named entries."""

_WRITTEN = {"every_body": "bodies", "body_force": "body-force"}
"""Keys of parts by their names in the program, where these differ."""


def check(
    parts: Mapping[str, Any], counted: float = 0.0, began: float = 0.0, gone: Sequence[str] = ()
) -> list[Problem]:
    """Return the problems between the `parts` of a case, given by their key.

    `counted` is the time from which fixed steps are counted, see `pgimp.case.stages.Staged`;
    a stage has begun at the time `began`, without the bodies that have `gone`.
    """
    if "every_body" in parts:
        parts = {"body_names": tuple(parts["every_body"]), **parts}
    problems = _run(FITS, parts)
    wrong = {item.path[:2] for item in problems}
    given: dict[str, Any] = {"counted": counted, "began": began, "gone": gone}
    for name, part in parts.items():
        written = _WRITTEN.get(name, name)
        if written in _NAMED:
            given[name] = _sound_entries(written, part, wrong)
        elif not any(path[:1] == (written,) for path in wrong):
            given[name] = part
    if "every_body" in given:
        every = given["every_body"]
        rigid_bodies = {name: body for name, body in every.items() if isinstance(body, RigidBody)}
        given["bodies"] = {name: body for name, body in every.items() if name not in rigid_bodies}
        given["rigid_bodies"] = rigid_bodies
        named = (name for name in given["body_names"] if name not in rigid_bodies)
        given["body_names"] = tuple(named)
    if "materials" in given:
        given = {"declared": tuple(given["materials"]), **given}
    problems += _run(_CHECKS, given)
    problems += check_exclusions(given)
    known = {item.path for item in problems}
    others = ("body_names", "declared")
    numbers = {_WRITTEN.get(name, name): part for name, part in parts.items() if name not in others}
    problems += [item for item in check_numbers(numbers) if item.path not in known]
    return problems


def _run(checks: Iterable[Callable[..., Problems]], parts: Mapping[str, Any]) -> list[Problem]:
    """Return the problems that checks find whose parts are all there."""
    problems: list[Problem] = []
    for run in checks:
        names = inspect.signature(run).parameters
        if all(name in parts for name in names):
            problems.extend(run(**{name: parts[name] for name in names}))
    return problems


def _sound_entries(
    section: str, entries: Mapping[str, Any], wrong: Collection[tuple[str | int, ...]]
) -> dict[str, Any]:
    """Return the entries of a section that no `wrong` path, of two keys, leads to."""
    return {name: entry for name, entry in entries.items() if (section, name) not in wrong}


def sound_parts(
    model: type[BaseModel], data: Mapping[str, object], problems: Iterable[Problem]
) -> dict[str, Any]:
    """Return the typed parts of `data` that the `problems` do not touch.

    Parts with named entries keep the sound entries. ``declared`` and ``body_names`` have the names
    of all materials and bodies, sound or not.
    """
    wrong = {item.path[:2] for item in problems}
    parts: dict[str, Any] = {}
    for name, field in model.model_fields.items():
        written = field.alias or name
        value = data.get(written, field.get_default(call_default_factory=True))
        if written in _NAMED and isinstance(value, Mapping):
            value = _sound_entries(written, value, wrong)
        elif any(path[:1] == (written,) for path in wrong):
            continue
        try:
            parts[name] = TypeAdapter(field.rebuild_annotation()).validate_python(value)
        except ValidationError:
            continue
    for name, key in (("declared", "materials"), ("body_names", "bodies")):
        if isinstance(named := data.get(key), Mapping) and (key,) not in wrong:
            parts[name] = tuple(named)
    return parts


def _kinds(
    dimensions: int,
    method: Shape,
    materials: Mapping[str, Material],
    boundaries: Mapping[str, Boundary],
) -> Problems:
    """Check that every type exists in these dimensions."""
    entries: dict[tuple[str, ...], Model] = {("method", "shape"): method}
    entries |= {("materials", name, "model"): entry for name, entry in materials.items()}
    entries |= {("boundaries", name): entry for name, entry in boundaries.items()}
    for path, entry in entries.items():
        if dimensions not in entry.DIMENSIONS:
            allowed = " and ".join(f"{d}D" for d in entry.DIMENSIONS)
            what = getattr(entry, str(path[-1]), "this")
            yield Problem(path, f"{what} exists in {allowed} only, but the case has {dimensions}D")


_CHECKS = (
    _kinds,
    check_grid,
    check_geometry,
    check_time,
    check_materials,
    check_variations,
    check_accuracy,
    check_regions,
    check_rigid_bodies,
    check_body_force,
    check_boundaries,
    check_outflow,
    check_periodic_faces,
    check_period,
    check_unwrapped,
    check_fields,
    check_tractions,
    check_constraints,
    check_inflow,
    check_added,
    check_contact,
    check_adhesion,
    check_surface_output,
    check_geostatic,
    check_water,
    check_parted,
    check_averaged,
    check_output,
    check_probes,
    check_gauges,
)
