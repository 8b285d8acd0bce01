"""Conditions between the parts of a case.

Each check is a generator of problems. Its parameters name the parts of the case that it needs; it
runs if these are valid, even if others are not.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from pydantic import BaseModel, TypeAdapter, ValidationError

from pgimp.case.checks.absorbing import check_absorbing
from pgimp.case.checks.bodies import (
    check_constraints,
    check_materials,
    check_tractions,
    check_turning,
    check_velocities,
)
from pgimp.case.checks.configuration import check_configuration, check_initial_output
from pgimp.case.checks.damping import check_damping, check_mass_scaling
from pgimp.case.checks.domain import (
    check_body_force,
    check_boundaries,
    check_fields,
    check_gravity,
    check_grid,
    check_method,
    check_output,
    check_time,
)
from pgimp.case.checks.escape import check_escape
from pgimp.case.checks.geometry import check_axis, check_geometry, check_plane_stress, check_rings
from pgimp.case.checks.geostatic import check_geostatic, check_water
from pgimp.case.checks.numbers import check_numbers
from pgimp.case.checks.periodic import (
    check_period,
    check_periodic_bodies,
    check_periodic_faces,
    check_unwrapped,
)
from pgimp.case.checks.places.gauges import check_gauges
from pgimp.case.checks.places.probes import check_probes
from pgimp.case.checks.regions import check_regions
from pgimp.case.checks.rigid_bodies import check_adhesion, check_contact, check_rigid_bodies
from pgimp.case.checks.settling import check_settling
from pgimp.case.checks.variations import check_variations
from pgimp.case.staging.inflow import check_inflow
from pgimp.physics.boundaries.base import Boundary
from pgimp.physics.materials.base import Material
from pgimp.physics.rigid import RigidBody
from pgimp.physics.shapes.base import Shape
from pgimp.schema.base import Model
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import Problems

_NAMED = (
    "materials", "bodies", "boundaries", "escape", "tractions", "constraints", "inflow", "probes",
    "gauges",
)  # fmt: skip
"""Parts of a case that are made of named entries."""


def check(
    parts: Mapping[str, Any], counted: float = 0.0, began: float = 0.0, gone: Sequence[str] = ()
) -> list[Problem]:
    """Return the problems between the `parts` of a case, given by their key.

    `counted` is the time from which fixed steps are counted, see `pgimp.case.stages.Staged`;
    a stage has begun at the time `began`, without the bodies that have `gone`.
    """
    parts = {**parts, "counted": counted, "began": began, "gone": gone}
    if "every_body" in parts:
        every = parts["every_body"]
        rigid_bodies = {name: body for name, body in every.items() if isinstance(body, RigidBody)}
        bodies = {name: body for name, body in every.items() if name not in rigid_bodies}
        named = (name for name in parts.get("body_names", every) if name not in rigid_bodies)
        parts = {
            **parts,
            "body_names": tuple(named),
            "bodies": bodies,
            "rigid_bodies": rigid_bodies,
        }
    if "materials" in parts:
        parts = {"declared": tuple(parts["materials"]), **parts}
    problems: list[Problem] = []
    for run in _CHECKS:
        names = inspect.signature(run).parameters
        if all(name in parts for name in names):
            problems.extend(run(**{name: parts[name] for name in names}))
    known = {item.path for item in problems}
    others = ("every_body", "rigid_bodies", "counted", "began", "gone")
    numbers = {name: part for name, part in parts.items() if name not in others}
    if "every_body" in parts:
        numbers["bodies"] = parts["every_body"]
    problems += [item for item in check_numbers(numbers) if item.path not in known]
    return problems


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
            value = {key: item for key, item in value.items() if (written, key) not in wrong}
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
    check_method,
    check_geometry,
    check_plane_stress,
    check_axis,
    check_rings,
    check_time,
    check_materials,
    check_variations,
    check_velocities,
    check_regions,
    check_rigid_bodies,
    check_gravity,
    check_body_force,
    check_boundaries,
    check_absorbing,
    check_escape,
    check_periodic_faces,
    check_period,
    check_periodic_bodies,
    check_unwrapped,
    check_fields,
    check_tractions,
    check_constraints,
    check_turning,
    check_inflow,
    check_contact,
    check_adhesion,
    check_damping,
    check_mass_scaling,
    check_settling,
    check_geostatic,
    check_water,
    check_configuration,
    check_initial_output,
    check_output,
    check_probes,
    check_gauges,
)
