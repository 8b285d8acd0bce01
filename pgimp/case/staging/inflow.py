"""Inflow: the constraint that belongs to it, and checks."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from pgimp.case.body import Body
from pgimp.case.grid import Grid
from pgimp.case.start import StartEntry
from pgimp.geometry.regions import Box
from pgimp.physics.boundaries.base import Boundary
from pgimp.physics.loads.constraints import ConstraintEntry
from pgimp.physics.loads.inflow import InflowEntry
from pgimp.physics.loads.tractions import TractionEntry
from pgimp.physics.materials.base import Material
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
    geometry: str,
    every_body: Mapping[str, Body | RigidBody],
    materials: Mapping[str, Material],
    boundaries: Mapping[str, Boundary],
    constraints: Mapping[str, ConstraintEntry],
    tractions: Mapping[str, TractionEntry],
    start: StartEntry,
    exact: object,
) -> Problems:
    """Check that what enters can be made of whole layers of particles."""
    for name, entry in inflow.items():
        path: Path = ("inflow", name)
        body = every_body.get(name)
        if body is None:
            if name not in body_names:
                text = unknown("body", name, body_names)
                yield Problem(path, f"{text}; an inflow has the name of the body that enters")
            continue
        wrong = list(_unfit(path, name, body, materials, tractions))
        if not wrong:
            wrong += _misdirected(path, entry, geometry, boundaries)
        yield from wrong
        if wrong or not isinstance(body, Body):
            continue
        yield from _uneven(name, body, entry, grid, method)
        yield from _blocked(path, body, entry, grid, boundaries)
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
    if inflow and exact is not None:
        yield Problem(("inflow",), "brings what `exact` does not know of; leave one of them out")
    if inflow and start.settle is not None:
        yield Problem(
            ("inflow",), "does not come to rest, as settle looks for; leave one of them out"
        )


def _unfit(
    path: Path,
    name: str,
    body: Body | RigidBody,
    materials: Mapping[str, Material],
    tractions: Mapping[str, TractionEntry],
) -> Problems:
    """Check that a body can enter."""
    if isinstance(body, RigidBody):
        yield Problem(path, f"'{name}' is rigid; only bodies of a material enter")
        return
    if body.configuration == "initial":
        yield Problem(
            ("bodies", name, "configuration"),
            "the grid of the initial configuration moves with the body as it was at the start, "
            "and nothing can be added to it; what enters takes configuration: current",
        )
    if not isinstance(body.region, Box):
        yield Problem(
            ("bodies", name, "region"), "that of an inflow is a box, which layers of particles fill"
        )
    law = materials.get(body.material)
    if law is not None and law.variations:
        yield Problem(
            path, f"material '{body.material}' varies in space, and what enters is all alike"
        )
    for key, traction in tractions.items():
        if traction.body == name:
            yield Problem(
                ("tractions", key, "body"), f"'{name}' enters by an inflow, and has no lasting face"
            )


def _misdirected(
    path: Path, entry: InflowEntry, geometry: str, boundaries: Mapping[str, Boundary]
) -> Problems:
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
    axis = "xyz"[moving[0]]
    if geometry == "axisymmetric" and axis == "x":
        yield Problem(
            path,
            "rings that enter along the radius have other volumes layer by layer; only "
            "along the axis y can they",
        )
    if any(
        f"{axis}-{end}" in boundaries and boundaries[f"{axis}-{end}"].joins
        for end in ("min", "max")
    ):
        yield Problem(
            path,
            f"along {axis} the domain is periodic: what enters would come back into the inflow",
        )


def _uneven(name: str, body: Body, entry: InflowEntry, grid: Grid, method: Shape) -> Problems:
    """Check that the region is of whole layers of particles, and at least a cell long."""
    axis = entry.axis
    size = grid.cell[axis] / method.particles_per_cell[axis]
    assert isinstance(body.region, Box)
    for end in ("min", "max"):
        at = (getattr(body.region, end)[axis] - grid.origin[axis]) / size
        if abs(at - round(at)) > _ROUNDING:
            nearest = grid.origin[axis] + round(at) * size
            yield Problem(
                ("bodies", name, "region", "box", end, axis),
                f"an inflow begins and ends between two layers of particles, {size:.15g} apart: "
                f"the nearest is {nearest:.15g}",
            )
    if body.region.max[axis] - body.region.min[axis] < (1.0 - _ROUNDING) * grid.cell[axis]:
        yield Problem(
            ("bodies", name, "region"),
            f"an inflow is at least a cell long, {grid.cell[axis]:.15g} along {'xyz'[axis]}, so "
            "that the grid moves with what enters",
        )


def _blocked(
    path: Path, body: Body, entry: InflowEntry, grid: Grid, boundaries: Mapping[str, Boundary]
) -> Problems:
    """Check that no wall stands where it enters."""
    axis, size = entry.axis, 2.0 * grid.cell[entry.axis]
    assert isinstance(body.region, Box)
    if entry.sign > 0.0:
        face, near = f"{'xyz'[axis]}-min", body.region.min[axis] < grid.origin[axis] + size
    else:
        face, near = f"{'xyz'[axis]}-max", body.region.max[axis] > grid.corner[axis] - size
    if near and face in boundaries:
        yield Problem(
            ("boundaries", face),
            f"'{path[1]}' enters here or within two cells, and the condition would hold it back; "
            "leave the face open, or let it enter farther inside",
        )
