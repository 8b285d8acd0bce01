"""Variations in an entry of a case: search, and replacement by numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import PydanticCustomError

from pgimp.physics.variation import VARIATION, Variation
from pgimp.schema.messages import explain
from pgimp.schema.problems import Problem, raise_problems

#: Variations by their keys.
Variations = dict[tuple[str, ...], Variation]

#: Keys that belong to the method, not to the material.
_NOT_SPATIAL = (("viscosity",),)


def _plain_type(annotation: object) -> list[object]:
    """Types that an annotation allows, without metadata."""
    if get_origin(annotation) is Annotated:
        return _plain_type(get_args(annotation)[0])
    if get_origin(annotation) in (Union, UnionType):
        return [each for part in get_args(annotation) for each in _plain_type(part)]
    return [annotation]


def _below(annotation: object) -> type[BaseModel] | None:
    """Model of a key that has keys of its own."""
    for each in _plain_type(annotation):
        if isinstance(each, type) and issubclass(each, BaseModel):
            return each
    return None


def split(
    model: type[BaseModel], data: Mapping[str, object]
) -> tuple[dict[str, object], Variations]:
    """Find the variations in a material's entry.

    Returns
    -------
    data : dict
        The same entry, with keys as the model spells them.
    variations : dict of tuple of str to Variation
        Variations by their keys.

    Raises
    ------
    ValidationError
        For all errors in the variations.
    """
    found: Variations = {}
    problems: list[Problem] = []
    spelled = _find(model, data, (), found, problems)
    raise_problems(model.__name__, problems, data)
    return spelled, found


def _find(
    model: type[BaseModel],
    data: Mapping[str, object],
    path: tuple[str, ...],
    found: Variations,
    problems: list[Problem],
) -> dict[str, object]:
    other = {key: name for key, name in model.SPELLINGS.items() if name not in data}  # type: ignore[attr-defined]
    fields = {field.alias or name: field for name, field in model.model_fields.items()}
    spelled = {}
    for written, value in data.items():
        key = other.get(written, written)
        spelled[key] = value
        field = fields.get(key)
        if field is None or not isinstance(value, Mapping | Variation):
            continue
        if float not in _plain_type(field.annotation):
            if (part := _below(field.annotation)) and isinstance(value, Mapping):
                spelled[key] = _find(part, value, (*path, key), found, problems)
        elif path[:1] in _NOT_SPATIAL:
            text = "expected a number: artificial viscosity is the same everywhere"
            problems.append(Problem((*path, written), text))
        else:
            try:
                found[*path, key] = variation = VARIATION.validate(value)
            except ValidationError as error:
                items = explain(Variation, error, value)
                problems += [Problem((*path, written, *i.path), i.text, i.absent) for i in items]
            except PydanticCustomError as error:
                problems.append(Problem((*path, written), error.message()))
            else:
                for each in variation.parts():
                    each.called(key)
    return spelled


def replaced(data: Mapping[str, Any], values: Mapping[tuple[str, ...], object]) -> dict[str, Any]:
    """Return a mapping with other values at some paths; the parts on the way are copied."""
    found = dict(data)
    for path, value in values.items():
        inner = found
        for key in path[:-1]:
            inner[key] = dict(inner[key])
            inner = inner[key]
        inner[path[-1]] = value
    return found


def value_at(entry: BaseModel, path: Sequence[str]) -> float:
    """Return the number of an entry at keys of the case."""
    inner: Any = entry
    for key in path:
        fields = type(inner).model_fields.items()
        inner = getattr(inner, next(name for name, field in fields if (field.alias or name) == key))
    return inner


def described(model: type[BaseModel], path: Sequence[str]) -> str:
    """Return an entry's description of the number at keys of the case, with its unit."""
    *above, last = names_of(model, tuple(path))
    for name in above:
        below = _below(model.model_fields[name].annotation)
        assert below is not None
        model = below
    return model.model_fields[last].description or path[-1]


def names_of(model: type[BaseModel], path: tuple[str, ...]) -> tuple[str, ...]:
    """Names of the fields at keys of the case."""
    fields = model.model_fields
    name = next(name for name, field in fields.items() if (field.alias or name) == path[0])
    if len(path) == 1:
        return (name,)
    below = _below(fields[name].annotation)
    assert below is not None
    return (name, *names_of(below, path[1:]))
