"""Values of a case that come in several forms: chosen by a name in a registry, or by their type.

The forms are annotations of a field, ``Annotated[Material, ByField(...)]``. A registry is asked
when a case is validated, not before, so that types can be registered from outside the package.
"""

from __future__ import annotations

import inspect
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from contextvars import ContextVar
from typing import Annotated, Any

from pydantic import BaseModel, GetJsonSchemaHandler, TypeAdapter, ValidationError
from pydantic_core import CoreSchema, core_schema

from pgimp.schema.messages import explain, got, unknown
from pgimp.schema.problems import Problem, problem, raise_problems

COMMENT = "defined under "
"""What a JSON schema's comment starts with that stands for a reference to a definition."""

Registry = Callable[[], Mapping[str, type[BaseModel]]]


_SPARSE: ContextVar[bool] = ContextVar("sparse", default=False)


def plain(value: Any) -> Any:
    """Return `value` as the mappings, tuples and scalars that a case file writes."""
    if not isinstance(value, BaseModel):
        return value
    return value.model_dump(by_alias=True, exclude_unset=_SPARSE.get())


def given(value: BaseModel) -> dict[str, Any]:
    """Return what was given of `value`, without the defaults that it got."""
    token = _SPARSE.set(True)
    try:
        return plain(value)
    finally:
        _SPARSE.reset(token)


class Dispatch(ABC):
    """Base of the annotations: validates, writes and documents a value of several forms."""

    @abstractmethod
    def validate(self, value: Any) -> Any:
        """Return the typed value; raise a pydantic error where `value` has no known form."""

    @abstractmethod
    def write(self, value: Any) -> Any:
        """Return the typed value as a case file writes it."""

    @abstractmethod
    def document(self, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Return the JSON schema of the value."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> CoreSchema:
        """Tell pydantic how to validate and to write the value."""
        return core_schema.no_info_plain_validator_function(
            self.validate,
            serialization=core_schema.plain_serializer_function_ser_schema(self.write),
        )

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Document the value."""
        return self.document(handler)


class ByField(Dispatch):
    """A mapping whose field `key` names its type, ``{model: hooke, ...}``; `hint` if unknown."""

    def __init__(self, registry: Registry, key: str, what: str, hint: str = ""):
        self.registry, self.key, self.what, self.hint = registry, key, what, hint

    def validate(self, value: Any) -> BaseModel:
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

    def write(self, value: BaseModel) -> dict[str, Any]:
        """See `Dispatch`; the type comes first."""
        content = plain(value)
        return {self.key: content[self.key], **content}

    def document(self, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """See `Dispatch`."""
        entries = self.registry().values()
        return {"oneOf": [handler(entry.__pydantic_core_schema__) for entry in entries]}


def _below(what: str, name: str, entry: type[BaseModel], content: Any) -> BaseModel:
    """Return the typed content of the key `name`."""
    try:
        return entry.model_validate(content)
    except ValidationError as error:
        found = explain(entry, error, content)
        below = [Problem((name, *item.path), item.text, item.absent) for item in found]
        return raise_problems(what, below, content)


class ByKey(Dispatch):
    """A mapping with one key, its type's name in a registry: ``{box: {...}}``."""

    def __init__(self, registry: Registry, what: str):
        self.registry, self.what = registry, what

    def validate(self, value: Any) -> BaseModel | None:
        """See `Dispatch`."""
        known = self.registry()
        if isinstance(value, BaseModel) and type(value) in known.values():
            return value
        names = ", ".join(known)
        if not isinstance(value, Mapping) or not value:
            raise problem(f"expected a {self.what}, a mapping with one of {names}; {got(value)}")
        strange = [name for name in value if name not in known]
        texts = [Problem((name,), unknown(self.what, str(name), known)) for name in strange]
        if not strange and len(value) > 1:
            texts = [Problem((), f"expected exactly one of {names}, {got(value)}")]
        raise_problems(self.what, texts, value)
        ((name, content),) = value.items()
        return _below(self.what, name, known[name], content)

    def write(self, value: BaseModel) -> dict[str, Any]:
        """See `Dispatch`."""
        return {name_of(value, self.registry()): plain(value)}

    def document(self, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Refer to a definition, since the types may contain one another."""
        return {"$comment": COMMENT + self.what}


class ByWord(Dispatch):
    """The name of a type in a registry, ``fixed``, or a mapping with it: ``{velocity: [...]}``.

    Where the name is no key of the type, its keys stand below: ``{separating: {friction: 0.3}}``;
    the plain name is the type with its defaults.
    """

    def __init__(self, registry: Registry, what: str):
        self.registry, self.what = registry, what

    def validate(self, value: Any) -> BaseModel:
        """See `Dispatch`."""
        known = self.registry()
        if isinstance(value, BaseModel) and type(value) in known.values():
            return value
        if isinstance(value, str):
            if value not in known:
                raise problem(unknown(self.what, value, known))
            if value in known[value].model_fields:
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
        if names[0] in known[names[0]].model_fields:
            return known[names[0]].model_validate(value)
        strange = [key for key in value if key != names[0]]
        texts = [Problem((key,), f"does not belong beside '{names[0]}'") for key in strange]
        raise_problems(self.what, texts, value)
        return _below(self.what, names[0], known[names[0]], value[names[0]])

    def write(self, value: BaseModel) -> Any:
        """See `Dispatch`."""
        name = name_of(value, self.registry())
        content = plain(value)
        if name in type(value).model_fields:
            return content
        return {name: content} if value != type(value)() and content else name

    def document(self, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """See `Dispatch`."""
        forms: list[dict[str, Any]] = []
        for name, entry in self.registry().items():
            if name in entry.model_fields:
                forms.append(handler(entry.__pydantic_core_schema__))
                continue
            forms.append({"const": name, "description": inspect.getdoc(entry)})
            if not _is_word(entry):
                forms.append(_nested(name, handler(entry.__pydantic_core_schema__)))
        return {"oneOf": forms}


def _nested(name: str, content: dict[str, Any]) -> dict[str, Any]:
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

    def validate(self, value: Any) -> BaseModel | None:
        """See `Dispatch`."""
        if value is None:
            return None
        known = self.registry()
        if isinstance(value, str):
            if value not in known:
                raise problem(unknown(self.what, value, known))
            if needed := _required(known[value]):
                keys = ", ".join(f"{key}: .." for key in needed)
                raise problem(f"expected {{{value}: {{{keys}}}}}, {got(value)}")
            return known[value].model_validate({})
        return super().validate(value)

    def write(self, value: BaseModel | None) -> Any:
        """See `Dispatch`."""
        if value is None or not _is_word(type(value)):
            return None if value is None else super().write(value)
        return name_of(value, self.registry())

    def document(self, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """See `Dispatch`."""
        forms: list[dict[str, Any]] = []
        for name, entry in self.registry().items():
            if not _required(entry):
                forms.append({"const": name, "description": inspect.getdoc(entry)})
            if not _is_word(entry):
                forms.append(_nested(name, handler(entry.__pydantic_core_schema__)))
        return {"oneOf": [*forms, {"type": "null"}]}


class Either(Dispatch):
    """A value whose kind decides its form: ``0.5`` or ``{steps: 10}``."""

    def __init__(self, expected: str, forms: Mapping[type | None, Any]):
        """Take the forms.

        Parameters
        ----------
        expected : str
            What may be written, for the message where the value has no form.
        forms : mapping of type to type
            What to validate a value as that is a number (key float), a list (tuple), a mapping
            (dict) or nothing (None); a `Dispatch` too.
        """
        self.expected = expected
        self.forms = forms
        self.adapters = {
            kind: TypeAdapter(Annotated[Any, form] if isinstance(form, Dispatch) else form)
            for kind, form in forms.items()
        }

    def validate(self, value: Any) -> Any:
        """See `Dispatch`."""
        adapter = self.adapters.get(_kind(value))
        if adapter is None:
            raise problem(f"expected {self.expected}, {got(value)}")
        return adapter.validate_python(value)

    def write(self, value: Any) -> Any:
        """See `Dispatch`."""
        return plain(value)

    def document(self, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """See `Dispatch`."""
        forms = [
            form.document(handler) if isinstance(form, Dispatch) else handler(adapter.core_schema)
            for form, adapter in zip(self.forms.values(), self.adapters.values(), strict=True)
        ]
        return {"oneOf": forms}


def _kind(value: Any) -> type | None:
    """Return the key of the form that `value` has; its own type where it has none."""
    if value is None:
        return None
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float
    if isinstance(value, Mapping | BaseModel):
        return dict
    return tuple if isinstance(value, list | tuple) else type(value)


def _is_word(entry: type[BaseModel]) -> bool:
    return not entry.model_fields


def _required(entry: type[BaseModel]) -> list[str]:
    """Return the keys that a type needs."""
    return [name for name, field in entry.model_fields.items() if field.is_required()]


def name_of(value: BaseModel, known: Mapping[str, type[BaseModel]]) -> str:
    """Return the name of the type of `value` in a registry."""
    return next(name for name, entry in known.items() if type(value) is entry)
