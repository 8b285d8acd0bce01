"""Checks of grid, method, time, output, gravity and boundaries."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from pgimp.case.body import Body
from pgimp.case.grid import Grid
from pgimp.case.output import Output
from pgimp.case.stepping.steps import CourantStep
from pgimp.case.time import Time
from pgimp.physics.boundaries.base import Boundary
from pgimp.physics.boundaries.slip import Slip
from pgimp.physics.derived import DERIVED
from pgimp.physics.fields import OPTIONAL
from pgimp.physics.loads import BODY_FORCES
from pgimp.physics.loads.bodyforce import BodyForceEntry
from pgimp.physics.materials.base import Material
from pgimp.physics.materials.parameters.vary import PREFIX, field_of
from pgimp.schema.messages import keys_of, unknown
from pgimp.schema.problems import Problem
from pgimp.schema.registries import name_of
from pgimp.schema.sizes import WHOLE, Problems, faces, nearest_whole, whole

MOST_CELLS = 10_000_000
"""Along one direction."""

MOST_STEPS = 2**53


def check_grid(grid: Grid) -> Problems:
    """Check that sizes are whole cells, which float64 coordinates can resolve."""
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


def check_time(time: Time, counted: float) -> Problems:
    """Check that the end is a whole number of fixed steps, counted from the time `counted`."""
    step = time.step
    if isinstance(step, CourantStep):
        return
    length = time.end - counted
    if length == 0.0:  # a stage that settles
        return
    count, exact = whole(length, step)
    if count > MOST_STEPS:
        yield Problem(("time", "step"), f"{length / step:.3g} steps are too many")
    elif not exact:
        after = f"{counted:.15g} and " if counted else ""
        yield Problem(
            ("time", "end"),
            f"{time.end:.15g} is not {after}a whole number of steps of {step:.15g} "
            f"({length / step:.9g} steps); the nearest is "
            f"{after}{nearest_whole(length, step)}",
        )


def check_output(time: Time, output: Output) -> Problems:
    """Check that frames lie between the start and the end."""
    for i, instant in enumerate(output.at):
        if instant > time.last:
            yield Problem(
                ("output", "at", i), f"{instant:.15g} is after the end at {time.last:.15g}"
            )


def check_fields(
    materials: Mapping[str, Material],
    declared: tuple[str, ...],
    bodies: Mapping[str, Body],
    body_names: tuple[str, ...],
    output: Output,
) -> Problems:
    """Check that material-specific fields belong to materials of bodies."""
    has = {name: _own_fields(entry) for name, entry in materials.items()}
    in_use = {body.material for body in bodies.values()}
    if len(materials) < len(declared) or len(bodies) < len(body_names) or in_use - has.keys():
        return  # the fields of the others are unknown
    known = {*OPTIONAL, *(field for name in in_use for field in has[name])}
    there = f"there are: {', '.join(sorted(known - DERIVED.keys()))}"
    for i, name in enumerate(output.fields):
        idle = [repr(material) for material, fields in has.items() if name in fields]
        if name in known:
            continue
        if idle:
            text = f"no body is of a material that has it ({', '.join(idle)}); {there}"
        elif name.startswith(PREFIX):
            text = unknown("field", name, known)
        else:
            text = f"no material of the case has it; {there}"
        yield Problem(("output", "fields", i), text)


def _own_fields(material: Material) -> set[str]:
    """Fields that not every material has: its states, and parameters that vary in space."""
    return {s.name for s in material.states} | {field_of(keys) for keys in material.variations}


def check_body_force(dimensions: int, body_force: BodyForceEntry | None) -> Problems:
    """Check that a body force exists in these dimensions and fits them."""
    if body_force is None:
        return
    name = name_of(body_force, BODY_FORCES)
    if dimensions not in body_force.DIMENSIONS:
        allowed = " and ".join(f"{d}D" for d in body_force.DIMENSIONS)
        text = f"{name} exists in {allowed} only, but the case has {dimensions}D"
        yield Problem(("body-force", name), text)
        return
    below = () if name in keys_of(type(body_force)) else (name,)
    for found in body_force.check(dimensions):
        yield found._replace(path=("body-force", *below, *found.path))


def check_boundaries(dimensions: int, boundaries: Mapping[str, Boundary]) -> Problems:
    """Check that the domain has the faces."""
    for face in boundaries:
        if face not in faces(dimensions):
            yield Problem(("boundaries", face), unknown("face", face, faces(dimensions)))


def check_planes_of_symmetry(before: Any, now: Any) -> Problems:
    """Check that the part of free rigid bodies beyond planes of symmetry is as before."""
    for face in sorted({*before.boundaries, *now.boundaries}):
        slips = [isinstance(case.boundaries.get(face), Slip) for case in (before, now)]
        axis = "xyz".index(face[0])
        for name, body in now.rigid_bodies.items() if slips[0] != slips[1] else ():
            if not (body.free and body.free.mirrored(axis, now.dimensions)):
                continue
            if not any(region.FROM_FILE for region in body.region.simple()):
                low, high = (float(end[axis]) for end in body.region.bounds())
                slack = WHOLE * now.grid.cell[axis]
                if now.grid.origin[axis] <= low + slack and high - slack <= now.grid.corner[axis]:
                    continue
            yield Problem(
                ("boundaries", face),
                f"the rigid body '{name}' reaches across this face: what of it lies beyond has no "
                "mass while the face is a plane of symmetry (slip), so that this cannot change in "
                "a stage; keep the face as it is",
            )
