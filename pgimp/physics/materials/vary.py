"""Entries of materials with parameters that vary in space, and the kernels' view of them.

The entry of such a material has numbers throughout, typical ones in place of what varies, so that all
that does not depend on the place knows nothing of it. At a place the entry is another one, with the
numbers that belong there (`entry_at`), checked as if a case had them; what its parameters for the
kernels then are is what particles carry, as far as it varies (`Layout`).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from types import UnionType
from typing import Annotated, Any, NamedTuple, Self, Union, get_args, get_origin

import numpy as np
from pydantic import (
    BaseModel,
    ModelWrapValidatorHandler,
    PrivateAttr,
    SerializationInfo,
    SerializerFunctionWrapHandler,
    ValidationError,
    model_serializer,
    model_validator,
)
from pydantic_core import PydanticCustomError

from pgimp.errors import UsageError
from pgimp.jit.own import Own
from pgimp.physics.fields import PREFIX
from pgimp.physics.materials.variation import VARIATION, NoValueError, Path, Places, Variation
from pgimp.schema.base import Model
from pgimp.schema.dispatch import plain
from pgimp.schema.messages import explain
from pgimp.schema.problems import Problem, raise_problems

Variations = dict[tuple[str, ...], Variation]

#: What a parameter may be that only a file knows, to find an entry that is sound; see `typical_of`.
_GUESSES = (1.0, 0.25, 1e3, 1e6, 1e9, 1e-3, 10.0, 1e-6, 30.0, 0.0)
#: Attempts to find one.
_MOST_GUESSES = 2000
#: Numbers of a table that are tried one by one when a case is read.
_MOST_TRIED = 2000
#: Where a layer begins in which all is, in any units.
_FAR_AWAY = -1e140
#: Parts that are numbers of the method, not of the material.
_NOT_SPATIAL = (("viscosity",),)


def _plain_type(annotation: Any) -> list[Any]:
    """The types that an annotation allows, without what is annotated."""
    if get_origin(annotation) is Annotated:
        return _plain_type(get_args(annotation)[0])
    if get_origin(annotation) in (Union, UnionType):
        return [each for part in get_args(annotation) for each in _plain_type(part)]
    return [annotation]


def _below(annotation: Any) -> type[BaseModel] | None:
    """The model of a key that has keys of its own."""
    for each in _plain_type(annotation):
        if isinstance(each, type) and issubclass(each, BaseModel):
            return each
    return None


def numbers_of(model: type[BaseModel]) -> Iterator[tuple[str, ...]]:
    """Yield the keys of a material that are numbers, each with those above it."""
    for name, field in model.model_fields.items():
        key = field.alias or name
        if float in _plain_type(field.annotation):
            yield (key,)
        elif (key,) not in _NOT_SPATIAL and (part := _below(field.annotation)):
            yield from ((key, *rest) for rest in numbers_of(part))


def split(
    model: type[BaseModel], data: Mapping[str, Any]
) -> tuple[dict[str, Any], Variations]:
    """Find what varies in a material as a case has it.

    Returns
    -------
    data : dict
        The same, with keys as the model spells them.
    variations : dict of tuple of str to Variation
        What varies, by its keys.

    Raises
    ------
    ValidationError
        For everything that is wrong in it.
    """
    found: Variations = {}
    problems: list[Problem] = []
    spelled = _find(model, data, (), found, problems)
    raise_problems(model.__name__, problems, data)
    return spelled, found


def _find(
    model: type[BaseModel], data: Mapping[str, Any], path: tuple[str, ...], found: Variations,
    problems: list[Problem],
) -> dict[str, Any]:  # fmt: skip
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


def replaced(data: Any, values: Mapping[tuple[str, ...], Any]) -> dict[str, Any]:
    """Return a mapping with other values at some paths; the parts on the way are copied."""
    found = dict(data)
    for path, value in values.items():
        inner = found
        for key in path[:-1]:
            inner[key] = dict(inner[key])
            inner = inner[key]
        inner[path[-1]] = value
    return found


def typical_of(
    data: Mapping[str, Any], variations: Variations, make: Callable[[Any], Any]
) -> Any:
    """Return an entry with typical numbers in place of what varies, once all known ones are sound.

    Of what only a file knows some number is taken with which there is an entry at all.

    Parameters
    ----------
    data : mapping
        The material as a case has it.
    variations : dict
        What varies of it.
    make : callable
        Makes an entry of numbers; raises a ValidationError where it cannot.

    Raises
    ------
    ValidationError
        For everything that is wrong in the material or in the numbers of its variations.
    """
    unknown = [path for path, each in variations.items() if each.typical is None]
    known = {path: each.typical for path, each in variations.items() if path not in unknown}
    entry, best = None, None
    guesses = itertools.product(_GUESSES, repeat=len(unknown))
    for guess in itertools.islice(guesses, _MOST_GUESSES):
        typical = known | dict(zip(unknown, guess, strict=True))
        try:
            entry = make(replaced(data, typical))
            break
        except ValidationError as error:
            if best is None or error.error_count() < best.error_count():
                best = error
    if entry is None:
        assert best is not None
        raise best
    problems: list[Problem] = []
    for path, each in variations.items():
        for place, value in _some(each.known()):
            try:
                make(replaced(data, typical | {path: value}))
            except ValidationError as error:
                problems.append(Problem((*path, *place), first_text(error)))
    raise_problems("material", problems, data)
    return entry


def _some(known: Sequence[tuple[Path, float]]) -> Iterable[tuple[Path, float]]:
    return known[:: max(1, -(-len(known) // _MOST_TRIED))]


def first_text(error: ValidationError) -> str:
    """What is wrong, as one sentence."""
    first = error.errors(include_url=False)[0]
    return first.get("ctx", {}).get("text") or first["msg"]


def value_at(entry: BaseModel, path: Sequence[str]) -> Any:
    """Return the number of an entry at keys of the case."""
    inner: Any = entry
    for key in path:
        fields = type(inner).model_fields.items()
        inner = getattr(inner, next(name for name, field in fields if (field.alias or name) == key))
    return inner


def _names_of(model: type[BaseModel], path: tuple[str, ...]) -> tuple[str, ...]:
    """Names of the fields at keys of the case."""
    fields = model.model_fields
    name = next(name for name, field in fields.items() if (field.alias or name) == path[0])
    if len(path) == 1:
        return (name,)
    below = _below(fields[name].annotation)
    assert below is not None
    return (name, *_names_of(below, path[1:]))


class Varying(Model):
    """Base of entries of which numbers may vary in space."""

    _variations: Variations = PrivateAttr(default_factory=dict)

    @model_validator(mode="wrap")
    @classmethod
    def _take_variations(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Take typical numbers in place of what varies in space, and keep how it does."""
        if not isinstance(data, dict):
            return handler(data)
        spelled, variations = split(cls, data)
        if not variations:
            return handler(data)
        entry = typical_of(spelled, variations, handler)
        entry._variations = variations
        return entry

    @model_serializer(mode="wrap")
    def _write(self, handler: SerializerFunctionWrapHandler, info: SerializationInfo) -> Any:
        """Write what varies as the case has it."""
        data = handler(self)
        if not self._variations:
            return data
        keys = (lambda path: path) if info.by_alias else partial(_names_of, type(self))
        return replaced(data, {keys(path): plain(each) for path, each in self._variations.items()})

    @property
    def variations(self) -> Variations:
        """What varies in space, by its keys; the numbers of the entry are then typical ones."""
        return self._variations

    def typical(self, key: str) -> float:
        """Return a number, a typical one if it varies; by then files should have been read."""
        variation = self._variations.get((key,))
        found = None if variation is None else variation.typical
        return value_at(self, (key,)) if found is None else found

    def maker(self) -> Callable[[Mapping[tuple[str, ...], float]], Self]:
        """Return a function that gives the same material with numbers in place of what varies.

        It takes numbers by their keys; of what is left out, typical ones. It raises a
        ValidationError if they are not allowed.
        """
        typical = {path: value_at(self, path) for path in self._variations}
        data, kind = replaced(self.model_dump(by_alias=True), typical), type(self)
        return lambda values: kind.model_validate(replaced(data, values))

    def uniform(self) -> dict[str, Any]:
        """Return what a case would say of it without variation, of particles that carry it still.

        They are all of one layer.
        """
        layers = {}
        for path, variation in self._variations.items():
            typical = variation.typical
            value = value_at(self, path) if typical is None else typical
            layers[path] = {"over": "x", "layers": ((_FAR_AWAY, value),)}
        return replaced(self.model_dump(by_alias=True), layers)

    def at(self, x: Any) -> Self:
        """Return the material as it is at a place.

        Parameters
        ----------
        x : (D,) array_like of float
            The place, at the start.

        Raises
        ------
        UsageError
            If a parameter is a column of particles, which no place has, or has no value there.
        """
        place = np.array([x], float)
        values = {}
        for path, variation in self._variations.items():
            key = ".".join(path)
            if columns := [each for part in variation.parts() for each in part.columns]:
                raise UsageError(
                    f"{key} is the column {', '.join(columns)} of particles, and no place "
                    f"has it; give a number, --set materials.NAME.{key}=.."
                )
            problem = next(iter(variation.problems(place.shape[1])), None)
            try:
                if problem:
                    raise UsageError(f"{key}: {problem.text}")
                values[path] = float(variation.values(Places(place, {}))[0])
            except NoValueError as error:
                raise UsageError(f"{key}: the place {error}") from None
        try:
            return self.maker()(values)
        except ValidationError as error:
            raise UsageError(f"at this place {first_text(error)}") from None


def field_of(path: Sequence[str]) -> str:
    """Name of the field that shows a parameter."""
    return PREFIX + "-".join(path).replace("_", "-")


def leaves(value: Any) -> list[Any]:
    """Numbers and whatever else is in a structure of tuples, in order."""
    if isinstance(value, tuple):
        return [each for part in value for each in leaves(part)]
    return [value]


def _rebuilt(value: Any, given: Iterator[Any]) -> Any:
    """A structure of tuples with other leaves."""
    if not isinstance(value, tuple):
        return next(given)
    parts = [_rebuilt(part, given) for part in value]
    return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)


class Layout(NamedTuple):
    """How the particles of a material carry what varies of it.

    Attributes
    ----------
    kind : type
        Class of its parameters.
    varying : list of int
        Which of the numbers in the parameters vary, in order: the first columns of a particle.
    paths : list of tuple of str
        Keys of the case that vary.
    places : list of int
        Column in which the value of each lies.
    width : int
        Columns.
    """

    kind: type
    varying: list[int]
    paths: list[tuple[str, ...]]
    places: list[int]
    width: int

    def marked(self, parameters: Any) -> Any:
        """Return parameters with `Own` in place of what varies."""
        found = leaves(parameters)
        for place, leaf in enumerate(self.varying):
            found[leaf] = Own(place)
        return _rebuilt(parameters, iter(found))

    def row(self, parameters: Any, values: Sequence[float]) -> np.ndarray:
        """Return the columns of a particle, from its parameters and values of the case."""
        found = leaves(parameters)
        row = np.empty(self.width)
        row[: len(self.varying)] = [found[leaf] for leaf in self.varying]
        for place, value in zip(self.places, values, strict=True):
            row[place] = value
        return row

    def values(self, row: np.ndarray) -> list[float]:
        """Return the values of the case that a particle carries."""
        return [float(row[place]) for place in self.places]


def layout_of(entry: Any, make: Callable[[Any], Any]) -> Layout:
    """Find which numbers of the kernels' parameters depend on what varies.

    They are those that are others with another value of any one; `make` makes the parameters of an
    entry.
    """
    variations: Variations = entry.variations
    paths = list(variations)
    base, entry_with = make(entry), entry.maker()
    own = [value_at(entry, path) for path in paths]
    first = leaves(base)
    varying: set[int] = set()
    given = [{i for i, leaf in enumerate(first) if same(leaf, value)} for value in own]
    for number, path in enumerate(paths):
        for value in _probes(variations[path], own[number]):
            try:
                other = make(entry_with({path: value}))
            except (ValidationError, ValueError):
                continue
            if type(other) is not type(base):
                continue
            found = leaves(other)
            varying |= {i for i, leaf in enumerate(found) if not same(leaf, first[i])}
            for j in range(len(paths)):
                now = value if j == number else own[j]
                given[j] &= {i for i, leaf in enumerate(found) if same(leaf, now)}
    order, places = sorted(varying), []
    width = len(order)
    for j in range(len(paths)):
        there = [order.index(i) for i in given[j] & varying]
        places.append(there[0] if there else width)
        width += not there
    return Layout(type(base), order, paths, places, width)


def same(a: Any, b: Any) -> bool:
    """Whether two leaves are equal."""
    return bool(np.array_equal(a, b))


def _probes(variation: Variation, typical: float) -> list[float]:
    """Values near and far from a typical one, of those that there may be where they are known."""
    known = sorted({value for _, value in variation.known()})
    found = known[:: max(1, len(known) // 20)] + known[-1:]
    return found + [typical * factor for factor in (1.01, 0.99, 1.3, 0.7, 2.0, 0.5)] + [
        typical + step for step in (1e-3, -1e-3)
    ]
