"""Checks of `start.settle`, and of stages that settle: nothing may move then."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from pgimp.case.body import Body
from pgimp.case.start import StartEntry
from pgimp.physics.boundaries.base import Boundary
from pgimp.physics.loads.constraints import ConstraintEntry
from pgimp.physics.rigid import Motion, RigidBody
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import Problems
from pgimp.schema.tables import prescribed

Path = tuple[str, ...]


def check_settling(
    start: StartEntry,
    bodies: Mapping[str, Body],
    rigid_bodies: Mapping[str, RigidBody],
    boundaries: Mapping[str, Boundary],
    constraints: Mapping[str, ConstraintEntry],
    inflow: Mapping[str, object],
    began: float,
    gone: Sequence[str],
) -> Problems:
    """Check that all bodies can come to rest before time 0, or in a stage that has `began`.

    What holds bodies that have `gone` may move.
    """
    if start.settle is None:
        return
    constraints = {name: entry for name, entry in constraints.items() if entry.body not in gone}
    when, key = ("time 0", "start.settle") if not began else (f"t = {began:.15g}", "settle")
    held = {name: entry for name, entry in constraints.items() if name not in inflow}
    for path in _moving({} if began else bodies, rigid_bodies, boundaries, held, began):
        instead = f"begin with 0, as a table over time, or leave {key} out"
        if began:
            instead = "let it be 0 then, by a table over time or by this stage, or leave settle out"
        yield Problem(
            path, f"moves at {when}, and {key} looks for rest under what acts then: {instead}"
        )


def _moving(
    bodies: Mapping[str, Body],
    rigid_bodies: Mapping[str, RigidBody],
    boundaries: Mapping[str, Boundary],
    constraints: Mapping[str, ConstraintEntry],
    time: float,
) -> Iterator[Path]:
    """Yield the paths of what moves at a time."""
    for name, body in bodies.items():
        if not isinstance(body.velocity, tuple) or any(body.velocity):
            yield "bodies", name, "velocity"
    for name, rigid in rigid_bodies.items():
        if isinstance(rigid.rigid, Motion) and any(
            any(part) for part in rigid.rigid.velocities(time)
        ):
            yield "bodies", name, "rigid"
    for face, entry in boundaries.items():
        if any(entry.motion(time) or ()) or any(
            prescribed(getattr(entry, "velocity", ()), time, time)[1]
        ):
            yield "boundaries", face
    for name, constraint in constraints.items():
        if constraint.field or any(prescribed(constraint.along, time, time)[1]):
            yield "constraints", name, "velocity"
        if constraint.rotation and constraint.rotation.speed(time):
            yield "constraints", name, "rotation"
