"""Inflow: the constraint that belongs to it, and checks."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from pgimp.case.body import Body
from pgimp.case.grid import Grid
from pgimp.geometry.regions import Box
from pgimp.physics.boundaries.base import Boundary
from pgimp.physics.loads.constraints import ConstraintEntry
from pgimp.physics.loads.inflow import InflowEntry
from pgimp.physics.rigid import RigidBody
from pgimp.physics.shapes.base import Shape
from pgimp.schema.messages import unknown
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import Problems

Path = tuple[str | int, ...]

#: Deviation from whole particles, over their size, that is rounding.
_ROUNDING = 1e-6


def with_constraints(data: dict[str, Any]) -> dict[str, Any]:
    """Fill in the constraint of each inflow, and the velocity with which its body begins."""
    entries, bodies = data.get("inflow"), data.get("bodies")
    constraints = data.get("constraints", {})
    if not all(isinstance(part, dict) for part in (entries, bodies, constraints)):
        return data
    assert isinstance(entries, dict) and isinstance(bodies, dict)
    bodies, constraints = dict(bodies), dict(constraints)
    for name, entry in entries.items():
        body = bodies.get(name)
        if not isinstance(entry, dict) or not isinstance(body, dict) or "region" not in body:
            continue
        velocity = entry.get("velocity")
        held = {"body": name, "region": body["region"], "velocity": velocity}
        constraints.setdefault(name, held)
        if isinstance(velocity, list | tuple) and not any(isinstance(v, dict) for v in velocity):
            bodies[name] = {"velocity": velocity, **body}
    return {**data, "bodies": bodies, "constraints": constraints}


def told_once(problems: list[Problem], data: Mapping[str, Any]) -> list[Problem]:
    """Return the problems of a case with those of what `with_constraints` filled in.

    They are told of what it was made of, unless that has a problem there already.
    """
    added = {key: data.get(key) for key in ("inflow", "constraints", "bodies")}
    inflow, held, bodies = (each if isinstance(each, Mapping) else {} for each in added.values())
    moved = []
    for item in problems:
        section, name, key = (*item.path, *3 * (None,))[:3]
        made = name in inflow and (
            (section == "constraints" and name not in held)
            or (section == "bodies" and key == "velocity" and "velocity" not in bodies[name])
        )
        source = "inflow" if key == "velocity" else "bodies"
        moved.append(item._replace(path=(source, *item.path[1:])) if made else item)
    own = {item.path[:3] for item, before in zip(moved, problems, strict=True) if item is before}
    told: dict[Any, Problem] = {}
    for item, before in zip(moved, problems, strict=True):
        if item is before or item.path[:3] not in own:
            told.setdefault((item.path, item.text), item)
    return [*told.values()]


def check_inflow(
    inflow: Mapping[str, InflowEntry],
    body_names: Collection[str],
    grid: Grid,
    method: Shape,
    every_body: Mapping[str, Body | RigidBody],
    boundaries: Mapping[str, Boundary],
    constraints: Mapping[str, ConstraintEntry],
) -> Problems:
    """Check that what enters can be made of whole layers of particles."""
    for name, entry in inflow.items():
        path: Path = ("inflow", name)
        body = every_body.get(name)
        if body is None and name not in body_names:
            text = unknown("body", name, body_names)
            yield Problem(path, f"{text}; an inflow has the name of the body that enters")
        wrong = list(_misdirected(path, entry))
        yield from wrong
        if wrong or not isinstance(body, Body) or not isinstance(body.region, Box):
            continue
        yield from _uneven(name, body.region, entry, grid, method)
        yield from _blocked(path, body.region, entry, grid, boundaries)
        held = constraints.get(name)
        if held is not None and (held.body, held.region, held.velocity) != (
            name,
            body.region,
            entry.velocity,
        ):
            yield Problem(
                ("constraints", name),
                "an inflow holds its body by a constraint of this name; call this one otherwise",
            )


def _misdirected(path: Path, entry: InflowEntry) -> Problems:
    """Check the direction of an inflow."""
    path = (*path, "velocity")
    moving = [d for d in range(len(entry.velocity)) if any(entry.values(d))]
    if len(moving) != 1:
        yield Problem(
            path,
            "one component, and no more, must be other than 0: layers of particles enter along an "
            "axis of the grid",
        )
        return
    values = list(entry.values(moving[0]))
    if min(values) < 0.0 < max(values):
        yield Problem(path, "changes its sign, and nothing can leave through an inflow")


def _uneven(name: str, box: Box, entry: InflowEntry, grid: Grid, method: Shape) -> Problems:
    """Check that the region is of whole layers of particles, and at least a cell long."""
    axis = entry.axis
    size = grid.cell[axis] / method.particles_per_cell[axis]
    for end in ("min", "max"):
        at = (getattr(box, end)[axis] - grid.origin[axis]) / size
        if abs(at - round(at)) > _ROUNDING:
            nearest = grid.origin[axis] + round(at) * size
            yield Problem(
                ("bodies", name, "region", "box", end, axis),
                f"an inflow begins and ends between two layers of particles, {size:.15g} apart: "
                f"the nearest is {nearest:.15g}",
            )
    if box.max[axis] - box.min[axis] < (1.0 - _ROUNDING) * grid.cell[axis]:
        yield Problem(
            ("bodies", name, "region"),
            f"an inflow is at least a cell long, {grid.cell[axis]:.15g} along {'xyz'[axis]}, so "
            "that the grid moves with what enters",
        )


def _blocked(
    path: Path, box: Box, entry: InflowEntry, grid: Grid, boundaries: Mapping[str, Boundary]
) -> Problems:
    """Check that no wall stands where it enters."""
    axis, size = entry.axis, 2.0 * grid.cell[entry.axis]
    if entry.sign > 0.0:
        face, near = f"{'xyz'[axis]}-min", box.min[axis] < grid.origin[axis] + size
    else:
        face, near = f"{'xyz'[axis]}-max", box.max[axis] > grid.corner[axis] - size
    if near and face in boundaries:
        yield Problem(
            ("boundaries", face),
            f"'{path[1]}' enters here or within two cells, and the condition would hold it back; "
            "leave the face open, or let it enter farther inside",
        )
