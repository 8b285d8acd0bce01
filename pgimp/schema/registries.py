"""Values whose type is looked up in a registry by a key, the value of a field, or a plain word.

The forms are annotations of a field, ``Annotated[Material, ByField(...)]``. The registry is read
when a case is validated, not before, so that types can be registered from outside the package.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any

from pydantic import BaseModel, GetJsonSchemaHandler, ValidationError

from pgimp.schema.dispatch import Dispatch, plain
from pgimp.schema.messages import explain, got, keys_of, unknown
from pgimp.schema.problems import Problem, problem, raise_problems

COMMENT = "defined under "
"""Prefix of a JSON schema's comment that stands for a reference to a definition."""

Registry = Callable[[], Mapping[str, type[BaseModel]]]


class ByField(Dispatch):
    """A mapping whose field `key` names its type, ``{model: hooke, ...}``; `hint` if unknown."""

    def __init__(self, registry: Registry, key: str, what: str, hint: str = ""):
        self.registry, self.key, self.what, self.hint = registry, key, what, hint

    def validate(self, value: object) -> BaseModel:
        """See `Dispatch`."""
        known = self.registry()
        if isinstance(value, BaseModel) and type(value) in known.values():
            return value
        if not isinstance(value, Mapping):
            raise problem(f"expected a mapping with the key '{self.key}', {got(value)}")
        name = value.get(self.key)
        names = ", ".join(sorted(known))
        if self.key not in value:
            missing = Problem((self.key,), f"missing; known {self.what}s: {names}", absent=True)
            return raise_problems(self.what, [missing], value)
        if not isinstance(name, str):
            wrong = f"expected the name of a {self.what} ({names}), {got(name)}"
        elif name not in known:
            wrong = unknown(self.what, name, known) + self.hint
        else:
            return known[name].model_validate(value)
        return raise_problems(self.what, [Problem((self.key,), wrong)], value)

    def write(self, value: BaseModel) -> dict[str, object]:
        """See `Dispatch`; the type comes first."""
        content = plain(value)
        return {self.key: content[self.key], **content}

    def document(self, handler: GetJsonSchemaHandler) -> dict[str, object]:
        """See `Dispatch`."""
        entries = self.registry().values()
        return {"oneOf": [handler(entry.__pydantic_core_schema__) for entry in entries]}


def _below(what: str, name: str, entry: type[BaseModel], content: object) -> BaseModel:
    """Return the typed content of the key `name`."""
    try:
        return entry.model_validate(content)
    except ValidationError as error:
        found = explain(entry, error, content)
        below = [Problem((name, *item.path), item.text, item.absent) for item in found]
        return raise_problems(what, below, content)


class ByKey(Dispatch):
    """A mapping with one key, its type's name in a registry: ``{box: {...}}``.

    A type that has a key of its name is the whole mapping: ``{function: .., parameters: ..}``.
    """

    def __init__(self, registry: Registry, what: str):
        self.registry, self.what = registry, what

    def validate(self, value: object) -> BaseModel | None:
        """See `Dispatch`."""
        known = self.registry()
        if isinstance(value, BaseModel) and type(value) in known.values():
            return value
        names = ", ".join(known)
        if not isinstance(value, Mapping) or not value:
            raise problem(f"expected a {self.what}, a mapping with one of {names}; {got(value)}")
        for name in value:
            if name in known and name in keys_of(known[name]):
                return known[name].model_validate(value)
        strange = [name for name in value if name not in known]
        texts = [Problem((name,), unknown(self.what, str(name), known)) for name in strange]
        if not strange and len(value) > 1:
            texts = [Problem((), f"expected exactly one of {names}, {got(value)}")]
        raise_problems(self.what, texts, value)
        ((name, content),) = value.items()
        return _below(self.what, name, known[name], content)

    def write(self, value: BaseModel) -> dict[str, object]:
        """See `Dispatch`."""
        name = name_of(value, self.registry())
        return plain(value) if name in keys_of(type(value)) else {name: plain(value)}

    def document(self, handler: GetJsonSchemaHandler) -> dict[str, object]:
        """Refer to a definition, since the types may contain one another."""
        return {"$comment": COMMENT + self.what}


class ByWord(Dispatch):
    """The name of a type in a registry, ``fixed``, or a mapping with it: ``{velocity: [...]}``.

    If the name is no key of the type, its keys are below: ``{unilateral: {friction: 0.3}}``. The
    plain name is the type with its defaults.
    """

    def __init__(self, registry: Registry, what: str):
        self.registry, self.what = registry, what

    def validate(self, value: object) -> BaseModel:
        """See `Dispatch`."""
        known = self.registry()
        if isinstance(value, BaseModel) and type(value) in known.values():
            return value
        if isinstance(value, str):
            if value not in known:
                raise problem(unknown(self.what, value, known))
            if value in keys_of(known[value]):
                raise problem(f"expected {{{value}: ...}}, {got(value)}")
            return known[value].model_validate({})
        if not isinstance(value, Mapping) or not value:
            raise problem(f"expected a {self.what}, one of {', '.join(known)}; {got(value)}")
        names = [key for key in value if key in known]
        if not names:
            found = [Problem((key,), unknown(self.what, str(key), known)) for key in value]
            raise_problems(self.what, found, value)
        if _is_word(known[names[0]]):
            raise problem(f"write the plain word '{names[0]}', {got(value)}")
        if names[0] in keys_of(known[names[0]]):
            return known[names[0]].model_validate(value)
        strange = [key for key in value if key != names[0]]
        texts = [Problem((key,), f"does not belong beside '{names[0]}'") for key in strange]
        raise_problems(self.what, texts, value)
        return _below(self.what, names[0], known[names[0]], value[names[0]])

    def write(self, value: BaseModel) -> object:
        """See `Dispatch`."""
        name = name_of(value, self.registry())
        content = plain(value)
        if name in keys_of(type(value)):
            return content
        bare = not _required(type(value)) and value == type(value)()
        return name if bare or not content else {name: content}

    def document(self, handler: GetJsonSchemaHandler) -> dict[str, object]:
        """See `Dispatch`."""
        forms: list[dict[str, object]] = []
        for name, entry in self.registry().items():
            if name in keys_of(entry):
                forms.append(handler(entry.__pydantic_core_schema__))
                continue
            forms.append({"const": name, "description": inspect.getdoc(entry)})
            if not _is_word(entry):
                forms.append(_nested(name, handler(entry.__pydantic_core_schema__)))
        return {"oneOf": forms}


def _nested(name: str, content: dict[str, object]) -> dict[str, object]:
    """Return the JSON schema of a mapping with the one key `name`."""
    return {
        "type": "object",
        "properties": {name: content},
        "required": [name],
        "additionalProperties": False,
    }


class ByName(ByKey):
    """The name of a type in a registry, a mapping with it, ``{name: {...}}``, or nothing.

    The plain name stands for the type with all its defaults.
    """

    def validate(self, value: object) -> BaseModel | None:
        """See `Dispatch`."""
        if value is None:
            return None
        known = self.registry()
        if isinstance(value, str):
            if value not in known:
                raise problem(unknown(self.what, value, known))
            if needed := _required(known[value]):
                keys = ", ".join(f"{key}: .." for key in needed)
                if value in needed:
                    raise problem(f"expected {{{keys}, parameters: {{..}}}}, {got(value)}")
                raise problem(f"expected {{{value}: {{{keys}}}}}, {got(value)}")
            return known[value].model_validate({})
        return super().validate(value)

    def write(self, value: BaseModel | None) -> Any:
        """See `Dispatch`."""
        if value is None or not _is_word(type(value)):
            return None if value is None else super().write(value)
        return name_of(value, self.registry())

    def document(self, handler: GetJsonSchemaHandler) -> dict[str, object]:
        """See `Dispatch`."""
        forms: list[dict[str, object]] = []
        for name, entry in self.registry().items():
            if name in keys_of(entry):
                forms.append(handler(entry.__pydantic_core_schema__))
                continue
            if not _required(entry):
                forms.append({"const": name, "description": inspect.getdoc(entry)})
            if not _is_word(entry):
                forms.append(_nested(name, handler(entry.__pydantic_core_schema__)))
        return {"oneOf": [*forms, {"type": "null"}]}


def _is_word(entry: type[BaseModel]) -> bool:
    return not entry.model_fields


def _required(entry: type[BaseModel]) -> list[str]:
    """Return the required keys of a type."""
    return [name for name, field in entry.model_fields.items() if field.is_required()]


def name_of(value: BaseModel, known: Mapping[str, type[BaseModel]]) -> str:
    """Return the name of the type of `value` in a registry."""
    return next(name for name, entry in known.items() if type(value) is entry)
