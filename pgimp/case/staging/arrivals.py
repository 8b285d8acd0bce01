"""Checks of bodies that come in stages: `add`."""

from __future__ import annotations

from collections.abc import Mapping

from pgimp.case.body import Body
from pgimp.case.stages import Stage
from pgimp.case.time import Time
from pgimp.physics.loads.inflow import InflowEntry
from pgimp.physics.rigid import RigidBody
from pgimp.schema.messages import unknown
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import Problems


def check_added(
    time: Time,
    every_body: Mapping[str, Body | RigidBody],
    body_names: tuple[str, ...],
    inflow: Mapping[str, InflowEntry],
) -> Problems:
    """Check the bodies that stages of a case add."""
    came: dict[str, str] = {}
    begins = float(time.end)
    for i, stage in enumerate(time.stages):
        yield from _inflow_kept(stage, i, inflow, begins)
        begins = begins if stage.end is None else float(stage.end)  # at rest time stands still
        for k, name in enumerate(stage.add):
            path = ("time", "stages", i, "add", k)
            if name not in every_body and name not in body_names:
                yield Problem(path, unknown("body", name, every_body))
            elif name in came:
                yield Problem(path, f"'{name}' has come in the stage '{came[name]}' already")
            came[name] = stage.name
        for k, name in enumerate(stage.remove):
            if name in stage.add:
                yield Problem(
                    ("time", "stages", i, "remove", k),
                    f"'{name}' comes in this stage; a body can be removed in a later one",
                )
    if body_names and not set(body_names) - set(came):
        yield Problem(
            ("time", "stages", 0, "add"),
            "then no body is there from the start; let the case itself have a body of a material",
        )


def _inflow_kept(
    stage: Stage, i: int, inflow: Mapping[str, InflowEntry], begins: float
) -> Problems:
    """Check that a stage leaves inflows as they are."""
    path = ("time", "stages", i)
    for k, name in enumerate(stage.remove):
        if name in inflow:
            until = inflow[name].until
            if until is None or until > begins:
                yield Problem(
                    (*path, "remove", k),
                    f"'{name}' still enters then; give its inflow an end: until: {begins:.15g}",
                )
    for name in stage.constraints:
        if name in inflow:
            yield Problem(
                (*path, "constraints", name),
                "is that of an inflow, which goes on as it is: let its velocity be a function of "
                "time, or give it an end (`until`)",
            )
