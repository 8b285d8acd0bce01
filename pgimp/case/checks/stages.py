"""Checks of a stage: by itself, and of the columns of particles that it needs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pgimp.case.checks.domain import check_planes_of_symmetry
from pgimp.case.stages import BY_ENTRY, BY_KEY, Stage
from pgimp.physics.loads.water import vertical_of
from pgimp.physics.materials.base import Material
from pgimp.schema.dispatch import plain
from pgimp.schema.messages import unknown
from pgimp.schema.problems import Problem
from pgimp.schema.sizes import Problems, faces

#: Stands for `pgimp.case.schema.Case`, whose stages are checked here.
Case = Any
Path = tuple[str | int, ...]

_VARIES = (
    "varies in space: its parameters are the particles' own from the start, and cannot change in a "
    "stage"
)


def check_by_itself(stage: Stage, before: Case, names: set[str]) -> Problems:
    """Check a stage by itself; paths start at the stage."""
    if stage.name in names:
        yield Problem(("name",), "another stage has this name already")
    if stage.equilibrate is not None:
        if stage.end is not None:
            yield Problem(
                ("end",),
                "a stage with `equilibrate` is done when it is at rest, at the time at which it "
                "began: leave out the end, and let a stage of its own go on from there",
            )
    elif stage.end is None:
        yield Problem(
            ("end",), "missing (or {equilibrate: {}}, where the stage comes to rest)", True
        )
    elif stage.end <= before.time.end:
        yield Problem(
            ("end",),
            f"{stage.end:.15g} is not after the end of the stage before, {before.time.end:.15g}",
        )
    absent = {*before.staged.removed, *before.staged.awaited}
    there = [name for name in before.every_body if name not in absent]
    for i, name in enumerate(stage.remove):
        if name not in there:
            yield Problem(("remove", i), unknown("body", name, there))
        elif name in stage.remove[:i]:
            yield Problem(("remove", i), f"{name} is in the list already")
    left = [name for name in before.bodies if name in there and name not in stage.remove]
    if not left and not stage.add:
        yield Problem(("remove",), "nothing is left; a case needs a body of a material")
    for key in stage.method:
        if key != "pic-damping":
            yield Problem(
                ("method", key), "cannot change in a stage; of the method only pic-damping can"
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
    for section in ("tractions", "constraints"):
        for name, entry in getattr(stage, section).items():
            known = getattr(before, section).get(name)
            if known is None or entry is None:
                continue
            body = entry.get("body", known.body) if isinstance(entry, Mapping) else known.body
            if body in gone:
                yield Problem(
                    (section, name), f"acts on '{body}', which has been removed: it has ended"
                )
    for i, entry in enumerate(stage.contact):
        named = entry.get("bodies") if isinstance(entry, Mapping) else None
        for k, name in enumerate(named if isinstance(named, list | tuple) else ()):
            if name in gone:
                yield Problem(("contact", i, "bodies", k), f"'{name}' has been removed")
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
            known = {*getattr(before, section)}
            if section == "outflow":  # faces, where nothing escapes anyway
                known.update(faces(before.dimensions))
            if entry is None and name not in known:
                text = unknown("name", name, getattr(before, section), "there are")
                yield Problem((section, name), f"there is none to end: {text}")


def check_changes(before: Case, now: Case, stage: Stage) -> Problems:
    """Check that particles have the columns that a stage needs; paths start at the case."""
    if now.water is not None and "water" not in stage.model_fields_set:
        then, up = vertical_of(before.gravity), vertical_of(now.gravity)
        if None not in (then, up) and then != up:
            yield Problem(
                ("gravity",),
                "turns the vertical, along which the water's level is a height: give `water` in "
                "this stage as well, or `water: null`",
            )
    for name, entry in now.materials.items():
        yield from _material(("materials", name), before.materials[name], entry, now.dimensions)
    for name, entry in now.tractions.items():
        for key in ("body", "face", "region", "follower"):
            if getattr(entry, key) != getattr(before.tractions[name], key):
                yield Problem(("tractions", name, key), "cannot change in a stage")
        was = before.tractions[name].profile
        if entry.profile not in (None, was) and entry.profile.controlled_since(was):
            yield Problem(
                ("tractions", name, "profile", "velocity"),
                "is set by a program, or was: where the profile is then is not known before the "
                "run; keep velocity, along and from as they are",
            )
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
    if (now.contact or now.rigid_bodies) and not (before.contact or before.rigid_bodies):
        yield Problem(
            ("contact",),
            "surfaces of the bodies are known at the start only: a stage can change the laws of "
            "contact, and end it, but not begin it; give the case itself an entry, as "
            "{bodies: all, law: tie}",
        )
    yield from check_planes_of_symmetry(before, now)
    for face in sorted({*before.boundaries, *now.boundaries}):
        joined = [face in case.boundaries and case.boundaries[face].joins for case in (before, now)]
        if joined[0] != joined[1]:
            yield Problem(
                ("boundaries", face),
                "a domain is periodic from the start, or not at all: this cannot change in a "
                "stage; keep the face as it is",
            )
    if _with_origins(now) and not _with_origins(before):
        yield Problem(
            ("output", "fields"),
            "the displacement needs the initial positions; ask for it in the case's own output, "
            "from the start",
        )


def _material(path: Path, before: Material, now: Material, dimensions: int) -> Problems:
    """Check that particles of a material can continue with another's parameters."""
    if (before.variations or now.variations) and plain(now) != plain(before):
        yield Problem(path, _VARIES)
        return
    if now.density != before.density:
        yield Problem(
            (*path, "density"), "cannot change in a stage: particles keep the mass that they have"
        )
    if now.VOLUME_ONLY != before.VOLUME_ONLY or now.states != before.states:
        had, has = ({state.name for state in each.states} for each in (before, now))
        if news := ", ".join(sorted(has - had)):
            text = (
                f"its particles would remember other quantities ({news}) than so far; let the case "
                "itself have the part of the model that needs them, if small"
            )
        else:
            text = (
                f"its particles would remember {', '.join(sorted(had - has))} no more; let the "
                "part of the model that needs it stay, if small"
            )
        yield Problem(path, text)
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


def _starts(entry: Material, dimensions: int) -> tuple[float, bytes]:
    """Initial state of particles of a material."""
    from pgimp.physics.materials.parameters.outside import parameters_of
    from pgimp.physics.materials.parameters.states import States

    initial = States([""], [parameters_of(entry, dimensions)], dimensions).initial
    return entry.initial_pressure, initial.tobytes()


def reselects(before: Case, now: Case, name: str) -> bool:
    """Whether a constraint selects its particles when a stage begins."""
    old, new = before.constraints.get(name), now.constraints[name]
    return old is None or (old.body, old.region) != (new.body, new.region)


def _with_origins(case: Case) -> bool:
    """Whether particles store their initial position; see `Scene.origins`."""
    initial = any(body.formulation == "total-lagrangian" for body in case.bodies.values())
    return initial or "displacement" in case.output.fields
