"""Values of a case with several forms, distinguished by type.

The forms are annotations of a field, ``Annotated[float | Table, Either(...)]``. Forms that are
distinguished by name are in `pgimp.schema.registries`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from contextvars import ContextVar
from typing import Annotated, Any

from pydantic import BaseModel, GetJsonSchemaHandler, TypeAdapter
from pydantic_core import CoreSchema, core_schema

from pgimp.schema.messages import got
from pgimp.schema.problems import problem

_SPARSE: ContextVar[bool] = ContextVar("sparse", default=False)


def plain(value: Any) -> Any:
    """Return `value` as the mappings, tuples and scalars that a case file writes."""
    if not isinstance(value, BaseModel):
        return value
    return value.model_dump(by_alias=True, exclude_unset=_SPARSE.get())


def given(value: BaseModel) -> dict[str, object]:
    """Return the given keys of `value`, without defaults."""
    token = _SPARSE.set(True)
    try:
        return plain(value)
    finally:
        _SPARSE.reset(token)


class Dispatch(ABC):
    """Base of the annotations: validates, writes and documents a value of several forms."""

    @abstractmethod
    def validate(self, value: object) -> object:
        """Return the typed value; raise a pydantic error if `value` has no known form."""

    @abstractmethod
    def write(self, value: Any) -> Any:
        """Return the typed value as a case file writes it."""

    @abstractmethod
    def document(self, handler: GetJsonSchemaHandler) -> dict[str, object]:
        """Return the JSON schema of the value."""

    def __get_pydantic_core_schema__(self, source: object, handler: object) -> CoreSchema:
        """Define validation and writing of the value for pydantic."""
        return core_schema.no_info_plain_validator_function(
            self.validate,
            serialization=core_schema.plain_serializer_function_ser_schema(self.write),
        )

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, object]:
        """Document the value."""
        return self.document(handler)


class Either(Dispatch):
    """A value whose type decides its form: ``0.5`` or ``{steps: 10}``."""

    def __init__(self, expected: str, forms: Mapping[type | None, Any]):
        """Set the forms.

        Parameters
        ----------
        expected : str
            The allowed values, for the message if none of the forms fits.
        forms : mapping of type to type
            Type for validation of a number (key float), a list (tuple), a mapping (dict) or
            nothing (None); may be a `Dispatch`.
        """
        self.expected = expected
        self.forms = forms
        self.adapters = {
            kind: TypeAdapter(Annotated[object, form] if isinstance(form, Dispatch) else form)
            for kind, form in forms.items()
        }

    def validate(self, value: object) -> object:
        """See `Dispatch`."""
        adapter = self.adapters.get(_kind(value))
        if adapter is None:
            raise problem(f"expected {self.expected}, {got(value)}")
        return adapter.validate_python(value)

    def write(self, value: object) -> object:
        """See `Dispatch`."""
        kind = _kind(value)
        form = self.forms.get(kind)
        if isinstance(form, Dispatch):
            return form.write(value)
        if kind is tuple and tuple in self.adapters:  # its items may have several forms, too
            return self.adapters[tuple].dump_python(
                value, by_alias=True, exclude_unset=_SPARSE.get()
            )
        return plain(value)

    def document(self, handler: GetJsonSchemaHandler) -> dict[str, object]:
        """See `Dispatch`."""
        forms = [
            form.document(handler) if isinstance(form, Dispatch) else handler(adapter.core_schema)
            for form, adapter in zip(self.forms.values(), self.adapters.values(), strict=True)
        ]
        return {"oneOf": forms}


class WithKey(Dispatch):
    """A mapping of one type if it has a key, and of another type if not."""

    def __init__(self, key: str, having: type[BaseModel], other: type[BaseModel]):
        self.key, self.having, self.other = key, having, other

    def validate(self, value: object) -> BaseModel:
        """See `Dispatch`."""
        if isinstance(value, self.having | self.other):
            return value
        if not isinstance(value, Mapping):
            raise problem(f"expected a mapping, {got(value)}")
        form = self.having if self.key in value else self.other
        return form.model_validate(value)

    def write(self, value: BaseModel) -> object:
        """See `Dispatch`."""
        return plain(value)

    def document(self, handler: GetJsonSchemaHandler) -> dict[str, object]:
        """See `Dispatch`."""
        forms = (self.other, self.having)
        return {"oneOf": [handler(form.__pydantic_core_schema__) for form in forms]}


def _kind(value: object) -> type | None:
    """Return the key of the form of `value`; its own type if it has none."""
    if value is None:
        return None
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float
    if isinstance(value, Mapping | BaseModel):
        return dict
    return tuple if isinstance(value, list | tuple) else type(value)
