"""Entries of materials with parameters that vary in space.

The entry of such a material has numbers throughout, typical ones in place of what varies, so that
all that does not depend on the place knows nothing of it. At a place the entry is another one, with
the numbers that belong there (`Varying.maker`), checked as if a case had them.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any, Self

import numpy as np
from pydantic import (
    ModelWrapValidatorHandler,
    PrivateAttr,
    SerializationInfo,
    SerializerFunctionWrapHandler,
    ValidationError,
    model_serializer,
    model_validator,
)

from pgimp.errors import UsageError
from pgimp.physics.fields import PREFIX
from pgimp.physics.variation import NoValueError, Path, Places, Variation
from pgimp.physics.variation.find import Variations, names_of, replaced, split, value_at
from pgimp.schema.base import Model
from pgimp.schema.dispatch import plain
from pgimp.schema.problems import Problem, raise_problems

#: What a parameter may be that only a file knows, to find an entry that is sound; see `typical_of`.
_GUESSES = (1.0, 0.25, 1e3, 1e6, 1e9, 1e-3, 10.0, 1e-6, 30.0, 0.0)
#: Attempts to find one.
_MOST_GUESSES = 2000
#: Numbers of a table that are tried one by one when a case is read.
_MOST_TRIED = 2000
#: Where a layer begins in which all is, in any units.
_FAR_AWAY = -1e140
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
    entry, best = None, None
    guesses = itertools.product(*map(_guesses, variations.values()))
    for guess in itertools.islice(guesses, _MOST_GUESSES):
        typical = dict(zip(variations, guess, strict=True))
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


def _guesses(variation: Variation) -> list[float]:
    """Numbers of which one is typical: where that is wrong, some other may be right."""
    if (typical := variation.typical) is None:
        return [*_GUESSES]
    known = [value for _, value in variation.known()]
    return [typical, *known[:: max(1, len(known) // len(_GUESSES))]]


def _some(known: Sequence[tuple[Path, float]]) -> Iterable[tuple[Path, float]]:
    return known[:: max(1, -(-len(known) // _MOST_TRIED))]


def first_text(error: ValidationError) -> str:
    """What is wrong, as one sentence."""
    first = error.errors(include_url=False)[0]
    return first.get("ctx", {}).get("text") or first["msg"]


class Varying(Model):
    """Base of entries of which numbers may vary in space."""

    _variations: Variations = PrivateAttr(default_factory=dict)

    @model_validator(mode="wrap")
    @classmethod
    def _take_variations(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Take typical numbers in place of what varies in space, and keep how it does."""
        if not isinstance(data, dict) or not any(
            isinstance(value, Mapping | Variation) for value in data.values()
        ):
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
        keys = (lambda path: path) if info.by_alias else partial(names_of, type(self))
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
