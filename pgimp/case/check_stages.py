"""The stages of a case arranged: a case for each, and what may not change from one to the next."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import ValidationError

from pgimp.case.check_domain import check_planes_of_symmetry
from pgimp.case.stages import BY_ENTRY, BY_KEY, Stage, Staged, merged
from pgimp.schema.dispatch import plain
from pgimp.schema.messages import explain, unknown
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import Problems

#: Of `pgimp.case.schema`, which arranges its stages with this file.
Case = Any
Path = tuple[str | int, ...]

_VARIES = (
    "varies in space: its parameters are the particles' own from the start, and cannot change in a "
    "stage"
)


def arrange(case: Case) -> tuple[tuple[Case, ...], list[Problem]]:
    """Return the cases of the stages of a case, and their problems.

    Each is checked as any case is; those after one that is wrong are left out.
    """
    if case.exact is not None:
        text = "is the solution of a case without stages (time.stages); leave one of them out"
        return (), [Problem(("exact",), text)]
    data = case.model_dump(by_alias=True)
    at, start = case.output.at, 0.0
    data["time"] = {key: value for key, value in data["time"].items() if key != "stages"}
    first = _of_stage(type(case), data, at, start, case.time.end, 0.0)
    first.__dict__["staged_as"] = Staged(escapes=bool(_leaving(first)))
    found, names = [first], {""}
    for number, stage in enumerate(case.time.stages):
        before, place = found[-1], ("time", "stages", number)
        problems = list(_own(stage, before, names))
        names.add(stage.name)
        if problems:
            return (), [item._replace(path=(*place, *item.path)) for item in problems]
        spellings = {name: entry.SPELLINGS for name, entry in before.materials.items()}
        data = merged(data, stage, spellings)
        counted = _counted(before, stage)
        try:
            now = _of_stage(type(case), data, at, before.time.end, stage.end, counted)
        except ValidationError as error:
            problems = explain(type(case), error, data)
        else:
            problems = list(_changed(before, now, stage))
        if problems:
            return (), [_relocated(item, stage, place) for item in problems]
        now.__dict__["staged_as"] = Staged(
            number + 1, stage.name, float(before.time.end), counted,
            (*before.staged.removed, *(name for name in stage.remove if name in now.bodies)),
            before.staged.escapes or bool(_leaving(now)), _displacements(before, now),
        )  # fmt: skip
        found.append(now)
    return tuple(found), []


def _of_stage(
    kind: type[Case],
    data: dict[str, Any],
    at: tuple[float, ...],
    start: float,
    end: float,
    counted: float,
) -> Case:
    """Return a typed case; of the times of frames `at` those that are in the stage."""
    mine = tuple(time for time in at if start < time <= end or time == start == 0.0)
    data = {**data, "output": {**data["output"], "at": mine}}
    return kind.model_validate(data, context={"counted": counted})


def _leaving(case: Case) -> list[str]:
    return [face for face, way in case.escape.items() if way == "remove"]


def _counted(before: Case, stage: Stage) -> float:
    """Time from which the fixed steps of a stage are counted; 0 for those that are not fixed."""
    step = before.time.step if stage.step is None else stage.step
    if not isinstance(step, float | int):
        return 0.0
    return before.staged.counted if step == before.time.step else float(before.time.end)


def _own(stage: Stage, before: Case, names: set[str]) -> Problems:
    """Check a stage by itself; paths start at the stage."""
    if stage.name in names:
        yield Problem(("name",), "another stage has this name already")
    if stage.end <= before.time.end:
        yield Problem(
            ("end",),
            f"{stage.end:.15g} is not after the end of the stage before, {before.time.end:.15g}",
        )
    there = [name for name in before.every_body if name not in before.staged.removed]
    for i, name in enumerate(stage.remove):
        if name not in there:
            yield Problem(("remove", i), unknown("body", name, there))
        elif name in stage.remove[:i]:
            yield Problem(("remove", i), f"{name} is in the list already")
    left = [name for name in before.bodies if name in there and name not in stage.remove]
    if not left:
        yield Problem(("remove",), "nothing is left; a case needs a body of a material")
    for key in stage.method:
        if key != "relaxation":
            yield Problem(
                ("method", key), "cannot change in a stage; of the method only relaxation can"
            )
    if "at" in stage.output:
        yield Problem(
            ("output", "at"), "is for all stages; give it in the case's own output, up to the end"
        )
    for section in (*BY_KEY, *BY_ENTRY):
        for name, entry in getattr(stage, section).items():
            if section in BY_KEY and not isinstance(entry, Mapping | None):
                yield Problem(
                    (section, name), "expected a mapping of the keys that change, or null"
                )
    for section, what in (("materials", "material"), ("tractions", "traction")):
        known = getattr(before, section)
        for name, entry in getattr(stage, section).items():
            if name not in known and entry is not None:
                advice = ""
                if what == "traction":
                    advice = (
                        "; which particles have the face is known at the start only: declare it in "
                        "the case, with the pressure 0"
                    )
                yield Problem((section, name), unknown(what, name, known) + advice)
    gone = (*before.staged.removed, *stage.remove)
    for name, entry in stage.tractions.items():
        if entry is not None and name in before.tractions:
            body = before.tractions[name].body
            if body in gone:
                yield Problem(
                    ("tractions", name), f"acts on '{body}', which has been removed: it has ended"
                )
    for name, entry in stage.materials.items():
        if entry is None and name in before.materials:
            yield Problem(
                ("materials", name), "null ends tractions, constraints and faces; not a material"
            )
        elif entry and name in before.materials and before.materials[name].variations:
            yield Problem(("materials", name), _VARIES)
        model = entry.get("model") if isinstance(entry, Mapping) else None
        if name in before.materials and model not in (None, before.materials[name].model):
            yield Problem(
                ("materials", name, "model"),
                f"particles of '{before.materials[name].model}' do not have what those of another "
                "model remember: a stage can change parameters only; take the model of the later "
                "stage from the start, with a strength that is not reached",
            )
    for section in (*BY_KEY, *BY_ENTRY):
        for name, entry in getattr(stage, section).items():
            if entry is None and name not in getattr(before, section) and section != "escape":
                yield Problem((section, name), "there is none to end: nothing has this name before")


def _changed(before: Case, now: Case, stage: Stage) -> Problems:
    """Check that particles have the columns that a stage needs; paths start at the case."""
    for name, entry in now.materials.items():
        yield from _material(("materials", name), before.materials[name], entry, now.dimensions)
    for name, entry in now.tractions.items():
        for key in ("body", "face"):
            if getattr(entry, key) != getattr(before.tractions[name], key):
                yield Problem(("tractions", name, key), "cannot change in a stage")
    for name, entry in now.constraints.items():
        if reselects(before, now, name) and any(r.FROM_FILE for r in entry.region.simple()):
            yield Problem(
                ("constraints", name, "region"),
                "a region from a file is for the case itself; declare the constraint there, free "
                "(velocity: [null, ..]), and let it hold from this stage on",
            )
        gone = (*before.staged.removed, *stage.remove)
        if entry.body in gone and reselects(before, now, name):
            yield Problem(("constraints", name, "body"), f"'{entry.body}' has been removed")
    if (now.contact or now.tools) and not (before.contact or before.tools):
        yield Problem(
            ("contact",),
            "surfaces of the bodies are known at the start only: a stage can change the laws of "
            "contact, and end it, but not begin it; give the case itself an entry, as "
            "{bodies: all, law: tied}",
        )
    yield from check_planes_of_symmetry(before, now)
    if _with_origins(now) and not _with_origins(before):
        yield Problem(
            ("output", "fields"),
            "the displacement needs the initial positions; ask for it in the case's own output, "
            "from the start",
        )


def _material(path: Path, before: Any, now: Any, dimensions: int) -> Problems:
    """Check that particles of a material can go on with another's parameters."""
    if (before.variations or now.variations) and plain(now) != plain(before):
        yield Problem(path, _VARIES)
        return
    if now.density != before.density:
        yield Problem(
            (*path, "density"), "cannot change in a stage: particles keep the mass that they have"
        )
    if now.VOLUME_ONLY != before.VOLUME_ONLY or now.states != before.states:
        had, has = ({state.name for state in each.states} for each in (before, now))
        news = ", ".join(sorted(has - had)) or "what they remember"
        yield Problem(
            path,
            f"its particles would remember other quantities ({news}) than so far; let the case "
            "itself have the part of the model that needs them, if small",
        )
        return
    given = [
        key
        for key in type(now).model_fields
        if key != "model" and plain(getattr(now, key)) != plain(getattr(before, key))
    ]
    for key in given:
        one = before.model_copy(update={key: getattr(now, key)})
        if _starts(one, dimensions) != _starts(before, dimensions):
            name = type(now).model_fields[key].alias or key
            yield Problem(
                (*path, name), "cannot change in a stage: particles have it from the start only"
            )


def _starts(entry: Any, dimensions: int) -> tuple[float, bytes]:
    """Initial state of particles of a material."""
    from pgimp.physics.materials.outside import parameters_of
    from pgimp.physics.materials.states import States

    initial = States([""], [parameters_of(entry, dimensions)], dimensions).initial
    return entry.initial_pressure, initial.tobytes()


def reselects(before: Case, now: Case, name: str) -> bool:
    """Whether a constraint chooses its particles as a stage begins."""
    old, new = before.constraints.get(name), now.constraints[name]
    return old is None or (old.body, old.region) != (new.body, new.region)


def _with_origins(case: Case) -> bool:
    """Whether particles keep their initial position; see `Scene.origins`."""
    initial = any(body.configuration == "initial" for body in case.bodies.values())
    return initial or "displacement" in case.output.fields


def _displacements(before: Case, now: Case) -> dict[str, tuple[float, ...]]:
    """Displacements to add to those of a stage's constraints, see `Staged`."""
    start, found = float(before.time.end), {}
    for name, entry in now.constraints.items():
        old: tuple[float | None, ...] = (None,) * now.dimensions
        shift = (0.0,) * now.dimensions
        if not reselects(before, now, name):
            old = before.constraints[name].displacement(start)
            shift = before.staged.displacements.get(name, shift)
        found[name] = tuple(
            ((way or 0.0) + more) - (new or 0.0)
            for way, more, new in zip(old, shift, entry.displacement(start), strict=True)
        )
    return found


def _relocated(item: Problem, stage: Stage, place: Path) -> Problem:
    """Return a problem of a stage's case with the place where the stage has caused it."""
    section = item.path[0] if item.path else ""
    if section == "time":
        return item._replace(path=(*place, *item.path[1:]))
    changes: Any = stage.changes.get(str(section))
    if isinstance(changes, Mapping) and len(item.path) > 1 and item.path[1] not in changes:
        changes = None
    if changes is not None or section in ("materials", "tractions", "contact", "output"):
        return item._replace(path=(*place, *item.path))
    return item._replace(text=f"in the stage '{stage.name}': {item.text}")


def steps_in(case: Case) -> int | None:
    """Return the number of fixed steps of a stage; None where steps are not fixed."""
    if not isinstance(case.time.step, float | int):
        return None
    return round((case.time.end - case.staged.start) / case.time.step)


def changes_of(stage: Stage) -> Iterator[str]:
    """Yield the changes of a stage, by the shortest key paths."""
    for section, value in stage.changes.items():
        if section == "remove":
            if value:
                yield f"remove {', '.join(value)}"
        elif isinstance(value, Mapping):
            for name, entry in value.items():
                keys = entry if section == "materials" and isinstance(entry, Mapping) else [""]
                yield from (f"{section}.{name}{'.' if key else ''}{key}" for key in keys)
        else:
            yield section
