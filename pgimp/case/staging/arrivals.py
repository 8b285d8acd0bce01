"""Checks of bodies that come in stages: `add`."""

from __future__ import annotations

from typing import Any

from pgimp.schema.messages import unknown
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import Problems

#: Stands for `pgimp.case.schema.Case`, whose stages are checked here.
Case = Any


def check_added(case: Case) -> Problems:
    """Check the bodies that stages of a case add; paths start at the case."""
    came: dict[str, str] = {}
    begins = float(case.time.end)
    for i, stage in enumerate(case.time.stages):
        yield from _inflow_kept(case, i, begins)
        begins = begins if stage.end is None else float(stage.end)  # at rest time stands still
        for k, name in enumerate(stage.add):
            path = ("time", "stages", i, "add", k)
            if name not in case.every_body:
                yield Problem(path, unknown("body", name, case.every_body))
            elif name in came:
                yield Problem(path, f"'{name}' has come in the stage '{came[name]}' already")
            came[name] = stage.name
        for k, name in enumerate(stage.remove):
            if name in stage.add:
                yield Problem(
                    ("time", "stages", i, "remove", k),
                    f"'{name}' comes in this stage; a body can be removed in a later one",
                )
    if case.bodies and not set(case.bodies) - set(came):
        yield Problem(
            ("time", "stages", 0, "add"),
            "then no body is there from the start; let the case itself have a body of a material",
        )


def _inflow_kept(case: Case, i: int, begins: float) -> Problems:
    """Check that a stage leaves inflows as they are."""
    stage, path = case.time.stages[i], ("time", "stages", i)
    for k, name in enumerate(stage.remove):
        if name in case.inflow:
            until = case.inflow[name].until
            if until is None or until > begins:
                yield Problem(
                    (*path, "remove", k),
                    f"'{name}' still enters then; give its inflow an end: until: {begins:.15g}",
                )
    for name in stage.constraints:
        if name in case.inflow:
            yield Problem(
                (*path, "constraints", name),
                "is that of an inflow, which goes on as it is: let its velocity be a function of "
                "time, or give it an end (`until`)",
            )
