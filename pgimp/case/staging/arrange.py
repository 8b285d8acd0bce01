"""Arrangement of a case's stages: a case for each, checked like any case."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import ValidationError

from pgimp.case.checks.exact_surfaces import meets
from pgimp.case.checks.stages import check_by_itself, check_changes, reselects
from pgimp.case.outflow import exits_of
from pgimp.case.stages import Stage, Staged, merged
from pgimp.case.staging.strength import strength_problems, weakened
from pgimp.physics.loads.constraints import ConstraintEntry
from pgimp.schema.messages import explain
from pgimp.schema.problems import Problem

#: Stands for `pgimp.case.schema.Case`, whose module imports this one.
Case = Any
Path = tuple[str | int, ...]


def arrange(case: Case) -> tuple[tuple[Case, ...], list[Problem]]:
    """Return the cases of the stages of a case, and their problems.

    Each is checked like any case; the stages after a wrong one are left out.
    """
    data = case.model_dump(by_alias=True)
    at, start = case.output.at, 0.0
    data["accuracy"] = None  # of the whole
    data["time"] = {key: value for key, value in data["time"].items() if key != "stages"}
    first = _of_stage(type(case), data, at, start, case.time.end, 0.0)
    awaited = {name: i for i, stage in enumerate(case.time.stages, 1) for name in stage.add}
    first.__dict__["staged_as"] = Staged(
        escapes=bool(exits_of(first.outflow)), awaited=awaited, stress=case.start.stress
    )
    found, names, strength = [first], {""}, None
    data.pop("start")  # of the first stage alone
    for number, stage in enumerate(case.time.stages):
        before, where = found[-1], ("time", "stages", number)
        problems = list(check_by_itself(stage, before, names))
        strength = stage.strength if "strength" in stage.model_fields_set else strength
        problems += strength_problems(strength, before.materials)
        names.add(stage.name)
        if problems:
            return (), [item._replace(path=(*where, *item.path)) for item in problems]
        spellings = {name: entry.SPELLINGS for name, entry in before.materials.items()}
        data = merged(data, stage, spellings)
        counted = _counted(before, stage)
        try:
            end = before.time.end if stage.end is None else stage.end
            weak = weakened(strength, data, before.materials)
            gone = (*before.staged.removed, *stage.remove)
            now = _of_stage(type(case), weak, at, before.time.end, end, counted, gone)
        except ValidationError as error:
            problems = explain(type(case), error, data)
        else:
            problems = list(check_changes(before, now, stage))
        if problems:
            return (), [_relocated(item, stage, where) for item in problems]
        end, moved = float(before.time.end), _displacements(before, now)
        gone = before.staged.removed + tuple(name for name in stage.remove if name in now.bodies)
        leaves = before.staged.escapes or bool(exits_of(now.outflow))
        rebonds = before.staged.rebonds or now.contact != before.contact
        now.__dict__["staged_as"] = Staged(
            number + 1,
            stage.name,
            end,
            counted,
            gone,
            leaves,
            moved,
            rebonds,
            before.staged.damped or before.damping is not None or before.rests,
            before.staged.settled or before.rests,
            False,
            before.staged.added + stage.add,
            {name: i for name, i in before.staged.awaited.items() if i > number + 1},
            before.staged.stress,
            _angles(before, now),
            _profile_offsets(before, now),
        )
        found.append(now)
    meeting = any(map(meets, found))
    for one in found:
        one.__dict__["staged_as"] = one.staged._replace(meets=meeting)
    return tuple(found), []


def _of_stage(
    kind: type[Case],
    data: dict[str, Any],
    at: tuple[float, ...],
    start: float,
    end: float,
    counted: float,
    gone: tuple[str, ...] = (),
) -> Case:
    """Return a typed case, with only the frame times `at` that are in the stage."""
    mine = tuple(time for time in at if start < time <= end or time == start == 0.0)
    data = {**data, "output": {**data["output"], "at": mine}}
    context = {"counted": counted, "began": start, "gone": gone}
    return kind.model_validate(data, context=context)


def _counted(before: Case, stage: Stage) -> float:
    """Time from which the fixed steps of a stage are counted; 0 if steps are not fixed."""
    step = before.time.step if stage.step is None else stage.step
    if not isinstance(step, float | int):
        return 0.0
    if stage.equilibrate:  # its steps take no time
        return float(before.time.end)
    return before.staged.counted if step == before.time.step else float(before.time.end)


def _displacements(before: Case, now: Case) -> dict[str, tuple[float, ...]]:
    """Displacements to add to the constraints of a stage, see `Staged`."""
    start, found = float(before.time.end), {}
    for name, entry in now.constraints.items():
        old: tuple[float | None, ...] = (None,) * now.dimensions
        shift = (0.0,) * now.dimensions
        if not reselects(before, now, name):
            old = _prescribed(before.constraints[name], start, now.dimensions)
            shift = before.staged.displacements.get(name, shift)
        new = _prescribed(entry, start, now.dimensions)
        found[name] = tuple(
            ((had or 0.0) + more) - (has or 0.0)
            for had, more, has in zip(old, shift, new, strict=True)
        )
    return found


def _prescribed(entry: ConstraintEntry, t: float, dimensions: int) -> tuple[float | None, ...]:
    """Displacement that a constraint prescribes until `t`; by a function it is not known."""
    return entry.displacement(t) or (None,) * dimensions


def _angles(before: Case, now: Case) -> dict[str, float]:
    """Angles to add to the rotations of a stage, see `Staged`."""
    start, found = float(before.time.end), {}
    for name, entry in now.constraints.items():
        turned = 0.0
        if not reselects(before, now, name):
            turned = before.constraints[name].angle(start) + before.staged.angles.get(name, 0.0)
        if entry.rotation or turned:
            found[name] = turned - entry.angle(start)
    return found


def _profile_offsets(before: Case, now: Case) -> dict[str, float]:
    """Ways to add to the profiles of a stage, see `Staged`."""
    start, offsets = float(before.time.end), before.staged.profile_offsets
    return {
        name: entry.profile.offset_in_stage(
            before.tractions[name].profile, offsets.get(name, 0.0), start
        )
        for name, entry in now.tractions.items()
        if entry.profile
    }


def _relocated(item: Problem, stage: Stage, where: Path) -> Problem:
    """Return a problem of a stage's case with the path of its cause in the stage."""
    section = item.path[0] if item.path else ""
    if section in ("time", "start"):
        return item._replace(path=(*where, *item.path[1:]))
    changes: object = stage.changes.get(str(section))
    if isinstance(changes, Mapping) and len(item.path) > 1 and item.path[1] not in changes:
        changes = None
    if changes is not None or section in ("materials", "tractions", "contact", "output"):
        return item._replace(path=(*where, *item.path))
    if section in ("boundaries", "outflow") and len(item.path) > 1:
        # The two conflict on a face: the stage changes the other one.
        other = "outflow" if section == "boundaries" else "boundaries"
        if item.path[1] in stage.changes.get(other, {}):
            path = (*where, other, item.path[1])
            return item._replace(path=path, text=f"{'.'.join(map(str, item.path))}: {item.text}")
    return item._replace(text=f"in the stage '{stage.name}': {item.text}")


def steps_in(case: Case) -> int | None:
    """Return the number of fixed steps of a stage; None if steps are not fixed."""
    if not isinstance(case.time.step, float | int):
        return None
    return round((case.time.end - case.staged.start) / case.time.step)


def changes_of(stage: Stage) -> Iterator[str]:
    """Yield the changes of a stage, by the shortest key paths."""
    for section, value in stage.changes.items():
        if section in ("remove", "add"):
            if value:
                yield f"{section} {', '.join(value)}"
        elif isinstance(value, Mapping) and section != "strength-reduction":
            for name, entry in value.items():
                keys = entry if section == "materials" and isinstance(entry, Mapping) else [""]
                yield from (f"{section}.{name}{'.' if key else ''}{key}" for key in keys)
        else:
            yield section
