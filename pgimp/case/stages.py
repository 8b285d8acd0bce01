"""Stages: their entries in the case, with the changes during a run.

Each stage is a case of its own: the previous stage's case with the changes, see `merged`. So all
checks of a case apply to every stage, before the first step.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from pydantic import Field, model_serializer

from pgimp.case.staging.strength import Strength
from pgimp.case.start import Settle
from pgimp.case.stepping.steps import AnyStep
from pgimp.schema.base import Model, Name, Positive
from pgimp.schema.tables import VaryingVector

#: Sections whose named entries change key by key; sections whose entries are replaced; sections
#: that change key by key themselves; sections that are replaced.
BY_KEY, BY_ENTRY = ("materials", "tractions", "constraints"), ("boundaries", "outflow")
SECTIONS = ("method", "output", "history")
WHOLE = ("gravity", "body-force", "water", "damping", "contact")

_Entries = dict[str, object]


def _unchanged(schema: dict[str, Any]) -> None:
    """Document that missing keys change nothing."""
    schema.pop("default", None)
    schema["$comment"] = "as before"


def _change(what: str, default: Any = None, alias: str | None = None) -> Any:
    return Field(default=default, alias=alias, description=what, json_schema_extra=_unchanged)


def _keyed(what: str) -> Any:
    return _change(what, {})


def _any_form(schema: dict[str, Any]) -> None:
    _unchanged(schema)
    schema["oneOf"] = [{"type": kind} for kind in ("string", "null")]
    schema["oneOf"].insert(1, {"type": "object", "additionalProperties": True})


class Stage(Model):
    """A stage: its name, its end, and what changes as it begins."""

    name: Name = Field(description="its name, for messages")
    end: Positive | None = Field(
        default=None,
        description="simulated time at which it is done; one with `equilibrate` has none [time]",
    )
    equilibrate: Settle | None = Field(
        default=None,
        description="the stage comes to rest under its loads, as in `start.equilibrate`, and is "
        "done then, at the time at which it began: steps go on, simulated time does not. "
        "Displacements and sums of the history go on. {} takes the defaults; null: it does not",
    )
    step: AnyStep | None = _change(
        "as `time.step`; a fixed one is counted from where the stage begins, if it is another than "
        "before"
    )
    remove: tuple[Name, ...] = Field(
        default=(),
        description="bodies that are taken out as it begins, also rigid ones; what they had of "
        "mass, momentum and energy goes into the columns `removed` of the history",
    )
    add: tuple[Name, ...] = Field(
        default=(),
        description="bodies of the case that come as it begins, and are not there before; what "
        "they bring of mass, momentum and energy goes into the columns `added` of the history",
    )
    method: _Entries = _keyed("`pic-damping`, as in the case")
    materials: _Entries = _keyed(
        "by name, parameters that change, {soil: {cohesion: 2.0e3}}; not `model`, `density`, and "
        "what particles only start with"
    )
    strength: Strength | None = _change(
        "soils are weaker than cases and stages have them, by a factor, from here on; of another "
        "stage's it is in place; null: none",
        alias="strength-reduction",
    )
    gravity: VaryingVector = _change("as in the case, in place of it; null: none [length/time^2]")
    body_force: object = Field(
        default=None,
        alias="body-force",
        description="as in the case, in place of it; null: none",
        json_schema_extra=_any_form,
    )
    water: object = Field(
        default=None,
        description="as in the case, in place of it, so that its level changes at once; null: none",
        json_schema_extra=_any_form,
    )
    damping: object = Field(
        default=None,
        description="as in the case, in place of it; null: none",
        json_schema_extra=_any_form,
    )
    boundaries: _Entries = _keyed(
        "by face, conditions in place of those before; null: none from here on"
    )
    outflow: _Entries = _keyed("by face, as in the case; null: `stop`")
    tractions: _Entries = _keyed(
        "by name, keys that change of a traction of the case; null ends it; no new ones"
    )
    constraints: _Entries = _keyed(
        "by name, keys that change; null ends a constraint. One that is new, or has another "
        "region or body, holds the particles that are in its region as the stage begins"
    )
    contact: tuple[_Entries, ...] = _change("the list as in the case, in place of it", ())
    output: _Entries = _keyed("keys of the case's that change, but `at`, which is for all stages")
    history: _Entries = _keyed("keys of the case's that change")

    @model_serializer(mode="wrap")
    def _as_written(self, handler: Any) -> dict[str, Any]:
        """Write only the given keys: missing keys change nothing."""
        given = {self.key(name) for name in self.model_fields_set} | self.model_fields_set
        return {key: value for key, value in handler(self).items() if key in given}

    @classmethod
    def key(cls, name: str) -> str:
        """Return the key of a field."""
        return cls.model_fields[name].alias or name

    @property
    def changes(self) -> dict[str, Any]:
        """Changes by section, as written."""
        named = ("name", "end", "step", "equilibrate")
        every = self.model_dump(by_alias=True)
        return {key: value for key, value in every.items() if key not in named}


class Staged(NamedTuple):
    """Data of a stage from previous stages."""

    number: int = 0  #: Number of the stage; 0 is the case itself.
    name: str = ""  #: Empty for number 0.
    start: float = 0.0  #: Time at which the stage begins.
    #: Time from which its fixed steps are counted: the time at which they got this length.
    counted: float = 0.0
    removed: tuple[str, ...] = ()  #: Removed bodies of a material.
    escapes: bool = False  #: Whether particles may leave, in this stage or a previous one.
    #: Displacements that constraints have prescribed in previous stages, to be added.
    displacements: Mapping[str, tuple[float, ...]] = {}
    #: Whether a stage has given other entries of contact, which may bond bodies anew.
    rebonds: bool = False
    damped: bool = False  #: Whether a previous stage has damping.
    settled: bool = False  #: Whether a previous stage after the first has come to rest.
    meets: bool = False  #: Whether bodies may meet anything in any stage.
    added: tuple[str, ...] = ()  #: Bodies that have come in this stage or a previous one.
    awaited: Mapping[str, int] = {}  #: Bodies that come in later stages, with their numbers.
    stress: Any = None  #: InitialStress or None: The stress with which bodies begin.
    angles: Mapping[str, float] = {}  #: Likewise the angles of rotation.
    profile_offsets: Mapping[str, float] = {}  #: Likewise the ways of the profiles of loads.

    @property
    def title(self) -> str:
        """Name in messages."""
        return f"stage '{self.name}'" if self.number else "the first stage"


def merged(
    before: Mapping[str, Any], stage: Stage, spellings: Mapping[str, Mapping[str, str]]
) -> dict[str, object]:
    """Return the case of a stage, as plain data.

    Parameters
    ----------
    before : mapping
        The case of the previous stage, from `Case.model_dump`.
    stage : Stage
        The changes.
    spellings : mapping
        Other spellings of keys, by the name of the material.
    """
    data, changes = dict(before), stage.changes
    for section in (*BY_KEY, *BY_ENTRY):
        entries = dict(data[section])
        for name, entry in changes.get(section, {}).items():
            if entry is None:
                entries.pop(name, None)
            elif section in BY_KEY and name in entries and isinstance(entry, Mapping):
                known = spellings.get(name, {}) if section == "materials" else {}
                entries[name] = _updated(
                    entries[name], {known.get(key, key): value for key, value in entry.items()}
                )
            else:
                entries[name] = entry
        data[section] = entries
    for section in SECTIONS:
        data[section] = _updated(data[section], changes.get(section, {}))
    data |= {section: changes[section] for section in WHOLE if section in changes}
    step = stage.step if stage.step is not None else before["time"]["step"]
    end = before["time"]["end"] if stage.end is None else stage.end
    data["time"] = {**before["time"], "end": end, "step": step}
    data["start"] = {"equilibrate": stage.equilibrate and stage.equilibrate.model_dump()}
    for name in stage.remove:
        if "rigid" in data["bodies"].get(name, {}):
            data["bodies"] = {key: body for key, body in data["bodies"].items() if key != name}
            data["contact"] = _without(data["contact"], name, len(data["bodies"]))
    return data


def _updated(entry: Mapping[str, object], changes: Mapping[str, object]) -> dict[str, object]:
    """Return an entry with other values of some keys; null resets a key to its default."""
    gone = {key for key, value in changes.items() if value is None}
    return {key: value for key, value in {**entry, **changes}.items() if key not in gone}


def _without(contact: Any, name: str, bodies: int) -> tuple[Any, ...]:
    """Contact entries without a rigid body; entries left with one body are dropped."""
    found = []
    for entry in contact:
        rest, enough = entry.get("bodies", ()), bodies > 1
        if not isinstance(rest, str):
            rest = tuple(each for each in rest if each != name)
            enough = len(rest) > 1
        if enough:
            found.append({**entry, "bodies": rest})
    return tuple(found)
